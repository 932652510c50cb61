"""The Review tab: the list, the quick look, comparison, links, and what people write on recordings."""

import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import BrowserContext, Page, Request, expect

from controller.schema.palette import LINES, rgb
from recordings.format.messages import Recording
from tests.e2e.product import Product, pixels_of, shot, wait_until
from tests.e2e.recorded import list_many, record_circle
from tests.e2e.reviewing import choose_csv, coloured, open_link, review

pytestmark = pytest.mark.keyed("frontend/src", "server/recorder", "recordings", "tests/e2e/*.py", imports=False)
"""How a room of the page works follows the sources of page and room; what moves or stops a rig is always tested."""

OBSERVER_BLUE = (0x56, 0xB4, 0xE9)
FIRST_RUN, SECOND_RUN = rgb(LINES[0]), rgb(LINES[1])


@pytest.fixture(scope="module")
def made(product: Product) -> Iterator[list[Recording]]:
    """Two recordings of the same circle, begun at different times: one keeps everything, one what is standard."""
    yield [
        record_circle(product.recordings, "Hoop slow", 20.0),
        record_circle(product.recordings, "Hoop pump", 14.0, 700, "standard"),
    ]


def test_the_list_is_searched_and_sorted_and_a_click_opens_the_quick_look(page: Page, made: list[Recording]) -> None:
    review(page)
    rows = page.get_by_test_id("recording")
    page.get_by_test_id("recording-search").fill("hoop")
    expect(rows).to_have_count(2)
    page.get_by_test_id("sort-seconds").click()
    expect(rows.first).to_have_attribute("data-id", made[0].id)
    page.get_by_test_id("sort-seconds").click()
    expect(rows.first).to_have_attribute("data-id", made[1].id)
    page.get_by_test_id("recording-search").fill("HOOP pu")
    expect(rows).to_have_count(1)
    rows.first.get_by_role("button", name="Hoop pump", exact=True).press("Enter")
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)
    assert min(coloured(page)) > 100, "every plot of the standard profile has its curves"
    shot(page, "quick-look")
    box = page.get_by_test_id("quick-path").bounding_box()
    assert box
    assert len(pixels_of(page, OBSERVER_BLUE, box)) > 50, "the path is drawn"
    page.get_by_test_id("back").click()
    expect(page.get_by_test_id("recording-search")).to_have_value("HOOP pu")


def test_the_server_finds_fifty_at_a_time_and_what_is_ticked_stays_ticked(
    page: Page, product: Product, made: list[Recording]
) -> None:
    many = list_many(product.recordings, made[0], 55)
    review(page)
    rows = page.get_by_test_id("recording")
    expect(rows).to_have_count(50)
    page.get_by_test_id("show-more").click()
    expect(rows.filter(has_text="old")).to_have_count(55)
    expect(page.get_by_test_id("show-more")).to_have_count(0)
    for word in ("old 33", "old 44"):
        page.get_by_test_id("recording-search").fill(word)
        expect(rows).to_have_count(1)
        page.get_by_role("checkbox", name=f"Compare {word}").check()
    expect(page.get_by_test_id("recordings-found")).to_contain_text("1 found")
    expect(page.get_by_test_id("compare")).to_have_text("Compare 2")
    many[1].unlink()
    page.get_by_test_id("recording-search").fill(many[1].stem)
    expect(rows.get_by_test_id("mark").filter(has_text="problem")).to_have_count(1)
    expect(rows).to_contain_text("its data is missing")
    for file in many:
        file.unlink(missing_ok=True)


def test_the_cursor_is_common_and_a_drag_zooms_every_plot(page: Page, made: list[Recording]) -> None:
    open_link(page, f"#review/{made[0].id}")
    plots = page.get_by_test_id("quick-plot")
    expect(plots).to_have_count(6)
    wait_until(lambda: len(coloured(page)) == 6 and min(coloured(page)) > 100)  # until then they are made again
    expect(plots.first.locator(".u-over")).to_be_visible()
    over = plots.first.locator(".u-over").bounding_box()
    assert over
    middle = over["y"] + over["height"] / 2
    page.mouse.move(over["x"] + over["width"] / 2, middle)
    for plot in plots.all():
        expect(plot.locator(".quick-line .number").first).to_have_text(re.compile(r"\d"))
    axes = page.get_by_test_id("time-axis").filter(visible=True)
    expect(axes).to_have_count(2)
    expect(axes.get_by_test_id("cursor-time")).to_have_text([re.compile(r"^\d+\.\d+ s$")] * 2)
    before = axes.all_inner_texts()
    whole = plots.nth(3).screenshot()
    page.mouse.down()
    page.mouse.move(over["x"] + 0.7 * over["width"], middle, steps=4)
    page.mouse.up()
    page.mouse.move(over["x"] + over["width"] / 2, middle)
    assert plots.nth(3).screenshot() != whole
    after = axes.all_inner_texts()
    assert after[0] == after[1] != before[0]


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
    for colour in (FIRST_RUN, SECOND_RUN):
        assert len(pixels_of(page, colour, box)) > 50
    shot(page, "compare-phase")


