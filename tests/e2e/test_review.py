"""The Review tab: the list, the quick look, comparison, links, and what people write on recordings."""

import json
import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import BrowserContext, Page, Route, expect

from recordings.messages import Recording
from tests.e2e.product import Product, open_page, pixels_of, shot
from tests.e2e.recorded import record_circle
from tests.e2e.test_accessibility import AXE, look

OBSERVER_BLUE = (0x56, 0xB4, 0xE9)


@pytest.fixture(scope="module")
def made(product: Product) -> Iterator[list[Recording]]:
    """Two recordings of the same circle, begun at different times."""
    yield [
        record_circle(product.recordings, "Circle slow", 20.0),
        record_circle(product.recordings, "Circle pump", 14.0, 700),
    ]


def test_the_list_is_searched_and_sorted_and_a_click_opens_the_quick_look(page: Page, made: list[Recording]) -> None:
    review(page)
    rows = page.get_by_test_id("recording")
    page.get_by_test_id("recording-search").fill("circle")
    expect(rows).to_have_count(2)
    page.get_by_test_id("sort-seconds").click()
    assert rows.first.get_attribute("data-id") == made[0].id
    page.get_by_test_id("sort-seconds").click()
    assert rows.first.get_attribute("data-id") == made[1].id
    page.get_by_test_id("recording-search").fill("CIRCLE pu")
    expect(rows).to_have_count(1)
    rows.first.get_by_role("button", name="Circle pump", exact=True).press("Enter")
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)
    shot(page, "quick-look")
    box = page.get_by_test_id("quick-path").bounding_box()
    assert box
    assert len(pixels_of(page, OBSERVER_BLUE, box)) > 50, "the path is drawn"
    page.get_by_test_id("back").click()
    expect(page.get_by_test_id("recording-search")).to_have_value("CIRCLE pu")


def test_the_cursor_is_common_and_a_drag_zooms_every_plot(page: Page, made: list[Recording]) -> None:
    open_link(page, f"#review/{made[0].id}")
    plots = page.get_by_test_id("quick-plot")
    expect(plots).to_have_count(6)
    expect(plots.first.locator(".u-over")).to_be_visible()
    over = plots.first.locator(".u-over").bounding_box()
    assert over
    middle = over["y"] + over["height"] / 2
    page.mouse.move(over["x"] + over["width"] / 2, middle)
    for plot in plots.all():
        expect(plot.locator(".quick-line .number").first).to_have_text(re.compile(r"\d"))
    whole = plots.nth(3).screenshot()
    page.mouse.down()
    page.mouse.move(over["x"] + 0.7 * over["width"], middle, steps=4)
    page.mouse.up()
    page.mouse.move(over["x"] + over["width"] / 2, middle)
    assert plots.nth(3).screenshot() != whole


def test_two_recordings_are_compared_on_time_and_phase(page: Page, made: list[Recording]) -> None:
    review(page)
    expect(page.get_by_test_id("compare")).to_be_disabled()
    for recording in made:
        page.get_by_role("checkbox", name=f"Compare {recording.name}").check()
    page.get_by_test_id("compare").click()
    expect(page.get_by_test_id("compare-table").locator("tbody tr")).to_have_count(2)
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)
    assert page.evaluate("location.hash") == f"#review/compare/{made[0].id},{made[1].id}"
    shot(page, "compare-time")
    page.get_by_test_id("common-axis").get_by_text("Phase").click()
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)
    box = page.get_by_test_id("quick-plot").first.bounding_box()
    assert box
    assert len(pixels_of(page, OBSERVER_BLUE, box)) > 50
    shot(page, "compare-phase")


