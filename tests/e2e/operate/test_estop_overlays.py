"""E-STOP over whatever the page can lay over itself: pressed by hand and by Esc Esc while it is open."""

import re
from collections.abc import Callable, Iterator
from pathlib import Path

import httpx
import pytest
from playwright.sync_api import Browser, FilePayload, Locator, Page, expect

from controller.schema.modes import Mode
from tests.e2e.edge import ask, clear, escape_twice, press, troubles
from tests.e2e.product import Product, open_page, shot, wait_until
from tests.e2e.recorded import record_circle
from tests.e2e.tab import end_session

SOURCES = Path(__file__).parents[3] / "frontend/src"
LAYS_OVER = re.compile(
    r"<(Modal|Drawer|Dialog|Menu|Popover|HoverCard|Select|MultiSelect|Autocomplete|TagsInput|Combobox)\b|<dialog\b"
    r"|role=\"(?:alert)?dialog\"|className=\"guide\""
)
Opener = Callable[[Page], Locator]


def opened(name: str, *, tab: str = "", review: bool = False) -> Opener:
    """Opens what the button `name` opens, in its tab, and gives it."""

    def opener(page: Page) -> Locator:
        if tab:
            page.get_by_role("tab", name=tab, exact=True).click()
        if review:
            show_recording(page)
        page.get_by_test_id(name).first.click()
        return page.locator("[role=menu], [role=dialog], [role=listbox], .mantine-Popover-dropdown").last

    return opener


def show_recording(page: Page) -> None:
    """Review, with the circle open."""
    page.get_by_text("Review", exact=True).click()
    page.get_by_test_id("recording").first.click()
    expect(page.get_by_test_id("back")).to_be_visible()


def keys(page: Page) -> Locator:
    """The list of keys."""
    page.get_by_test_id("plan").focus()
    page.keyboard.press("?")
    return page.get_by_test_id("keys")


def text(page: Page) -> Locator:
    """The field for a word."""
    page.get_by_test_id("tool-text").click()
    return page.get_by_test_id("text")


def saved(page: Page) -> Locator:
    """Saved drawings."""
    page.get_by_role("tab", name="Run", exact=True).click()
    page.get_by_text("Drawing", exact=True).click()
    page.get_by_test_id("saved-drawings").click()
    return page.locator(".mantine-Popover-dropdown").last


def importing(page: Page) -> Locator:
    """A CSV file that was chosen."""
    page.get_by_text("Review", exact=True).click()
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("import-recording").click()
    chooser.value.set_files(FilePayload(name="a.csv", mimeType="text/csv", buffer=b"t,x,y\n0,0,0\n1,0,0\n"))
    return page.get_by_test_id("import")


def drawing_file(page: Page) -> Locator:
    """A path that was chosen for the plan."""
    with page.expect_file_chooser() as chooser:
        page.get_by_test_id("tool-import").click()
    chooser.value.set_files(FilePayload(name="a.csv", mimeType="text/csv", buffer=b"t,x,y\n0,0,0\n1,0,0.1\n"))
    expect(page.get_by_test_id("import-picture")).to_be_visible()
    return page.get_by_test_id("import-drawing")


def exporting(page: Page) -> Locator:
    """The question of format and signals."""
    show_recording(page)
    page.get_by_test_id("export").click()
    return page.get_by_test_id("export-dialog")


def tags(page: Page) -> Locator:
    """The field for tags, which suggests some."""
    show_recording(page)
    page.get_by_test_id("recording-tags").click()
    return page.get_by_test_id("recording-tags")


def emptying(page: Page) -> Locator:
    """The question before deleted recordings are removed for good."""
    place = page.evaluate("location.origin") + "/api/recordings"
    ask(page, "POST", "/api/recordings")
    ask(page, "DELETE", "/api/recordings/current")
    newest = page.request.get(place).json()[0]["id"]
    wait_until(lambda: ask(page, "DELETE", f"/api/recordings/{newest}"))
    page.get_by_text("Review", exact=True).click()
    page.get_by_test_id("show-deleted").locator("..").click()  # its input itself has no size
    page.get_by_test_id("empty-bin").click()
    return page.get_by_test_id("empty-bin-confirm")