def test_links_open_their_view_back_and_reload_keep_it_and_an_unknown_id_says_so(
    page: Page, made: list[Recording]
) -> None:
    open_link(page, f"#review/{made[1].id}")
    expect(page.locator("h2.bar-title")).to_contain_text("Hoop pump")
    page.reload()
    expect(page.locator("h2.bar-title")).to_contain_text("Hoop pump")
    page.get_by_test_id("back").click()
    expect(page.get_by_test_id("recordings")).to_be_visible()
    page.go_back()
    expect(page.locator("h2.bar-title")).to_contain_text("Hoop pump")
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
    expect(page.locator("h2.bar-title")).to_contain_text("Hoop slow")


def test_name_and_notes_are_sent_when_the_field_is_left_and_deletion_asks(page: Page, product: Product) -> None:
    row = record_circle(product.recordings, "Mine", 1.0)
    place = f"/api/recordings/{row.id}"
    asked: list[tuple[str, object]] = []

    def note(request: Request) -> None:
        if request.method in ("PATCH", "DELETE") and request.url.endswith(place):
            asked.append((request.method, request.post_data_json if request.post_data else None))

    def kept() -> dict[str, Any]:
        return page.request.get(product.origin + place).json()  # type: ignore[no-any-return]

    page.on("request", note)
    open_link(page, f"#review/{row.id}")
    page.get_by_test_id("recording-notes").fill("valve 2 sticks")
    page.get_by_test_id("recording-notes").press("Tab")
    page.get_by_test_id("star").click()
    expect(page.get_by_test_id("star")).to_have_attribute("aria-pressed", "true")
    assert (kept()["notes"], kept()["starred"]) == ("valve 2 sticks", True)
    page.get_by_test_id("delete-recording").click()
    expect(page.get_by_test_id("delete-confirm")).to_be_disabled()
    page.keyboard.press("Escape")
    page.get_by_test_id("star").click()
    expect(page.get_by_test_id("star")).to_have_attribute("aria-pressed", "false")
    field = page.locator(".review").get_by_test_id("recording-name")
    field.fill("Mine again")
    field.press("Tab")
    page.get_by_test_id("recording-tags").fill("good")
    page.get_by_test_id("recording-tags").press("Enter")
    expect(page.locator("h2.bar-title")).to_contain_text("Mine again")
    expect(page.locator(".review-tag")).to_have_text("#good")
    assert (kept()["name"], kept()["tags"]) == ("Mine again", ["good"])
    page.get_by_test_id("delete-recording").click()
    page.get_by_test_id("delete-confirm").click()
    expect(page.get_by_test_id("recordings")).to_be_visible()
    expect(page.locator(f"[data-id='{row.id}']")).to_have_count(0)
    assert page.request.get(product.origin + place).status == 404
    assert asked == [
        ("PATCH", {"notes": "valve 2 sticks"}),
        ("PATCH", {"starred": True}),
        ("PATCH", {"starred": False}),
        ("PATCH", {"name": "Mine again"}),
        ("PATCH", {"tags": ["good"]}),
        ("DELETE", None),
    ]


def test_notes_that_are_being_typed_outlive_back(page: Page, product: Product, made: list[Recording]) -> None:
    place = f"{product.origin}/api/recordings/{made[1].id}"
    open_link(page, "#review")
    page.locator(f"[data-id='{made[1].id}']").locator("button.link").click()
    page.get_by_test_id("recording-notes").fill("typed, and not left")
    page.go_back()
    expect(page.get_by_test_id("recordings")).to_be_visible()
    wait_until(lambda: page.request.get(place).json()["notes"] == "typed, and not left")


def test_figures_stand_whole_and_by_cycle_as_the_server_measures_them(
    page: Page, product: Product, made: list[Recording]
) -> None:
    open_link(page, f"#review/{made[1].id}")
    page.get_by_test_id("sight").get_by_text("Figures").click()
    rows = page.get_by_test_id("figures").locator("tbody tr")
    measured = page.request.get(f"{product.origin}/api/recordings/{made[1].id}/metrics").json()
    assert len(measured["cycles"]) >= 3
    expect(rows).to_have_count(1 + len(measured["cycles"]))
    for row, metrics in zip(rows.all(), [measured["whole"], *measured["cycles"]], strict=True):
        expect(row.locator("td.right").first).to_have_text(f"{1e3 * metrics['rmse']:.2f}")
        expect(row.locator("td.right").last).to_have_text(f"{100 * metrics['on_time_share']:.2f}")
    shot(page, "figures")