def test_links_open_their_view_back_and_reload_keep_it_and_an_unknown_id_says_so(
    page: Page, made: list[Recording]
) -> None:
    open_link(page, f"#review/{made[1].id}")
    expect(page.locator("h2.bar-title")).to_contain_text("Circle pump")
    page.reload()
    expect(page.locator("h2.bar-title")).to_contain_text("Circle pump")
    page.get_by_test_id("back").click()
    expect(page.get_by_test_id("recordings")).to_be_visible()
    page.go_back()
    expect(page.locator("h2.bar-title")).to_contain_text("Circle pump")
    page.go_forward()
    expect(page.get_by_test_id("recordings")).to_be_visible()
    open_link(page, "#review/20200101-000000-nothing")
    expect(page.get_by_test_id("unknown-recording")).to_contain_text("20200101-000000-nothing")
    open_link(page, f"#review/compare/{made[0].id},20200101-000000-nothing")
    expect(page.get_by_test_id("unknown-recording")).to_be_visible()


def test_a_link_is_kept_through_the_sign_in(context: BrowserContext, product: Product, made: list[Recording]) -> None:
    context.add_init_script(
        "localStorage.setItem('tendril-guide', 'seen'); localStorage.setItem('tendril-3d', 'closed')"
    )
    page = context.new_page()
    page.goto(f"{product.url}#review/{made[0].id}")
    expect(page.locator("h2.bar-title")).to_contain_text("Circle slow", timeout=20_000)


def test_name_and_notes_are_sent_when_the_field_is_left_and_deletion_asks(page: Page, made: list[Recording]) -> None:
    asked: list[tuple[str, object]] = []
    row = made[0]

    def answer(route: Route) -> None:
        nonlocal row
        if route.request.method not in ("PATCH", "DELETE"):
            route.fallback()
            return
        asked.append((route.request.method, route.request.post_data_json if route.request.post_data else None))
        if route.request.method == "PATCH":
            row = row.model_copy(update=json.loads(route.request.post_data or "{}"))
        route.fulfill(json=row.model_dump(mode="json"))

    page.route(f"**/api/recordings/{row.id}", answer)
    open_link(page, f"#review/{row.id}")
    page.get_by_test_id("recording-notes").fill("valve 2 sticks")
    page.get_by_test_id("recording-notes").press("Tab")
    page.get_by_test_id("star").click()
    expect(page.get_by_test_id("star")).to_have_attribute("aria-pressed", "true")
    page.get_by_test_id("delete-recording").click()
    expect(page.get_by_test_id("delete-confirm")).to_be_disabled()
    page.keyboard.press("Escape")
    page.get_by_test_id("star").click()
    page.get_by_test_id("delete-recording").click()
    page.get_by_test_id("delete-confirm").click()
    expect(page.get_by_test_id("recordings")).to_be_visible()
    assert asked == [
        ("PATCH", {"notes": "valve 2 sticks"}),
        ("PATCH", {"starred": True}),
        ("PATCH", {"starred": False}),
        ("DELETE", None),
    ]


def test_a_list_that_cannot_be_read_says_why_and_can_be_asked_again(page: Page, made: list[Recording]) -> None:
    page.route("**/api/recordings", lambda route: route.fulfill(status=503, json={"detail": "the disk sleeps"}))
    review(page)
    expect(page.get_by_role("alert")).to_contain_text("the disk sleeps")
    page.unroute("**/api/recordings")
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_test_id("recording").first).to_be_visible()


def test_axe_finds_nothing_serious_in_review(context: BrowserContext, product: Product, made: list[Recording]) -> None:
    page = open_page(context, product)
    page.evaluate(AXE.read_text() + "; 0")
    findings = []
    for scheme in ("dark", "light"):
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        for place in ("#review", f"#review/{made[0].id}", f"#review/compare/{made[0].id},{made[1].id}"):
            open_link(page, place)
            expect(page.get_by_test_id("recordings" if place == "#review" else "quick")).to_be_visible()
            findings += look(page, f"{place}, {scheme}", "main.review")
    assert not findings, "\n".join(findings)


def review(page: Page) -> None:
    page.get_by_text("Review", exact=True).click()


def open_link(page: Page, hash: str) -> None:
    """As a link within the page does."""
    page.evaluate("(hash) => { location.hash = hash; }", hash)
