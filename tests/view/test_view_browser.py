"""The page in headless Chromium: clicks, keys, spinners, a saved page, the console."""

import re
import subprocess
from dataclasses import replace
from urllib.parse import urlsplit

import numpy as np
import pytest
from page_in_browser import BY_NAME, DRIVER, HEIGHT, WIDTH, click, new_browser, opened
from sharded_study import PROGRAM, read_until

import vibropipe as vp
from vibropipe.store import load
from vibropipe.view.results import open_results
from vibropipe.view.save import save_page

pytestmark = pytest.mark.skipif(
    DRIVER is None, reason="needs Chromium (Debian: apt-get install chromium-driver)"
)


@pytest.fixture(scope="module")
def browser():
    driver = new_browser()
    yield driver
    driver.quit()


@pytest.fixture(scope="module")
def address(study):
    command = [*PROGRAM, "view", str(study), "--no-browser", "--scene", "map"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        yield re.search(r"http\S+", read_until("http", process))[0]
        process.kill()


def write_into(browser, spinner, text):
    """Write a value into a spinner, as with the keyboard."""
    from selenium.webdriver.common.keys import Keys

    code = BY_NAME + f"return view('{spinner}').shadow_el.querySelector('input')"
    field = browser.execute_script(code)
    field.send_keys(
        Keys.END, *[Keys.BACKSPACE] * len(field.get_attribute("value")), text, Keys.ENTER
    )


def law(browser):
    return browser.execute_script(BY_NAME + "return named('law').text")


def jumps(browser):
    """The impacts that are drawn: times and velocities before them."""
    code = (
        BY_NAME + "const drawn = all.find((model) => model.data && 'before' in model.data);"
        "return [Array.from(drawn.data.time), Array.from(drawn.data.before)]"
    )
    return [np.array(each, float) for each in browser.execute_script(code)]


def assert_console_is_clean(browser):
    """No errors, and no warnings but those of the browser's own graphics."""
    entries = [entry for entry in browser.get_log("browser") if "GL" not in entry["message"]]
    assert [entry for entry in entries if entry["level"] not in ("INFO", "DEBUG")] == []


def assert_fits(browser):
    """The page needs no scroll bar, and no panel is cut off."""
    size = "const page = document.scrollingElement; return [page.scrollWidth, page.scrollHeight]"
    assert browser.execute_script(size) == [WIDTH, HEIGHT]


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


def test_clicks_drags_and_keys(browser, address, study):
    from selenium.webdriver.common.keys import Keys

    wait = opened(browser, address)
    assert_fits(browser)
    click(browser, 1.9, 1.5)
    assert_shows(browser, wait, study, 1.9, 1.5)
    for keys, nu, f in [
        ((Keys.ARROW_RIGHT,), 2.2, 1.5), ((Keys.ARROW_DOWN,), 2.2, 1.3),
        ((Keys.SHIFT, Keys.ARROW_UP), 2.2, 1.9),
    ]:  # fmt: skip
        browser.switch_to.active_element.send_keys(*keys)
        assert_shows(browser, wait, study, nu, f)
    click(browser, 1.0, 0.7, to=(1.6, 0.9))
    assert_shows(browser, wait, study, 1.6, 0.9)
    asked = (
        "return performance.getEntriesByType('resource').map((entry) => new URL(entry.name).host)"
    )
    assert set(browser.execute_script(asked)) <= {urlsplit(address).netloc}
    assert_console_is_clean(browser)


def test_a_spinner_shows_what_the_stored_motion_settles_on(browser, address, study):
    wait = opened(browser, address)
    click(browser, 1.9, 1.5)
    assert_shows(browser, wait, study, 1.9, 1.5)
    row = load(study / "map.nc").sel(nu=1.9, f=1.5, method="nearest")
    values = {name: float(row[name]) for name in ("l", "nu", "f", "h", "delta", "R2")}
    start = {"x0": float(row["displacement_strobe"]), "v0": float(row["velocity_strobe"])}
    expected = vp.steady_state(vp.Exciter(**values, R1=0.5), **start)
    write_into(browser, "R1", "0.5")
    wait.until(lambda b: "What if R₁ = 0.5" in law(b))
    shown = np.sort(expected["impact_velocity"].values)
    wait.until(
        lambda b: (
            jumps(b)[1].size == shown.size and np.allclose(np.sort(jumps(b)[1]), shown, atol=1e-9)
        )
    )
    assert_console_is_clean(browser)


def test_every_scene_fits_and_keeps_the_console_clean(browser, address):
    wait = opened(browser, address)
    for scene in ("both_ways", "starts", "map"):
        browser.execute_script(BY_NAME + f"named('scene').value = '{scene}'")
        is_map = "true" if scene != "both_ways" else "false"
        wait.until(
            lambda b, is_map=is_map: b.execute_script(
                BY_NAME + f"return (named('map') != null) == {is_map} && view('slice_x') != null"
            )
        )
        assert_fits(browser)
    chosen = (
        "const menu = named('quantity'), name = menu.options.find(o => o.startsWith('constant'));"
    )
    choose = BY_NAME + chosen + "if (name != null) menu.value = name; return name != null"
    wait.until(lambda b: b.execute_script(choose))
    top = "const top = (plot) => plot.el.getBoundingClientRect().y + plot.frame.bbox.top;"
    tops = BY_NAME + top + "return ['map', 'slice_y'].map((name) => top(view(name)))"
    level, upright = browser.execute_script(tops)
    assert level == upright
    browser.execute_script(BY_NAME + "view('play').shadow_el.querySelector('button').click()")
    dot = (
        BY_NAME
        + "return all.find((m) => m.data && m.data.time?.length == 1 && 'v' in m.data) != null"
    )
    wait.until(lambda b: b.execute_script(dot))
    assert_fits(browser)
    assert_console_is_clean(browser)


def test_a_saved_page_works_from_the_file_system(browser, study, tmp_path):
    path = tmp_path / "page.html"
    save_page(open_results(study, study.parent, "map"), path)
    wait = opened(browser, path.as_uri())
    click(browser, 1.9, 1.5)
    assert_shows(browser, wait, study, 1.9, 1.5)
    assert_fits(browser)
    assert_console_is_clean(browser)


def test_a_saved_page_of_both_directions_shows_each(browser, study, results, tmp_path):
    """Where two motions coexist, the menu chooses whose motion is drawn, and the curves stay."""
    path = tmp_path / "page.html"
    save_page(replace(results, first="both_ways"), path)
    wait = opened(browser, path.as_uri())
    stored = load(study / "both_ways.nc").sel(f=0.5)
    apart = (stored["regime"].sel(direction="up") != stored["regime"].sel(direction="down")).values
    nu = float(stored["nu"].values[np.flatnonzero(apart)[0]])
    browser.execute_script(
        BY_NAME + f"named('f').value = '0.5';named('crosshair').data = {{x: [{nu}], y: [0]}}"
    )
    for direction, impacts in (("up", 2), ("down", 0)):
        browser.execute_script(BY_NAME + f"named('direction').value = '{direction}'")
        wait.until(lambda b, n=impacts: jumps(b)[0].size == n)
        assert f"direction = {direction}" in law(browser)
    curves = "return all.filter((m) => m.data?.marker && m.data.at).map((m) => m.data.at.length)"
    assert browser.execute_script(BY_NAME + curves) == [2 * 2 * 15]
    assert_console_is_clean(browser)


def test_the_page_of_one_exciter_follows_a_slider_and_says_what_coexists(browser):
    command = [*PROGRAM, "view", "--no-browser"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        try:
            wait = opened(browser, re.search(r"http\S+", read_until("http", process))[0])
            assert_fits(browser)
            assert "3 motions coexist here" in law(browser)
            moves = "const slider = named('slider_R1'); for (let n = 1; n < 101; n++) slider.value = 0.8 - n / 500"
            browser.execute_script(BY_NAME + moves)
            wait.until(lambda b: "What if R₁ = 0.6" in law(b) and "Coexists with 1" in law(b))
            write_into(browser, "l", "0.001")
            wait.until(lambda b: "What if l = 0.001" in law(b))
            assert_console_is_clean(browser)
        finally:
            process.kill()


def test_a_wrong_token_shows_nothing(browser, address):
    browser.get(f"http://localhost:{urlsplit(address).port}/?bokeh-session-id=wrong")
    assert not browser.execute_script("return window.Bokeh != null")