def test_a_recorded_path_is_a_drawing_of_the_run_tab_with_its_own_times(page: Page, made: list[Recording]) -> None:
    open_link(page, f"#review/{made[1].id}")
    page.get_by_test_id("follow-again").click()
    page.get_by_test_id("follow-p_ref").click()
    page.get_by_role("tab", name="Run").click()
    expect(page.get_by_role("radio", name="Drawing")).to_be_checked()
    expect(page.get_by_test_id("drawing-name")).to_have_value("Hoop pump")
    facts = page.get_by_test_id("drawing-facts")
    expect(facts.locator("div:has(dt:text-is('Duration')) dd")).to_have_text("14.0 s")
    shot(page, "follow-again")
    page.get_by_test_id("clear-drawing").click()


def test_another_labs_csv_asks_for_its_units_says_what_is_wrong_and_is_compared(
    page: Page, product: Product, made: list[Recording]
) -> None:
    page.get_by_test_id("lease-take").click()
    review(page)
    choose_csv(page, "time;x;y\n0;70;140\n1;a;150\n")
    expect(page.get_by_test_id("unit-time")).to_be_visible()
    page.get_by_test_id("unit-length").get_by_text("mm", exact=True).click()
    page.get_by_test_id("import-send").click()
    expect(page.get_by_test_id("import-problem")).to_contain_text("line 3: x = 'a' is not a number")
    page.keyboard.press("Escape")
    t = np.arange(0.0, 8.0, 0.02)
    lines = [f"{a:.2f};{30 + 40 * np.cos(np.pi * a):.3f};{140 + 40 * np.sin(np.pi * a):.3f}" for a in t]
    choose_csv(page, "\n".join(["t_s;x;y", *lines]))
    expect(page.get_by_test_id("unit-time")).to_have_count(0)
    page.get_by_test_id("import-name").fill("Lab B circle")
    page.get_by_test_id("unit-length").get_by_text("mm", exact=True).click()
    page.get_by_test_id("import-send").click()
    row = page.get_by_test_id("recording").filter(has_text="Lab B circle")
    expect(row.get_by_test_id("mark")).to_contain_text("imported")
    for name in ("Lab B circle", made[0].name):
        page.get_by_role("checkbox", name=f"Compare {name}").check()
    page.get_by_test_id("compare").click()
    expect(page.get_by_test_id("compare-table").locator("tbody tr")).to_have_count(2)
    expect(page.get_by_test_id("quick-plot").first.locator(".quick-line")).to_have_count(2)
    shot(page, "compare-imported")
    id = page.evaluate("location.hash").split("/")[-1].split(",")[0]
    assert page.request.delete(f"{product.origin}/api/recordings/{id}", headers={"origin": product.origin}).ok
    page.get_by_test_id("lease-release").click()


def test_a_recording_keeps_what_was_chosen_and_is_seen_while_it_grows(page: Page, product: Product) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("record-profile").click()
    full = page.get_by_test_id("profile-full")
    expect(full).to_contain_text("1.96 GB/h")
    expect(page.get_by_test_id("profile-standard")).to_contain_text("580.0 MB/h")
    shot(page, "record-profile")
    full.click()
    page.keyboard.press("Escape")
    page.get_by_test_id("record").click()
    expect(page.get_by_test_id("record")).to_contain_text("REC")
    review(page)
    row = page.get_by_test_id("recording").first
    expect(row.get_by_test_id("mark")).to_have_text([re.compile("recording now"), re.compile("full")])
    with page.expect_response(re.compile("/quick")) as first:
        row.click()
    before = first.value.json()["rows"]
    with page.expect_response(lambda answer: "/quick" in answer.url and answer.json()["rows"] > before + 500):
        pass
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)
    id = page.evaluate("location.hash").split("/")[-1]
    page.get_by_test_id("record").click()
    expect(page.locator(".review").get_by_test_id("mark").filter(has_text="recording now")).to_have_count(0)
    assert page.request.get(f"{product.origin}/api/recordings/{id}").json()["profile"] == "full"
    page.get_by_test_id("lease-release").click()


