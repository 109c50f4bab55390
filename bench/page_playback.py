#!/usr/bin/env python3
"""How fast a page plays in headless Chromium, which draws by software: page_playback.py PAGE [WIDTH HEIGHT]

Needs Chromium, its driver and Selenium. Prints the page's size, how long it takes until the page is
ready, how many frames a second it shows while it plays, of the 60 that Chromium has, and how long
a frame takes with all that is drawn, as JSON.

    pierce run tori --count 100 --seconds 10 --html pile.html
    bench/page_playback.py pile.html 640 400
"""

import json
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "python" / "tests"))
from browser import Browser

SECONDS = 4
COUNT = """
const [seconds, done] = arguments, refresh = player.refresh.bind(player), begin = performance.now();
let frames = 0, work = 0;
player.refresh = () => { const t = performance.now(); refresh(); work += performance.now() - t; ++frames; };
player.play();
setTimeout(() => {
  const passed = (performance.now() - begin) / 1000, gl = player.stage.renderer.getContext();
  done({frames_per_second: frames / passed, script_ms_per_frame: work / frames, shown_to: player.frame,
        pixels: [gl.drawingBufferWidth, gl.drawingBufferHeight]});
}, 1000 * seconds);
"""
WORK = """
const gl = player.stage.renderer.getContext(), pixel = new Uint8Array(4), [frames] = arguments;
const wait = () => gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
player.bodies.coarse = player.playing = true;
const first = Math.floor(player.data.frameCount / 3), begin = performance.now();
for (let k = 1; k <= frames; ++k) { player.go(first + k); wait(); }
player.playing = false;
return (performance.now() - begin) / frames;
"""
FRAMES = 200


def main(page, width=640, height=400):
    with Browser() as browser:
        begin = time.monotonic()
        browser.open(page, "", (int(width), int(height)))
        ready = time.monotonic() - begin
        browser.run("player.go(Math.floor(player.data.frameCount / 3))")
        found = browser.driver.execute_async_script(COUNT, SECONDS)
        browser.run("player.pause()")
        found["work_ms_per_frame"] = round(browser.run(WORK, FRAMES), 2)
    print(json.dumps({"bytes": Path(page).stat().st_size, "ready_s": round(ready, 2), **found}))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    main(*sys.argv[1:])
