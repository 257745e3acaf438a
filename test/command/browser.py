"""Opens a page in Chromium, without a display, and watches what it does."""

import json
import pathlib
import sys
import time
import unittest

from command import SANITIZED

# Debian's package is for Debian's Python, which need not be the one that runs the tests; it is all Python.
sys.path.append("/usr/lib/python3/dist-packages")
try:
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.common.by import By
except ImportError:
    webdriver = None

CHROMIUM, DRIVER = pathlib.Path("/usr/bin/chromium"), pathlib.Path("/usr/bin/chromedriver")
IS_INSTALLED = webdriver is not None and CHROMIUM.exists() and DRIVER.exists()

# How many pixels of the clouds' colours the view shows, and its picture.
SEEN = """
  const { renderer, scene, camera } = document.querySelector('.scene').scene;
  renderer.render(scene, camera);
  const gl = renderer.getContext(), width = gl.drawingBufferWidth, height = gl.drawingBufferHeight;
  const pixels = new Uint8Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
  const count = (r, g, b) => {
    let sum = 0;
    for (let i = 0; i < pixels.length; i += 4)
      sum += Math.abs(pixels[i] - r) + Math.abs(pixels[i + 1] - g) + Math.abs(pixels[i + 2] - b) < 30;
    return sum;
  };
  return { source: count(0xe6, 0x9f, 0), target: count(0, 0x72, 0xb2), second: count(0xcc, 0x79, 0xa7),
           undetermined: count(0xb3, 0x26, 0x1e), picture: renderer.domElement.toDataURL() };"""


class Page:
    def __init__(self, driver):
        self.driver = driver

    def run(self, script):
        return self.driver.execute_script(script)

    def text(self, selector):
        return self.run(f"return document.querySelector({json.dumps(selector)}).textContent")

    def press(self, key):
        self.driver.find_element(By.TAG_NAME, "body").send_keys(key)

    def click(self, selector):
        self.driver.find_element(By.CSS_SELECTOR, selector).click()

    def seen(self):
        return self.run(SEEN)

    def wait_for(self, expression):
        end = time.monotonic() + 20
        while not self.run(f"return {expression}"):
            assert time.monotonic() < end, f"{expression} did not come true"
            time.sleep(0.05)

    def is_too_wide(self):
        return self.run("return document.documentElement.scrollWidth > innerWidth")

    def console(self):
        return [entry["message"] for entry in self.driver.get_log("browser")]

    def requests(self):
        """What was asked for but the page itself and what it has in it."""
        events = [json.loads(entry["message"])["message"] for entry in self.driver.get_log("performance")]
        asked = [event["params"]["request"]["url"] for event in events if event["method"] == "Network.requestWillBeSent"]
        return [url for url in asked if url != self.driver.current_url and not url.startswith(("data:", "blob:"))]


def start(width, flags):
    options = webdriver.ChromeOptions()
    options.binary_location = str(CHROMIUM)
    # WebGL without a GPU; no sandbox, which root has not; shared memory may be small in a container.
    for flag in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--use-gl=angle", "--use-angle=swiftshader",
                 "--enable-unsafe-swiftshader", "--window-size=1280,900", *flags):
        options.add_argument(flag)
    if width != 1280:
        options.add_experimental_option(
            "mobileEmulation", {"deviceMetrics": {"width": width, "height": 844, "pixelRatio": 2.0}})
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(service=Service(str(DRIVER)), options=options)
    driver.set_script_timeout(120)  # seconds: without a GPU, on cores that are shared, a picture takes its time
    return driver


running = {}


def opened(path, width=1280, flags=()):
    """The page of a file, in a browser that stays for the next one until close_all().

    Under a sanitizer, which has seen all when the page is written, a test goes no further."""
    if SANITIZED:
        raise unittest.SkipTest("a browser knows nothing of sanitizers")
    key = width, tuple(flags)
    if key not in running:
        running[key] = start(*key)
    page = Page(running[key])
    for log in ("browser", "performance"):
        page.driver.get_log(log)  # forgets what the page before did
    page.driver.get(pathlib.Path(path).resolve().as_uri())
    return page


def close_all():
    while running:
        running.popitem()[1].quit()
