"""Pages in a browser: they show what the command writes, play, explain, and ask for no network."""

import gc
import json
import math
import os
import subprocess
import threading
import time
import weakref

import numpy as np
import pierce
import pytest
from browser import Browser
from conftest import box, torus

COMMAND = os.environ.get("PIERCE_COMMAND")
HOSTILE = "</title></script><script>hacked = true</script><b>$'\"{}"


def command(*arguments):
    if COMMAND is None:
        pytest.skip("the command is not built")
    subprocess.run([COMMAND, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL)


@pytest.fixture(scope="module")
def browser():
    with Browser() as browser:
        yield browser


@pytest.fixture(scope="module")
def pile(tmp_path_factory):
    """The page and the JSON of a small pile."""
    folder = tmp_path_factory.mktemp("pile")
    command(
        *("run", "tori", "--count", 12, "--seconds", 1.5, "--threads", 1),
        *("--html", folder / "pile.html", "--json", folder / "pile.json"),
        *("--record", folder / "motion"),
    )
    command("replay", folder / "motion", "--threads", 1, "--html", folder / "replay.html")
    return folder


def contacts_on_page(browser, frame):
    return browser.run(
        "const [begin, end] = player.data.contactRange(arguments[0]);"
        "return Array.from({length: end - begin}, (_, k) => player.data.contact(arguments[0], k))",
        frame,
    )


def test_frames_are_those_of_json(browser, pile):
    browser.open(pile / "pile.html")
    frames = json.loads((pile / "pile.json").read_text())["frames"]
    assert len(frames) == 90
    assert browser.run("return player.data.figures") == frames
    counts = [len(contacts_on_page(browser, k)) for k in (0, 50, 89)]
    assert counts == [frames[k]["contacts"] for k in (0, 50, 89)] and counts[-1] > 20
    assert browser.complaints() == []


def test_contacts_are_those_of_json(browser, tmp_path):
    files = []
    for k, (vertices, triangles) in enumerate([torus(), torus()]):
        turned = vertices + np.float32([0.9 * k, 0, 0.2 * k])
        lines = [f"v {x} {y} {z}" for x, y, z in turned]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
        files.append(tmp_path / f"{k}.obj")
        files[-1].write_text("\n".join(lines))
    command("detect", *files, "--html", tmp_path / "a.html", "--json", tmp_path / "a.json")
    expected = json.loads((tmp_path / "a.json").read_text())["contacts"]
    browser.open(tmp_path / "a.html")
    found = contacts_on_page(browser, 0)
    assert len(expected) > 50
    for record in found:
        del record["age"]  # of one step, which is zero
    assert found == expected


def test_a_click_selects_and_explains(browser, pile):
    browser.open(pile / "replay.html", "#f=89")
    assert "Frame 89 has" in browser.text("details")
    # A contact that no other one covers on the screen.
    number, x, y = browser.run(
        "const seen = player.contacts.shown.map("
        "  ({number, at}) => [number, ...player.stage.pixelsOf(at)]);"
        "const alone = ([n, x, y]) => seen.every("
        "  ([m, u, v]) => n === m || Math.hypot(u - x, v - y) > 12);"
        "return seen.find(alone)"
    )
    browser.click(x, y)
    assert browser.run("return player.selection.contact") == number
    said, c = browser.text("details"), contacts_on_page(browser, 89)[number]
    assert f"Contact {number} of frame 89" in said
    assert f"deep at triangle {c['triangle']}" in said and str(c["distance"]) in said
    assert browser.run("return location.hash") == f"#f=89&c={number}"
    # A vertex without a contact, on a body that has one.
    body, vertex = browser.run(
        "const c = player.data.columns, first = c.reason_begin[89];"
        "return [c.reason_body[first], c.reason_vertex[first]]"
    )
    browser.run("player.select({body: arguments[0], vertex: arguments[1]})", body, vertex)
    page = browser.text("details")
    other = browser.run("return player.data.reasonsOf(89, ...arguments)[0].other", body, vertex)
    asked = ["--frame", 89, "--bodies", body, other, "--vertex", vertex, "--threads", 1]
    answer = subprocess.run(
        [str(part) for part in (COMMAND, "explain", pile / "motion", *asked)],
        capture_output=True,
        text=True,
        check=True,
    ).stdout
    reason = answer.strip().splitlines()[-1]
    assert reason.startswith("No contact") and reason in page
    assert f"pierce explain '{pile / 'motion'}' --frame 89 --bodies {body}" in page
    # A click on a body selects its nearest vertex.
    x, y = browser.run(
        "const { data, stage, bodies, contacts } = player;"
        "for (let v = 0; ; ++v) {"
        "  const [x, y] = stage.pixelsOf(data.vertexAt(89, 1, v)).map(Math.round);"
        "  const hits = [-1, 0, 1].map("  # a click is at a whole pixel
        "    (d) => bodies.pick(89, ...stage.sight(x + d, y + d))?.body === 1);"
        "  if (hits.every(Boolean) && stage.contactAt(contacts, x, y) === undefined)"
        "    return [x, y];"
        "}"
    )
    browser.click(x, y)
    assert browser.run("return player.selection.body") == 1
    assert "Vertex" in browser.text("details")
    assert browser.complaints() == []


def test_it_plays_and_steps_by_keys(browser, pile):
    from selenium.webdriver.common.keys import Keys

    browser.open(pile / "pile.html", "#f=12&c=0")
    body = browser.driver.find_element("tag name", "body")
    frame = "return player.frame"
    assert browser.run(frame) == 12
    for key, expected in [
        (Keys.ARROW_RIGHT, 13),
        (Keys.ARROW_LEFT, 12),
        (Keys.END, 89),
        (Keys.HOME, 0),
    ]:
        body.send_keys(key)
        assert browser.run(frame) == expected
    body.send_keys(" ")
    browser.driver.execute_async_script(
        "const [done] = arguments;"
        "const wait = () => player.playing ? requestAnimationFrame(wait) : done();"
        "wait()"
    )
    assert browser.run(frame) == 89
    assert "89 / 89" in browser.text("frame")
    for key, name in [
        ("r", "contacts.showRays"),
        ("b", "overlays.showBoxes"),
        ("g", "overlays.showPatches"),
    ]:
        before = browser.run(f"return player.{name}")
        body.send_keys(key)
        assert browser.run(f"return player.{name}") != before
    assert browser.complaints() == []


def test_filters_search_and_charts(browser, pile):
    browser.open(pile / "pile.html", "#f=89")
    total = browser.run("return player.contacts.shown.length")
    browser.run("player.filters.edges = false; player.refresh()")
    vertices = browser.run("return player.contacts.shown.length")
    kinds = [("edge_end" in c) for c in contacts_on_page(browser, 89)]
    assert vertices == kinds.count(False) and total == len(kinds)
    browser.run("player.filters.bodies[0] = 1; player.refresh()")
    assert browser.run("return player.contacts.shown.length") == sum(
        1 in (c["a"], c["b"]) and "edge_end" not in c for c in contacts_on_page(browser, 89)
    )
    for asked, selection in [
        ("c0", {"contact": 0}),
        ("b3", {"body": 3}),
        ("v3:7", {"body": 3, "vertex": 7}),
        ("torus 3", {"body": 4}),
    ]:
        browser.run("player.search(arguments[0])", asked)
        assert browser.run("return player.selection") == selection
    browser.run("player.search('nothing')")
    assert "There is no" in browser.text("message")
    browser.run("player.showTab('charts')")
    assert browser.run("return player.charts.charts.length") == 3
    # As a scrollbar does, which later charts may bring.
    browser.run("document.getElementById('charts').style.paddingRight = '60px'")
    time.sleep(0.5)
    left, place = browser.run(
        """const { chart, cursor } = player.charts.charts[0];
        return [parseFloat(cursor.style.left), chart.scales.x.getPixelForValue(player.frame)];"""
    )
    assert abs(left - place) < 1
    x = browser.run("return player.charts.charts[0].chart.scales.x.getPixelForValue(30)")
    browser.run("player.charts.charts[0].chart.options.onClick({x: arguments[0]})", x)
    assert browser.run("return player.frame") == 30
    assert browser.complaints() == []


@pytest.mark.parametrize("size", [(1600, 900), (800, 600), (390, 800)])
def test_it_fits(browser, pile, size):
    browser.open(pile / "pile.html", "#f=89&c=3", size)
    assert browser.run("return document.documentElement.scrollWidth <= innerWidth")
    wide, high = browser.run(
        "const box = document.getElementById('canvas').getBoundingClientRect();"
        "return [box.width, box.height]"
    )
    assert wide >= min(size[0] - 460, 390) and high > size[1] / 3
    # Something else than the background is drawn.
    colors = browser.run(
        "player.stage.draw();"
        "const gl = player.stage.renderer.getContext(), px = new Uint8Array(4 * 64 * 64);"
        "const x = gl.drawingBufferWidth / 2 - 32, y = gl.drawingBufferHeight / 2 - 32;"
        "gl.readPixels(x, y, 64, 64, gl.RGBA, gl.UNSIGNED_BYTE, px);"
        "return new Set(new Uint32Array(px.buffer)).size"
    )
    assert colors > 20
    assert browser.complaints() == []


def test_hostile_names_are_text_and_nothing_is_fetched(browser, tmp_path):
    world = pierce.World(threads=1)
    mesh = world.add_mesh(box(), name=HOSTILE)
    bodies = [world.add_rigid_body(mesh, [0, 0, z, 0, 0, 0, 1]) for z in (0, 0.9)]
    page = pierce.Page(world, title=HOSTILE, names={bodies[0]: HOSTILE})
    world.detect()
    page.add(**{HOSTILE: 1.0})
    page.write(str(tmp_path / "hostile.html"), settings={HOSTILE: HOSTILE})
    browser.open(tmp_path / "hostile.html", "#f=0&b=0")
    assert browser.run("return typeof hacked") == "undefined"
    assert browser.text("title") == HOSTILE and browser.driver.title == HOSTILE
    assert HOSTILE in browser.text("details")
    browser.run("player.showTab('about')")
    assert HOSTILE in browser.text("about") and "vertex_cull" in browser.text("about")
    assert browser.run("return document.querySelectorAll('#about b, #details b').length") == 0
    fetched = browser.run("return performance.getEntriesByType('resource').map((r) => r.name)")
    assert [name for name in fetched if not name.startswith("data:")] == []
    assert browser.complaints() == []


def test_many_contacts_are_rounded_as_the_page_says(browser, tmp_path):
    world = pierce.World(threads=1)
    mesh = world.add_mesh(torus(around=160, across=80))
    world.add_rigid_body(mesh)
    turned = world.add_rigid_body(mesh)
    page, lists = pierce.Page(world, reasons=False), []
    for k in range(30):
        world.set_pose(turned, [0.1 + 0.01 * k, 0.02, 0.1, 0.1, 0.2, 0, 1])
        lists.append(world.detect())
        page.add()
    page.write(str(tmp_path / "many.html"))
    browser.open(tmp_path / "many.html")
    assert browser.run("return player.data.rounded")
    found, exact = contacts_on_page(browser, 17), lists[17]
    assert len(found) == len(exact) > 1000
    np.testing.assert_array_equal([c["vertex"] for c in found], exact.vertex)
    np.testing.assert_array_equal([c["triangle"] for c in found], exact.triangle)
    np.testing.assert_allclose([c["distance"] for c in found], exact.distance, rtol=1e-7)
    for name in ("point_a", "point_b"):
        np.testing.assert_allclose([c[name] for c in found], getattr(exact, name), atol=5e-6)
    np.testing.assert_allclose([c["normal"] for c in found], exact.normal, atol=1e-4)
    assert os.path.getsize(tmp_path / "many.html") < 12e6
    assert browser.complaints() == []


@pytest.mark.parametrize("reasons", [True, False])
def test_places_and_contacts_are_of_one_step(two_tori, reasons):
    world, rigid, _, _ = two_tori
    page = pierce.Page(world, reasons=reasons)
    with pytest.raises(pierce.InputError, match="after detect"):
        page.add()
    world.detect()
    page.add()
    world.set_pose(rigid, [0.1, 0, 0, 0, 0, 0, 1])
    with pytest.raises(pierce.InputError, match="moved"):
        page.add()
    assert page.frame_count == 1


def test_numbers_that_are_none_are_refused(two_tori):
    world = two_tori[0]
    world.detect()
    page = pierce.Page(world)
    with pytest.raises(pierce.InputError, match="not finite"):
        page.add(gap=float("inf"))


def test_sheets_and_bodies_that_come_and_go(browser, tmp_path):
    world = pierce.World(threads=1)
    solid = world.add_mesh(box())
    sheet = world.add_mesh(
        (np.float32([[0, 0, 0.52], [1, 0, 0.52], [0, 1, 0.52]]), np.uint32([[0, 1, 2]]))
    )
    below = world.add_fixed_body(solid)
    cloth = world.add_deforming_body(sheet)
    world.set_collision(cloth, pierce.Collision(sheet=True, thickness=0.05))
    page = pierce.Page(world)
    world.detect()
    page.add()
    extra = world.add_rigid_body(solid, [0.5, 0, 0.9, 0, 0, 0, 1])
    world.detect()
    page.add()
    world.remove_body(extra)
    world.detect()
    page.add()
    page.write(str(tmp_path / "sheet.html"))
    browser.open(tmp_path / "sheet.html")
    assert page.frame_count == 3 and below.index == 0
    there = "return player.data.meshOf(arguments[0], 2) !== undefined"
    assert [browser.run(there, k) for k in range(3)] == [False, True, False]
    browser.run("player.bodies.showGhosts = true; player.go(1); player.go(2)")
    assert len(contacts_on_page(browser, 0)) > 0
    browser.run("player.go(0); player.select({body: 1, vertex: 0})")
    said = browser.text("details")
    assert "Why it has no contact" in said or "Its contacts" in said
    assert "not on this page" not in said
    assert browser.complaints() == []


def test_what_explains_a_vertex_asks_as_the_page_was_made(browser, pile):
    command(
        *("replay", pile / "motion", "--threads", 1, "--html", pile / "vertices.html"),
        *("--coverage", "vertices", "--reproject", "off", "--margin", 0.125, "--inside", "closed"),
    )
    browser.open(pile / "vertices.html", "#f=3&v=1:0")
    options = "--coverage vertices --reproject off --margin 0.125 --inside closed"
    assert f"pierce explain '{pile / 'motion'}' {options} --frame 3" in browser.text("details")


def test_left_out_bodies_names_and_vertices_that_are_no_more(browser, tmp_path):
    world = pierce.World(threads=1)
    mesh = world.add_mesh(box(), name="box")
    first, second = (world.add_rigid_body(mesh) for _ in range(2))
    world.set_filter(second, pierce.Filter(world=3))
    page = pierce.Page(world, names={first: "drone"})
    world.set_world_active(3, False)
    world.detect()
    page.add()
    world.remove_body(first)
    later = world.add_rigid_body(world.add_mesh(torus(), name="ring"))
    world.detect()
    page.add()
    world.set_mesh(later, mesh)
    world.detect()
    page.add()
    page.write(str(tmp_path / "bodies.html"))
    browser.open(tmp_path / "bodies.html", "#f=0&v=1:0")
    assert "the body was left out of the step" in browser.text("details")
    browser.run("player.select({body: 0, vertex: 0})")
    assert "outside of the boxes of all other bodies of the step" in browser.text("details")
    names = browser.run("return player.data.bodies.map((body) => body.name)")
    assert names == ["drone", "box", "ring"]
    browser.run("player.go(2); player.select({body: 2, vertex: 40})")
    assert "no such vertex in this frame" in browser.text("details")
    browser.run("player.lookAtSelection(); player.go(0); player.lookAtSelection()")
    assert "not there in this frame" in browser.text("details")
    assert browser.run("return player.stage.sight(10, 10).flat().every(Number.isFinite)")
    assert browser.complaints() == []


def test_nobody_adds_a_frame_while_a_page_is_written(tmp_path):
    world = pierce.World("embree", 1)
    for _ in range(20):
        world.add_rigid_body(world.add_mesh(torus()))
    world.detect()
    page = pierce.Page(world)
    for _ in range(30):
        page.add(number=np.int64(3), real=np.float32(0.5))
    done = threading.Event()

    def write():
        for place in range(5):
            page.write(tmp_path / f"{place}.html")
        done.set()

    writer = threading.Thread(target=write)
    writer.start()
    refused = 0
    while not done.is_set():
        try:
            page.add()
        except RuntimeError:
            refused += 1
    writer.join()
    assert refused > 0


def test_what_a_page_cannot_hold():
    world = pierce.World("embree", 1)
    body = world.add_rigid_body(world.add_mesh(box()))
    world.detect()
    page = pierce.Page(world, names={body: "box"})
    with pytest.raises(TypeError, match="no number, text, list or dict"):
        page.add(thing=object())
    with pytest.raises(TypeError, match="bodies and strings"):
        pierce.Page(world, names={"box": "box"})
    for nobody in (pierce.BodyId(), pierce.BodyId(7), pierce.BodyId(0xFFFFFFFF)):
        with pytest.raises(pierce.InputError):
            pierce.Page(world, names={nobody: "nobody"})
    for value in (10**400, "\ud800", [{"deep": -(10**309)}]):
        with pytest.raises(pierce.InputError, match="beyond float64, or no Unicode"):
            page.add(thing=value)


def test_figures_of_some_frames_are_a_line(browser, tmp_path, two_tori):
    world = two_tori[0]
    page = pierce.Page(world)
    for frame in range(9):
        world.detect()
        page.add(**({"error": {"missed": 0.5 + frame}} if frame % 4 == 0 else {}))
    page.write(tmp_path / "some.html")
    browser.open(tmp_path / "some.html")
    browser.run("player.showTab('charts')")
    # A pixel between two frames whose figure is known has the line's colour.
    assert browser.run(
        """const { chart } = player.charts.charts.find(({ chart }) =>
             chart.data.datasets.some((d) => d.label === "missed"));
        const x = chart.scales.x.getPixelForValue(2), y = chart.scales.y.getPixelForValue(2.5);
        const scale = chart.currentDevicePixelRatio, r = 3 * scale;
        const pixels = chart.ctx.getImageData(x * scale - r, y * scale - r, 2 * r, 2 * r).data;
        const line = chart.data.datasets[0].borderColor;
        const [red, green, blue] = [1, 3, 5].map((k) => parseInt(line.slice(k, k + 2), 16));
        return pixels.some((_, i) => i % 4 === 0 && Math.abs(pixels[i] - red) < 24 &&
          Math.abs(pixels[i + 1] - green) < 24 && Math.abs(pixels[i + 2] - blue) < 24 &&
          pixels[i + 3] > 128);"""
    )
    assert browser.complaints() == []


def test_a_page_without_frames_is_none(tmp_path, two_tori):
    world = two_tori[0]
    with pytest.raises(pierce.InputError, match="no frames"):
        pierce.Page(world).write(tmp_path / "none.html")
    for dt in (-1.0, math.nan, math.inf):
        with pytest.raises(pierce.InputError, match="dt"):
            pierce.Page(world, dt=dt)


def test_what_a_filter_raises_comes_out_of_the_call_that_asks_it(two_tori):
    world, *_ = two_tori

    asks = []

    def fails_from_the_second_step(a, b):
        if asks:
            raise KeyError("mine")
        return True

    world.set_pair_filter(fails_from_the_second_step)
    world.detect()
    page = pierce.Page(world)
    page.add()
    asks.append(1)
    with pytest.raises(KeyError, match="mine"):
        page.add()
    asks.clear()
    page.add()


def test_a_filter_that_holds_a_page_is_collected():
    class Holder:
        def __init__(self):
            world = pierce.World("reference")
            self.page = pierce.Page(world)
            world.set_pair_filter(self.wants)

        def wants(self, a, b):
            return True

    gone = weakref.ref(Holder())
    gc.collect()
    assert gone() is None