def guide(page: Page) -> Locator:
    """The first visit's guide."""
    page.evaluate("localStorage.removeItem('tendril-guide')")
    page.get_by_text("Review", exact=True).click()
    page.get_by_text("Live", exact=True).click()
    return page.get_by_test_id("guide")


def take_over(page: Page) -> Locator:
    """The question before control is taken from another session."""
    page.get_by_test_id("lease-menu").click()
    page.get_by_test_id("lease-take-over").click()
    return page.get_by_test_id("take-over-confirm")


def bookmark(page: Page) -> Locator:
    """The field for a bookmark's label."""
    ask(page, "POST", "/api/recordings", name="overlays")
    page.get_by_test_id("mark-button").click()
    return page.get_by_test_id("mark-label")


def profiles(page: Page) -> Locator:
    """What a recording keeps, while none runs."""
    ask(page, "DELETE", "/api/recordings/current")
    return opened("record-profile")(page)


def another_actuator(page: Page) -> Locator:
    """The question before the rig is started again."""
    page.get_by_role("tab", name="Actuator", exact=True).click()
    page.get_by_test_id("actuator-P2").click()
    return page.get_by_test_id("actuator-confirm")


BY_OPERATOR: dict[str, Opener] = {
    "app/KeyHelp.tsx": keys,
    "health/Health.tsx": opened("health"),
    "recorder/list/RecordingList.tsx": emptying,
    "ui/buttons/HeaderPopover.tsx": opened("notify"),
    "recorder/MarkButton.tsx": bookmark,
    "recorder/RecordButton.tsx": profiles,
    "operate/lease/LeaseControl.tsx": opened("lease-menu"),
    "drawing/importing/DrawImport.tsx": drawing_file,
    "drawing/tools/DrawToolbar.tsx": opened("tool-shape"),
    "drawing/tools/DrawText.tsx": text,
    "drawing/DrawSaved.tsx": saved,
    "drawing/library/ReferencePanel.tsx": opened("reference", tab="Run"),
    "operate/presets/AskActuator.tsx": another_actuator,
    "operate/presets/GainPresets.tsx": opened("gain-presets", tab="Gains"),
    "health/HealthLimits.tsx": opened("alarm-limits", tab="Health"),
    "plots/SignalChooser.tsx": opened("signals", tab="Plots"),
    "plots/LayoutMenu.tsx": opened("layouts", tab="Plots"),
    "recorder/detail/ExportDialog.tsx": exporting,
    "recorder/detail/Detail.tsx": opened("follow-again", review=True),
    "recorder/list/DeleteButton.tsx": opened("delete-recording", review=True),
    "recorder/list/ImportButton.tsx": importing,
    "recorder/detail/About.tsx": tags,
    "app/guide/Guide.tsx": guide,
}
"""How to open each, by the file that lays it over the page, in a page that operates."""
BY_OTHERS: dict[str, Opener] = {"operate/lease/LeaseControl.tsx": take_over, "operate/lease/Me.tsx": opened("me")}
"""The same in a page that does not operate."""
LARGE = ("app/KeyHelp.tsx", "recorder/detail/ExportDialog.tsx", "recorder/list/ImportButton.tsx")
LARGE += ("drawing/importing/DrawImport.tsx",)
"""Dialogs with a backdrop or in the middle: tried with a mouse on a large window, too."""
LAYERS = ":is([role=dialog], [role=menu], [role=listbox]):visible"
"""What Esc closes."""
GUIDE_GOES_ON = """() => window.addEventListener("keydown", () => {
  document.querySelector("[data-testid=guide]").style.display = "none";
}, { capture: true })"""
"""The guide's step is done, by what the rig does, while Esc is pressed: after the page has heard the key."""
KINDS = ("app/KeyHelp.tsx", "operate/lease/LeaseControl.tsx", "drawing/library/ReferencePanel.tsx")
KINDS += ("health/Health.tsx", "ui/buttons/HeaderPopover.tsx", "recorder/MarkButton.tsx", "recorder/RecordButton.tsx")
KINDS += (
    "drawing/importing/DrawImport.tsx",
    "plots/SignalChooser.tsx",
    "recorder/detail/ExportDialog.tsx",
    "app/guide/Guide.tsx",
    "operate/presets/AskActuator.tsx",
)
"""One of each way to lay something over the page; `make test-long` tries all."""


