"""E-STOP in reach and at work at every size, zoom and in forced colours, and by every way that is left."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, ViewportSize, expect

from controller.schema.modes import Mode
from tests.e2e.edge import APART, REACHED, SIZES, ZOOMED, ask, clear, escape_twice, press, troubles
from tests.e2e.product import Product, open_page, shot, wait_until
from tests.e2e.tab import end_session

COLOURS = """() => [...document.querySelectorAll("button")].filter((one) => one.offsetWidth > 0).map((one) => {
  const { backgroundColor, borderTopStyle } = getComputedStyle(one);
  return [one.dataset.testid ?? "", `${backgroundColor} ${borderTopStyle}`];
})"""


@pytest.fixture
def touched(browser: Browser, product: Product) -> Iterator[Page]:
    """A page that operates, on a screen that is touched."""
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, color_scheme="dark")
    page = open_page(context, product)
    wait_until(lambda: ask(page, "POST", "/api/lease"))
    yield page
    end_session(context)


def resize(page: Page, width: int, height: int) -> None:
    """Another window, laid out and painted."""
    page.set_viewport_size(ViewportSize(width=width, height=height))
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")


def test_it_is_in_reach_and_works_by_touch_at_every_size_and_zoom(touched: Page, product: Product) -> None:
    found = []
    for n, (width, height) in enumerate([*SIZES, *ZOOMED.values()]):
        resize(touched, width, height)
        where = f"live, {width} x {height}"
        found += troubles(touched, where)
        found += [f"{where}: {said}" for id in ("arm", "hold", "clear") if (said := touched.evaluate(REACHED, id))]
        if not touched.evaluate(APART, [".plan-fit", ".draw-bar"]):
            found.append(f"{where}: Fit covers a tool")
        found += troubles(touched, f"{where}, scrolled")
        shot(touched, f"edge-{width}x{height}")
        ask(touched, "POST", "/api/command", request="arm")
        press(touched, product, touch=n % 3 > 0, where=where)
        found += troubles(touched, f"{where}, stopped")
        clear(touched, product)
    assert not found, "\n".join(found)


def test_it_is_in_reach_in_review_and_of_a_phone_that_is_turned(touched: Page, product: Product) -> None:
    touched.get_by_text("Review", exact=True).click()
    expect(touched.locator("main.review")).to_be_visible()
    found = []
    for width, height in [*SIZES, *ZOOMED.values()]:
        resize(touched, width, height)
        found += troubles(touched, f"review, {width} x {height}")
    press(touched, product, touch=True, where="review")
    clear(touched, product)
    assert not found, "\n".join(found)


def panned_to(page: Page, name: str) -> list[str]:
    """What is wrong with the edge of the page that is zoomed by two fingers, where this control is in sight."""
    page.evaluate(f"document.querySelector('[data-testid={name}]').scrollIntoView()")
    wait_until(lambda: page.evaluate("visualViewport.scale > 2 && visualViewport.offsetTop > 100"))
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return troubles(page, "zoomed by two fingers")


def test_two_fingers_that_zoom_do_not_take_it_out_of_sight(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 390, "height": 844}, has_touch=True, is_mobile=True)
    page = open_page(context, product)
    assert ask(page, "POST", "/api/lease")
    context.new_cdp_session(page).send("Emulation.setPageScaleFactor", {"pageScaleFactor": 2.5})
    found = [panned_to(page, "arm"), panned_to(page, "recording-name")]
    shot(page, "edge-pinched")
    assert not [said for places in found for said in places if "the bar covers" not in said], found
    assert not set(found[0]) & set(found[1]), "the bar goes along: what it covers here is free there"
    press(page, product, touch=True, where="zoomed by two fingers")
    clear(page, product)
    end_session(context)


def test_with_forced_colours_it_looks_like_no_other_button(touched: Page, product: Product) -> None:
    touched.emulate_media(forced_colors="active")
    looks = dict(touched.evaluate(COLOURS))
    own = looks.pop("e-stop")
    assert own == "rgb(211, 34, 42) double"
    assert own not in looks.values()
    shot(touched, "edge-forced")
    found = troubles(touched, "forced colours")
    assert not found, "\n".join(found)
    press(touched, product, touch=True, where="forced colours")
    clear(touched, product)


def test_without_its_cookie_it_stops_by_the_socket_and_signed_out_names_the_hardware_stop(
    touched: Page, product: Product
) -> None:
    touched.context.clear_cookies()
    press(touched, product, touch=True, where="no cookie")
    expect(touched.get_by_test_id("stop-news")).to_have_text("E-STOP arrived at the rig (web request: sign in first)")
    touched.reload()
    expect(touched.get_by_test_id("sign-in")).to_be_visible()
    found = []
    for width, height in [*SIZES, *ZOOMED.values()]:
        resize(touched, width, height)
        found += troubles(touched, f"signed out, {width} x {height}")
    assert not found, "\n".join(found)
    escape_twice(touched)
    news = touched.get_by_test_id("stop-news")
    expect(news).to_contain_text("use the hardware stop")
    expect(news).to_contain_text("live connection: no connection; web request: sign in first")
    touched.get_by_test_id("token").fill(product.url.split("token=")[1])
    touched.get_by_test_id("sign-in").click()
    expect(touched.get_by_test_id("state")).to_contain_text("E-STOP")
    wait_until(lambda: ask(touched, "POST", "/api/lease"))  # its former session operates until it lapses
    clear(touched, product)


def test_it_arrives_by_http_where_the_socket_is_cut(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    context.route_web_socket("**/ws/live", lambda socket: socket.close())
    page = context.new_page()
    page.goto(product.url)
    expect(page.get_by_test_id("state")).to_contain_text("NO LINK")
    page.get_by_test_id("e-stop").click()
    expect(page.get_by_test_id("stop-news")).to_contain_text(
        "E-STOP arrived at the rig (live connection: no connection)"
    )
    assert product.mode() == Mode.E_STOP
    end_session(context)