def test_what_the_plots_show_of_the_chosen_signals_is_exported(
    page: Page, product: Product, made: list[Recording]
) -> None:
    review(page)
    open_link(page, f"#review/{made[0].id}")
    wait_until(lambda: len(coloured(page)) == 6 and min(coloured(page)) > 100)
    box = page.get_by_test_id("quick-plot").first.locator(".u-over").bounding_box()
    assert box
    for share, act in ((0.25, page.mouse.down), (0.5, page.mouse.up)):
        page.mouse.move(box["x"] + share * box["width"], box["y"] + box["height"] / 2, steps=5)
        act()
    page.get_by_test_id("export").click()
    edges = [float(page.get_by_test_id(f"export-{edge}").input_value()) for edge in ("from", "to")]
    assert edges == pytest.approx([0.25 * made[0].seconds, 0.5 * made[0].seconds], abs=0.4)
    page.get_by_test_id("export-signals").click()
    page.get_by_role("option", name="measured tip (p_meas) [m]").click()
    page.keyboard.press("Escape")
    shot(page, "export")
    with page.expect_download() as download:
        page.get_by_test_id("export-send").click()
    lines = download.value.path().read_text().splitlines()
    assert lines[0] == "t [s],p_meas_x [m],p_meas_y [m]"
    t = [float(line.split(",")[0]) for line in lines[1:]]
    assert [t[0], t[-1]] == pytest.approx(edges, abs=2e-3)
    whole = page.request.get(f"{product.origin}/api/recordings/{made[0].id}/export?format=csv&signals=tick").text()
    every = np.array([float(line.split(",")[0]) for line in whole.splitlines()[1:]])
    assert len(t) == np.count_nonzero((every >= edges[0]) & (every <= edges[1])), "all rows of the window"
    page.get_by_test_id("export").click()
    page.get_by_test_id("export-to").fill("0.1")
    expect(page.get_by_role("alert")).to_contain_text("To = 0.1 s is before From")
    expect(page.get_by_test_id("export-send")).to_be_disabled()
    page.get_by_role("button", name="Close").click()


def test_an_export_says_that_it_is_being_made_and_can_be_cancelled(page: Page, made: list[Recording]) -> None:
    asked, failed = re.compile(r"/exports$"), list[str]()
    page.route(asked, lambda route: None)  # the file takes its time
    page.on("requestfailed", lambda request: failed.append(request.url))
    open_link(page, f"#review/{made[0].id}")
    page.get_by_test_id("export").click()
    page.get_by_test_id("export-send").click()
    expect(page.get_by_test_id("export-making")).to_contain_text("is being made")
    expect(page.get_by_test_id("export-making")).to_contain_text("1 s")
    shot(page, "export-being-made")
    page.get_by_test_id("export-cancel").click()
    expect(page.get_by_test_id("export-send")).to_be_visible()
    wait_until(lambda: page.wait_for_timeout(50) or any(asked.search(url) for url in failed))
    page.unroute(asked)
    page.route(asked, lambda route: route.fulfill(status=422, json={"detail": "the file has no such signal"}))
    page.get_by_test_id("export-send").click()
    expect(page.get_by_test_id("export-problem")).to_contain_text("no such signal")


def test_a_deletion_is_undone_at_once_or_later_from_what_is_deleted(page: Page, product: Product) -> None:
    id = record_circle(product.recordings, "Deleted by mistake", 1.0).id
    row = page.locator(f"[data-id='{id}']")

    def delete() -> None:
        expect(row).to_be_visible()
        row.hover()
        row.get_by_test_id("delete-recording").click()
        page.get_by_test_id("delete-confirm").click()
        expect(row).to_have_count(0)

    review(page)
    page.get_by_test_id("recording-search").fill("by mistake")
    delete()
    expect(page.get_by_test_id("undo-deletion")).to_contain_text("Deleted “Deleted by mistake”")
    shot(page, "undo-delete")
    page.get_by_test_id("undo-delete").click()
    expect(row).to_be_visible()
    expect(page.get_by_test_id("undo-deletion")).to_have_count(0)
    delete()
    page.get_by_test_id("show-deleted").locator("..").click()
    expect(row).to_be_visible()
    shot(page, "deleted")
    row.hover()
    row.get_by_test_id("restore-recording").click()
    expect(row).to_have_count(0)
    page.get_by_test_id("show-deleted").locator("..").click()
    expect(row).to_be_visible()
    assert page.request.get(f"{product.origin}/api/recordings/{id}").json()["name"] == "Deleted by mistake"


def test_a_list_that_cannot_be_read_says_why_and_can_be_asked_again(page: Page, made: list[Recording]) -> None:
    asked = re.compile(r"/api/recordings\?")
    page.route(asked, lambda route: route.fulfill(status=503, json={"detail": "the disk sleeps"}))
    review(page)
    expect(page.get_by_role("alert")).to_contain_text("the disk sleeps")
    page.unroute(asked)
    page.get_by_role("button", name="Try again").click()
    expect(page.get_by_test_id("recording").first).to_be_visible()