@pytest.fixture
def page(browser: Browser, product: Product) -> Iterator[Page]:
    """A small screen that is touched, on which the page operates, and a recording to review."""
    record_circle(product.recordings, "short", 2.0)
    context = browser.new_context(viewport={"width": 320, "height": 568}, has_touch=True)
    opened_page = open_page(context, product)
    wait_until(lambda: ask(opened_page, "POST", "/api/lease"))
    yield opened_page
    end_session(context)


def fresh(page: Page) -> None:
    """The page as it is after a reload, in Live."""
    page.goto(page.url.split("#")[0].split("?")[0])
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    ask(page, "POST", "/api/lease")


def by_keys(page: Page, product: Product, where: str) -> None:
    """The Esc that closes a layer does not end FOLLOW, and is none of the two that stop."""
    assert ask(page, "POST", "/api/command", request="arm"), where
    wait_until(lambda: product.mode() == Mode.HOLD)
    target = page.evaluate("window.__tendril.frame.p_ref")
    wait_until(lambda: ask(page, "POST", "/api/command", request="follow", target=target))
    wait_until(lambda: product.mode() == Mode.FOLLOW)
    layers = page.locator(LAYERS)
    while (count := layers.count()) > 0:
        page.keyboard.press("Escape")
        expect(layers, where).not_to_have_count(count)
    assert product.mode() == Mode.FOLLOW, where
    escape_twice(page)
    expect(page.get_by_test_id("stop-news"), where).to_contain_text("E-STOP arrived at the rig")
    assert product.mode() == Mode.E_STOP, where


def test_every_part_that_lays_something_over_the_page_is_known_here() -> None:
    found = {str(path.relative_to(SOURCES)) for path in SOURCES.rglob("*.tsx") if LAYS_OVER.search(path.read_text())}
    assert found == BY_OPERATOR.keys() | BY_OTHERS.keys()


@pytest.mark.parametrize("places", [KINDS, pytest.param(tuple(BY_OPERATOR), marks=pytest.mark.long)])
def test_it_is_pressed_over_everything_that_opens(places: tuple[str, ...], page: Page, product: Product) -> None:
    found: list[str] = []
    for where in places:
        fresh(page)
        expect(BY_OPERATOR[where](page), where).to_be_visible()
        found += troubles(page, where)
        shot(page, f"over-{Path(where).stem}")
        press(page, product, touch=True, where=where)
        clear(page, product)
    for where in [where for where in LARGE if where in places]:
        page.set_viewport_size({"width": 1280, "height": 720})
        fresh(page)
        expect(BY_OPERATOR[where](page), where).to_be_visible()
        found += troubles(page, f"{where}, large")
        press(page, product, touch=False, where=where)
        clear(page, product)
    assert not found, "\n".join(found)


@pytest.mark.parametrize("places", [KINDS, pytest.param(tuple(BY_OPERATOR), marks=pytest.mark.long)])
def test_the_esc_that_closes_something_is_no_stop(places: tuple[str, ...], page: Page, product: Product) -> None:
    for where in places:
        fresh(page)
        expect(BY_OPERATOR[where](page), where).to_be_visible()
        by_keys(page, product, where)
        clear(page, product)


def test_a_step_of_the_guide_that_is_done_meanwhile_takes_no_esc(page: Page, product: Product) -> None:
    expect(guide(page)).to_be_visible()
    page.evaluate(GUIDE_GOES_ON)
    escape_twice(page)
    expect(page.get_by_test_id("stop-news")).to_contain_text("E-STOP arrived at the rig")
    clear(page, product)


def test_it_is_pressed_over_the_question_before_a_take_over(page: Page, product: Product) -> None:
    ask(page, "DELETE", "/api/lease")
    with httpx.Client(base_url=product.origin, trust_env=False) as other:
        other.post("/api/session", json={"token": product.url.split("token=")[1]}).raise_for_status()
        for where, opener in BY_OTHERS.items():
            other.post("/api/lease").raise_for_status()
            expect(opener(page)).to_be_visible()
            found = troubles(page, where)
            press(page, product, touch=True, where=where)
            assert not found, "\n".join(found)
            other.post("/api/lease").raise_for_status()
            # The press comes by two ways, and drops a clear that waits: whichever is later.
            wait_until(lambda: other.post("/api/command", json={"request": "clear"}).is_success)
        other.delete("/api/lease")
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    wait_until(lambda: ask(page, "POST", "/api/lease"))
