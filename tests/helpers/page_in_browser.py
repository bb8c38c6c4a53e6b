"""The page of `vibropipe view` in headless Chromium.

`python tests/helpers/page_in_browser.py RESULTS [PICTURE]` measures its answers, and writes a picture of it.
"""

import random
import re
import shutil
import subprocess
import sys
import time
from statistics import median

from sharded_study import PROGRAM, read_until

DRIVER = shutil.which("chromedriver")
WIDTH, HEIGHT = 1280, 720
# Of what is shown: the document keeps the models of an old scene for a while.
BY_NAME = (
    "const all = Bokeh.documents[0].roots().flatMap((root) => [...root.references()]);"
    "const named = (name) => all.find((model) => model.name == name);"
    "const view = (name) => Bokeh.index.find_one_by_id(named(name).id);"
)
# Milliseconds from the button of the mouse to the frame that has the motion, for each click.
ANSWERS = """
window.answers = []
let since = null
const drawn = all.find((model) => model.data && 'before' in model.data)
document.addEventListener('pointerup', () => { since = performance.now() }, true)
drawn.properties.data.change.connect(() => requestAnimationFrame(() => setTimeout(() => {
  if (since != null) window.answers.push(performance.now() - since)
  since = null
})))
"""
# Milliseconds of each of 40 frames in which the map is moved.
PAN = """
const done = arguments[0], range = named('map').x_range, {start, end} = range, times = []
let last = performance.now()
const step = () => {
  times.push(performance.now() - last)
  last = performance.now()
  const shift = 0.2 * (end - start) * Math.sin(times.length / 6)
  range.setv({start: start + shift, end: end + shift})
  if (times.length < 40) requestAnimationFrame(step)
  else done(times)
}
requestAnimationFrame(step)
"""


def new_browser():
    """Return a driver of Chromium that reaches this machine alone."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for each in ("headless=new", "no-sandbox", "window-size=1280,720",
                 "host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE localhost"):  # fmt: skip
        options.add_argument(f"--{each}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    screen = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": 1, "mobile": False}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", screen)
    return driver


def opened(browser, address):
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get(address)
    wait = WebDriverWait(browser, 30)
    wait.until(lambda b: b.execute_script("return window.Bokeh?.documents?.[0]?.is_idle === true"))
    return wait


def place_of(browser, nu, f):
    """Return where a point of the map is on the screen."""
    return browser.execute_script(
        BY_NAME + "const map = view('map'), box = map.el.getBoundingClientRect();"
        f"return [box.x + map.frame.x_scale.compute({nu}), box.y + map.frame.y_scale.compute({f})]"
    )


def click(browser, nu, f, to=None):
    """Click on the map at a point, with the mouse; or drag it from there to another point."""
    from selenium.webdriver import ActionChains

    actions = ActionChains(browser)
    pointer = actions.w3c_actions.pointer_action
    pointer.move_to_location(*map(round, place_of(browser, nu, f)))
    if to is None:
        pointer.click()
    else:
        pointer.pointer_down()
        pointer.move_to_location(*map(round, place_of(browser, *to)))
        pointer.pointer_up()
    actions.perform()


def measure(browser, clicks=40):
    """Return the median time of a click on the map, and of a frame while it is moved, in milliseconds."""
    get = (
        BY_NAME
        + "const m = named('map'); return [m.x_range.start, m.x_range.end, m.y_range.start, m.y_range.end]"
    )
    left, right, low, high = browser.execute_script(get)
    browser.execute_script(BY_NAME + ANSWERS)
    chance = random.Random(1)
    for _ in range(clicks):
        click(browser, chance.uniform(left, right), chance.uniform(low, high))
        time.sleep(0.4)
    answers = browser.execute_script("return window.answers")
    return median(answers), median(browser.execute_async_script(BY_NAME + PAN))


def main(results, picture=None):
    """Print what is measured of the page of a folder of results."""
    with subprocess.Popen(
        [*PROGRAM, "view", results, "--no-browser"], stdout=subprocess.PIPE, text=True
    ) as process:
        address = re.search(r"http\S+", read_until("http", process))[0]
        browser = new_browser()
        try:
            since = time.monotonic()
            opened(browser, address)
            print(f"opened in {time.monotonic() - since:.1f} s")
            if picture is not None:
                time.sleep(2)
                browser.save_screenshot(picture)
            answer, frame = measure(browser)
            print(
                f"click to drawn motion: {answer:.0f} ms; a frame while the map is moved: {frame:.0f} ms (medians)"
            )
        finally:
            browser.quit()
            process.kill()


if __name__ == "__main__":
    main(*sys.argv[1:])
