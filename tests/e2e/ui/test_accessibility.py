"""Who cannot see well, or not at all, or uses no mouse: axe-core on every part of the page, the first visit by keys."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from controller.schema.palette import MEASURED, rgb
from tests.e2e.product import Product, open_page, shot, wait_until
from tests.e2e.tab import end_session

pytestmark = pytest.mark.keyed("frontend/src", "frontend/package-lock.json", "tests/e2e/*.py", imports=False)
"""How the page looks follows its own sources; what it shows has tests of its own that are always run."""

AXE = Path(__file__).parents[3] / "frontend/node_modules/axe-core/axe.min.js"
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa"]
COLOURS = ["color-contrast"]
"""All that the other scheme can change."""
SETTLED = """async () => {
  for (let i = 0; i < 3; i++) await new Promise(requestAnimationFrame); // what opens now begins to move with the next
  const moving = document.getAnimations().filter((one) => one.effect.getTiming().iterations < 9);
  await Promise.allSettled(moving.map((one) => one.finished));
}"""


def test_axe_finds_nothing_serious_in_any_tab_or_scheme_and_the_guide_is_shown_once(
    browser: Browser, product: Product
) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720}, color_scheme="dark")
    page = context.new_page()
    page.goto(product.origin)
    expect(page.get_by_test_id("sign-in")).to_be_visible()
    load_axe(page)
    findings = look(page, "sign-in, dark")
    page.emulate_media(color_scheme="light")
    findings += look(page, "sign-in, light", rules=COLOURS)
    page.close()
    page = open_page(context, product, guide=True)
    load_axe(page)
    findings += in_both_schemes(page, "guide")
    walk_the_guide(page)
    for scheme, rules in (("light", RULES), ("dark", COLOURS)):
        page.emulate_media(color_scheme=scheme)
        expect(page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)
        findings += look(page, f"live, {scheme}", rules=rules)
        for tab in page.locator(".tabs [role=tab]").all():
            tab.click()
            findings += look(page, f"{tab.inner_text()}, {scheme}", ".tabs", rules)
        page.get_by_text("Review", exact=True).click()
        expect(page.locator("main.review")).to_be_visible()
        findings += look(page, f"review, {scheme}", "main.review", rules)
        page.get_by_text("Live", exact=True).click()
    assert not findings, "\n".join(findings)
    choose_a_scheme(page)
    end_session(context)


def test_axe_finds_nothing_serious_in_records_runs_faults_and_in_what_opens(browser: Browser, product: Product) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720})
    page = open_page(context, product)
    load_axe(page)
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("lease-menu").click()
    expect(page.locator("[role=menu]")).to_be_visible()
    findings = in_both_schemes(page, "hand over", "[role=menu]")
    page.keyboard.press("Escape")
    page.get_by_test_id("arm").click()
    page.get_by_test_id("record").click()
    expect(page.get_by_test_id("record")).to_contain_text("REC")
    page.get_by_role("button", name="Keys").click()
    expect(page.get_by_test_id("keys")).to_be_visible()
    findings += in_both_schemes(page, "recording", ".header") + in_both_schemes(page, "Keys", "[role=dialog]")
    page.get_by_role("button", name="Close the list of keys").click()
    page.get_by_test_id("record").click()
    expect(page.get_by_test_id("record")).to_contain_text("Record")

    page.get_by_role("tab", name="Run").click()
    page.get_by_test_id("tool-shape").click()
    expect(page.get_by_role("menuitem").first).to_be_visible()
    findings += in_both_schemes(page, "Shapes", "[role=menu]")
    page.get_by_role("menuitem").first.click()
    page.get_by_test_id("drawing-name").fill("Shape")
    page.get_by_test_id("save-drawing").click()
    expect(page.get_by_test_id("saved-drawings")).to_contain_text("1")
    page.get_by_test_id("saved-drawings").click()
    expect(page.get_by_test_id("saved-drawing")).to_be_visible()
    findings += in_both_schemes(page, "Saved", ".mantine-Popover-dropdown")
    page.get_by_test_id("saved-drawings").click()

    page.get_by_test_id("timing").select_option("duration")
    page.get_by_test_id("duration").fill("4")
    page.get_by_test_id("run").click()
    expect(page.get_by_test_id("run-progress")).to_be_visible()
    findings += look(page, "run under way", ".run")  # axe keeps a slow page from giving presence: the run may break off
    expect(page.get_by_test_id("run-result")).to_be_visible()
    findings += in_both_schemes(page, "run's result", ".run")

    page.get_by_role("tab", name="Sensing").click()
    page.get_by_test_id("fault-sample_loss").fill("100")
    page.get_by_test_id("fault-sample_loss").press("Enter")
    expect(page.get_by_test_id("latched")).to_be_visible()
    findings += in_both_schemes(page, "fault")
    page.get_by_test_id("lease-release").click()
    assert not findings, "\n".join(findings)
    end_session(context)


EDGE = "e => [getComputedStyle(e).outlineStyle, parseFloat(getComputedStyle(e).outlineWidth) >= 2]"
REACHED = """e => {
  e.scrollIntoView({ block: "nearest", inline: "center", behavior: "instant" });
  const { x, y, width, height } = e.getBoundingClientRect();
  const hit = document.elementFromPoint(x + width / 2, y + height / 2);
  return width > 0 && hit !== null && (e.contains(hit) || hit.contains(e));
}"""


def test_with_the_systems_own_colours_samples_keep_theirs_and_what_is_chosen_has_an_edge(
    browser: Browser, product: Product
) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 720}, forced_colors="active")
    page = open_page(context, product)
    sample = page.locator(".legend .key-measured").first
    assert sample.evaluate("e => getComputedStyle(e).backgroundColor") == f"rgb{rgb(MEASURED)}"
    page.get_by_role("tab", name="Sensing").click()
    for chosen in (".chip[aria-pressed=true]", "[role=tab][aria-selected=true]", "[role=switch][aria-checked=true]"):
        assert page.locator(chosen).first.evaluate(EDGE) == ["solid", True], chosen
    stop = page.get_by_test_id("e-stop")
    expect(stop).to_be_visible()
    assert stop.evaluate("e => parseFloat(getComputedStyle(e).borderTopWidth)") >= 3
    shot(page, "forced-colours")
    end_session(context)


@pytest.mark.parametrize("zoom", [2, 4])
def test_every_control_can_be_reached_at_zoom(zoom: int, browser: Browser, product: Product) -> None:
    """A page of 1280 x 1024 that is zoomed lays itself out in fewer pixels (WCAG 1.4.10)."""
    context = browser.new_context(viewport={"width": 1280 // zoom, "height": 1024 // zoom})
    page = open_page(context, product)
    for tab in page.locator(".tabs [role=tab]").all():
        assert tab.evaluate(REACHED), tab.inner_text()
        tab.click()
        for control in page.locator(":is(.header, .stop-bar, .tabs [role=tabpanel]) :is(button, select, input)").all():
            if control.is_visible():
                assert control.evaluate(REACHED), f"{tab.inner_text()}: {control.evaluate('e => e.outerHTML')[:200]}"
    shot(page, f"zoom-{zoom}")
    end_session(context)


def load_axe(page: Page) -> None:
    """Before the first `look` at a page that was opened or loaded again."""
    page.evaluate(AXE.read_text() + "; 0")


def in_both_schemes(page: Page, place: str, part: str = "html") -> list[str]:
    """What axe finds in a part of the page, dark and light."""
    findings = []
    for scheme, rules in (("dark", RULES), ("light", COLOURS)):
        page.emulate_media(color_scheme=scheme)
        expect(page.locator("html")).to_have_attribute("data-mantine-color-scheme", scheme)
        findings += look(page, f"{place}, {scheme}", part, rules)
    return findings


def look(page: Page, place: str, part: str = "html", rules: Sequence[str] = RULES) -> list[str]:
    """What axe finds serious or critical in a part of the page as it is now, one line each."""
    page.evaluate(SETTLED)
    options = {"runOnly": rules, "iframes": False, "resultTypes": ["violations"]}
    found: dict[str, Any] = page.evaluate("([part, options]) => axe.run(part, options)", [part, options])
    return [
        f"{place}: {violation['id']}: {node['html'][:150]}"
        for violation in found["violations"]
        if violation["impact"] in ("serious", "critical")
        for node in violation["nodes"]
    ]


def walk_the_guide(page: Page) -> None:
    """Three steps by keyboard; a reload does not bring them back."""
    guide = page.get_by_test_id("guide")
    expect(guide).to_contain_text("1 of 3: Arm")
    page.get_by_test_id("guide-next").focus()
    page.keyboard.press("Enter")
    expect(guide).to_contain_text("2 of 3: Drag")
    expect(page.get_by_test_id("guide-next")).to_be_focused()
    page.keyboard.press("Enter")
    expect(guide).to_contain_text("3 of 3: Record")
    expect(page.get_by_test_id("guide-next")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    expect(guide).to_have_count(0)


def choose_a_scheme(page: Page) -> None:
    """Chosen by hand it is kept, whatever the system says; so is the end of the guide."""
    page.get_by_role("button", name="Light colours").click()
    page.reload()
    wait_until(lambda: page.evaluate("!!window.__tendril?.frame"))
    assert page.evaluate("document.documentElement.dataset.mantineColorScheme") == "light"
    expect(page.get_by_test_id("guide")).to_have_count(0)
