"""A page in headless Chromium."""

import shutil
import time
from pathlib import Path

import pytest

# Containers have little shared memory, and no user of their own.
CONTAINERS = ["--no-sandbox", "--disable-dev-shm-usage"]
SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
PATIENCE = 60  # [s]


class Browser:
    """One page at a time; use it as a context."""

    def __init__(self):
        webdriver = pytest.importorskip("selenium.webdriver")
        exceptions = pytest.importorskip("selenium.common.exceptions")
        program, driver = shutil.which("chromium"), shutil.which("chromedriver")
        if program is None or driver is None:
            pytest.skip("Chromium and its driver (chromium, chromium-driver) are not installed")
        options = webdriver.ChromeOptions()
        options.binary_location = program
        for argument in ["--headless=new", "--hide-scrollbars", *CONTAINERS, *SOFTWARE_GL]:
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        service = webdriver.ChromeService(driver)
        try:
            self.driver = webdriver.Chrome(options=options, service=service)
        except exceptions.WebDriverException as error:
            pytest.skip(f"Chromium does not start here: {error.msg}")
        self.driver.set_script_timeout(PATIENCE)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.driver.quit()

    def open(self, file, place="", size=(1280, 800)):
        """Shows a page, and waits until it has read its data."""
        self.driver.execute_cdp_cmd(
            "Emulation.setDeviceMetricsOverride",
            {"width": size[0], "height": size[1], "deviceScaleFactor": 1, "mobile": size[0] < 600},
        )
        self.driver.get("about:blank")  # the same file with another place is no new page
        self.driver.get(Path(file).absolute().as_uri() + place)
        end = time.monotonic() + PATIENCE
        while not self.run("return document.body.dataset.ready === 'true'"):
            said = self.run("return document.getElementById('message').textContent")
            assert not said.startswith("This page cannot"), said
            assert time.monotonic() < end, "the page is not ready"
            time.sleep(0.05)

    def run(self, script, *arguments):
        return self.driver.execute_script(script, *arguments)

    def text(self, name):
        """The text of the element of that id."""
        return self.run("return document.getElementById(arguments[0]).innerText", name)

    def click(self, x, y):
        """A click at pixels of the scene."""
        from selenium.webdriver.common.action_chains import ActionChains

        canvas = self.driver.find_element("id", "canvas")
        wide, high = canvas.size["width"], canvas.size["height"]
        mouse = ActionChains(self.driver, duration=0)
        mouse.move_to_element_with_offset(canvas, round(x - wide / 2), round(y - high / 2))
        mouse.click().perform()

    def complaints(self):
        """What the console has said of errors and warnings since it was last asked."""
        return [
            entry
            for entry in self.driver.get_log("browser")
            if entry["level"] in ("SEVERE", "WARNING") and "GPU stall" not in entry["message"]
        ]
