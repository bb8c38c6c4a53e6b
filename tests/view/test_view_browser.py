"""The page in headless Chromium: clicks, keys, spinners, a saved page, the console."""

import re
import shutil
import subprocess
from urllib.parse import urlsplit

import numpy as np
import pytest
from sharded_study import PROGRAM, read_until

from vibropipe.store import load
from vibropipe.view.results import open_results
from vibropipe.view.save import save_page

DRIVER = shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(
    DRIVER is None, reason="needs Chromium (Debian: apt-get install chromium-driver)"
)
BY_NAME = "const named = (name) => [...Bokeh.documents[0]._all_models.values()].find(m => m.name == name);"
SPANS = (
    "const spans = [...Bokeh.documents[0]._all_models.values()].filter(m => m.type == 'Span');"
    "const upright = spans.find(s => s.dimension == 'height'), across = spans.find(s => s.dimension == 'width');"
)


@pytest.fixture(scope="module")
def browser():
    """Chromium that reaches this machine alone."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for each in ("headless=new", "no-sandbox", "window-size=1280,720",
                 "host-resolver-rules=MAP * ~NOTFOUND , EXCLUDE localhost"):  # fmt: skip
        options.add_argument(f"--{each}")
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    driver = webdriver.Chrome(options=options, service=Service(DRIVER))
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def address(study):
    command = [*PROGRAM, "view", str(study), "--no-browser", "--scene", "map"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        yield re.search(r"http\S+", read_until("http", process))[0]
        process.kill()


def opened(browser, address):
    from selenium.webdriver.support.ui import WebDriverWait

    browser.get(address)
    wait = WebDriverWait(browser, 30)
    wait.until(lambda b: b.execute_script("return window.Bokeh?.documents?.[0]?.is_idle === true"))
    return wait


def click(browser, nu, f):
    """Click on the map at a point, with the mouse."""
    from selenium.webdriver import ActionChains

    place = browser.execute_script(
        BY_NAME + "const view = Bokeh.index.find_one_by_id(named('map').id);"
        "const box = view.el.getBoundingClientRect();"
        f"return [box.x + view.frame.x_scale.compute({nu}), box.y + view.frame.y_scale.compute({f})]"
    )
    actions = ActionChains(browser)
    actions.w3c_actions.pointer_action.move_to_location(*map(round, place))
    actions.click().perform()


def jumps(browser):
    """The impacts that are drawn: times and velocities before them."""
    code = (
        BY_NAME + "const drawn = [...Bokeh.documents[0]._all_models.values()].find("
        "m => m.data && 'before' in m.data);"
        "return [Array.from(drawn.data.time), Array.from(drawn.data.before)]"
    )
    return [np.array(each, float) for each in browser.execute_script(code)]


def assert_console_is_clean(browser):
    assert [entry for entry in browser.get_log("browser") if entry["level"] == "SEVERE"] == []


def assert_shows(browser, wait, study, nu, f):
    row = load(study / "map.nc").sel(nu=[nu], f=[f], method="nearest")
    whole = load(study / "map.nc")
    sizes = whole["row_size"].values
    i, j = (int(np.argmin(np.abs(whole[n].values - v))) for n, v in (("nu", nu), ("f", f)))
    first = int(sizes.ravel()[: np.ravel_multi_index((i, j), sizes.shape)].sum())
    own = whole.isel(impact=slice(first, first + int(sizes[i, j])))
    time = (own["impact_period"] + own["impact_phase"]).values * 2 * np.pi / float(row["nu"][0])
    order = np.argsort(time)
    wait.until(
        lambda b: jumps(b)[0].size == time.size and np.allclose(jumps(b)[0], time[order], atol=1e-9)
    )
    np.testing.assert_allclose(jumps(browser)[1], own["impact_velocity"].values[order], atol=1e-9)


def test_clicks_keys_and_spinners(browser, address, study):
    from selenium.webdriver.common.keys import Keys

    wait = opened(browser, address)
    click(browser, 1.9, 1.5)
    assert_shows(browser, wait, study, 1.9, 1.5)
    browser.switch_to.active_element.send_keys(Keys.ARROW_RIGHT)
    assert_shows(browser, wait, study, 2.2, 1.5)
    before = browser.execute_script(BY_NAME + "return named('law').text")
    browser.execute_script(BY_NAME + "named('R1').value = 0.5")
    wait.until(lambda b: b.execute_script(BY_NAME + "return named('law').text") != before)
    assert "What if" in browser.execute_script(BY_NAME + "return named('law').text")
    assert_console_is_clean(browser)


def test_a_saved_page_works_from_the_file_system(browser, study, tmp_path):
    path = tmp_path / "page.html"
    save_page(open_results(study, study.parent, "map"), path)
    wait = opened(browser, path.as_uri())
    click(browser, 1.9, 1.5)
    assert_shows(browser, wait, study, 1.9, 1.5)
    assert_console_is_clean(browser)


def test_a_wrong_token_shows_nothing(browser, address):
    browser.get(f"http://localhost:{urlsplit(address).port}/?bokeh-session-id=wrong")
    assert not browser.execute_script("return window.Bokeh != null")
