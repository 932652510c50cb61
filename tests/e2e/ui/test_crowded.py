"""A crowded page: every place taken, or texts as long as they may be."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from recordings.format import sidecar
from recordings.format.messages import Bookmark, Hole, Recording
from recordings.store.finishing import finish
from tests.e2e.edge import ask
from tests.e2e.fitting import crooked, misfits
from tests.e2e.product import Product, shot
from tests.e2e.recorded import list_many, record_circle
from tests.e2e.reviewing import open_link
from tests.server.live_server import VIEWER_TOKEN, TestServer, free_environment

pytestmark = pytest.mark.keyed("frontend/src", "frontend/package-lock.json", "tests/e2e/*.py", imports=False)
"""How the page looks follows its own sources; what it shows has tests of its own that are always run."""

WIDE, LONG = "W" * 80, "abcdefghij" * 8
LINES = """(all) => all.map((element) => {
  const range = document.createRange();
  range.selectNodeContents(element);
  return range.getClientRects().length;
})"""
"""In how many lines the text of each element stands."""
ARRIVED = "(element) => Promise.all(element.getAnimations().map((one) => one.finished))"
"""It slides in."""
SIZES = ((390, 844, "dark"), (820, 1180, "light"), (1440, 900, "dark"), (1920, 1080, "light"))


def test_a_page_too_many_says_why_it_is_not_taken_in(context: BrowserContext, tmp_path: Path) -> None:
    free_environment()
    server = TestServer(tmp_path, "tcp/127.0.0.1:9", viewers_max=1)
    try:
        page = context.new_page()
        with server.page().sign_in().live() as first:
            first.wait("hello")
            page.goto(f"{server.url}/?token={VIEWER_TOKEN}")
            expect(page.get_by_test_id("shutOut")).to_contain_text("1 pages are open, as many as viewers_max allows")
            shot(page, "shut-out")
        expect(page.get_by_test_id("banner")).to_contain_text("The server waits for a rig")
        page.close()
    finally:
        server.close()


@pytest.fixture(scope="module")
def wordy(product: Product) -> Iterator[list[Recording]]:
    """Two whole recordings that say as much as they may, the newest of some thousand of their kind."""
    folder = product.recordings
    made = [record_circle(folder, name, 4.0) for name in (WIDE, LONG)]
    for n, recording in enumerate(made):
        finish(folder, recording.id)
        marks = tuple(Bookmark(n=k, tick=k, t=0.7 * k, label=LONG if k % 2 else "") for k in range(1, 5))
        wordy = {"tags": (WIDE, LONG, "ok"), "operator": WIDE, "reference": LONG, "actuator": "A" * 40}
        lost = {"gaps": 1_234_567, "holes": (Hole(after=7, ticks=1_234_567),)} if n == 0 else {}
        made[n] = sidecar.update(folder, recording.id, bookmarks=marks, notes=3 * WIDE, **wordy, **lost)
    others = list_many(folder, made[0], 3000)
    for k, file in enumerate(others[-100::2]):
        row = sidecar.read(folder, file.stem)
        odd: dict[str, object] = {
            "name": (WIDE, "x", LONG)[k % 3],
            "tags": ((), (WIDE,), ("a", "b"), (LONG, WIDE))[k % 4],
        }
        odd |= {"seconds": (3.0, 9 * 86_400.0)[k % 2], "complete": k % 5 > 0, "gaps": k % 3, "starred": k % 2 > 0}
        file.write_text(row.model_copy(update=odd).model_dump_json())
    yield made
    for file in [*others, *(path for one in made for path in folder.glob(f"{one.id}*"))]:
        file.unlink()


def test_long_texts_are_cut_or_wrapped_and_nothing_is_pushed_out(
    page: Page, product: Product, wordy: list[Recording]
) -> None:
    wrong: list[str] = []
    places = {
        "list": ("#review", "recordings"),
        "detail": (f"#review/{wordy[0].id}", "quick"),
        "compare": (f"#review/compare/{wordy[0].id},{wordy[1].id}", "quick"),
        "unknown": (f"#review/20200101-000000-{WIDE}", "unknown-recording"),
    }
    for width, height, scheme in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        for name, (place, sign) in places.items():
            open_link(page, place)
            expect(page.get_by_test_id(sign)).to_be_visible()
            if name == "list":
                expect(page.get_by_test_id("recording")).to_have_count(50)
            wrong += misfits(page, "main.review") + crooked(page, ".list-table")
            shot(page, f"crowded-{name}-{width}")
    assert not wrong, "\n".join(wrong)


def test_lines_of_the_log_of_any_length_are_wrapped_beside_their_time(page: Page) -> None:
    for id in (3 * WIDE, 4 * LONG):
        assert not ask(page, "PATCH", f"/api/recordings/{id}", name="x")
    wrong: list[str] = []
    for width, height, scheme in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.emulate_media(color_scheme=scheme)  # type: ignore[arg-type]
        page.get_by_role("tab", name="Log").click()
        expect(page.get_by_test_id("log")).to_contain_text(LONG)
        assert max(page.locator(".log time").evaluate_all(LINES)) == 1, "no time is broken"
        wrong += misfits(page, ".log-panel")
        shot(page, f"crowded-log-{width}")
    assert not wrong, "\n".join(wrong)


def test_a_notice_of_any_length_stays_on_the_page(page: Page) -> None:
    asked = re.compile("/api/lease$")
    page.route(asked, lambda route: route.fulfill(status=409, json={"detail": f"{4 * WIDE} operates, not {LONG}"}))
    notice = page.locator(".mantine-Notification-root")
    for width, height, _ in SIZES:
        page.set_viewport_size({"width": width, "height": height})
        page.get_by_test_id("lease-take").click()
        expect(notice).to_be_visible()
        notice.evaluate(ARRIVED)
        shot(page, f"crowded-notice-{width}")
        box = notice.bounding_box()
        assert box
        assert box["x"] >= 0, f"{width} px"
        assert box["x"] + box["width"] <= width, f"{width} px"
        assert misfits(page, ".notices[data-position=bottom-right]") == []
        notice.get_by_role("button").click()  # by itself it would go after 12 s, in the middle of a look
        expect(notice).to_have_count(0)
    page.unroute(asked)
