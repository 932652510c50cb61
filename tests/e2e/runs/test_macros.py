"""A macro from its editor to its end: written by mouse and keys, run by one button, seen by others, ended by Esc."""

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from controller.schema.modes import Mode
from tests.e2e.edge import ask, troubles
from tests.e2e.product import Product, frame, open_page, shot, wait_until
from tests.e2e.ui.test_accessibility import in_both_schemes, load_axe

pytestmark = pytest.mark.keyed("frontend/src", "server/operate", "server/runs", "tests/e2e/*.py", imports=False)


@pytest.fixture
def operator(page: Page) -> Iterator[Page]:
    """The page with the lease, the rig vented."""
    page.get_by_test_id("lease-take").click()
    expect(page.get_by_test_id("arm")).to_have_attribute("aria-disabled", "false")
    yield page
    ask(page, "POST", "/api/command", request="rest")
    for name in ("warm-up", "warm-up 2"):
        ask(page, "DELETE", f"/api/macros/{name}")
    ask(page, "DELETE", "/api/lease")


def step(page: Page, n: int, kind: str) -> Locator:
    """Make step `n` one of this kind, adding it where there is none yet."""
    steps = page.get_by_test_id("macro-step")
    if steps.count() < n:
        page.get_by_test_id("macro-add").click()
    page.get_by_label(f"Step {n}", exact=True).select_option(label=kind)
    return steps.nth(n - 1)


def test_a_macro_is_written_run_by_one_button_seen_by_a_viewer_and_ended_by_esc(
    operator: Page, browser: Browser, product: Product
) -> None:
    load_axe(operator)
    operator.get_by_test_id("macro-new").click()
    step(operator, 2, "Move the target").get_by_test_id("step-y").fill("120")
    step(operator, 3, "Wait").get_by_test_id("step-seconds").fill("600")
    step(operator, 4, "Follow a reference")
    operator.get_by_role("button", name="Move step 4 up").click()
    operator.get_by_role("button", name="Remove step 3").click()
    operator.get_by_role("button", name="Move step 3 up").focus()
    operator.keyboard.press("Enter")
    operator.get_by_role("button", name="Move step 2 down").press("Enter")
    operator.get_by_test_id("macro-name").fill("warm-up")
    findings = in_both_schemes(operator, "macro editor", ".macros")
    shot(operator, "macro-editor-1280")
    operator.get_by_test_id("macro-save").click()
    expect(operator.get_by_test_id("macro")).to_contain_text("3 steps")

    operator.get_by_test_id("macro-run").click()
    expect(operator.get_by_test_id("macro-bar")).to_contain_text("Macro warm-up: step 3 of 3, wait 600 s")
    wait_until(lambda: abs(frame(operator)["target"][1] - 0.12) < 1e-4)
    assert product.mode() == Mode.FOLLOW
    shot(operator, "macro-running-1280")
    context = browser.new_context(viewport={"width": 390, "height": 844}, color_scheme="light")
    other = open_page(context, product)
    expect(other.get_by_test_id("macro-bar")).to_contain_text("step 3 of 3, wait 600 s")
    expect(other.get_by_test_id("macro-stop")).to_have_attribute("aria-disabled", "true")
    assert troubles(other, "macro bar") == []
    load_axe(other)  # it keeps a slow page from giving presence: not the operator's, whose rig would hold
    findings += in_both_schemes(other, "macro bar", ".macro-bar")
    shot(other, "macro-running-390")
    operator.keyboard.press("Escape")
    for page in (operator, other):
        expect(page.get_by_test_id("macro-bar")).to_have_count(0)
        expect(page.get_by_test_id("macro-last")).to_contain_text("warm-up: ended at step 3 of 3, wait 600 s: HOLD")
    assert product.mode() == Mode.HOLD
    context.close()

    operator.get_by_test_id("macro-edit").click()
    operator.get_by_test_id("macro-name").fill("warm-up 2")
    operator.get_by_test_id("macro-save").click()
    expect(operator.get_by_test_id("macro")).to_have_count(1)
    operator.get_by_test_id("macro-run").click()
    expect(operator.get_by_test_id("macro-bar")).to_contain_text("step 3 of 3")
    operator.get_by_test_id("macro-stop").click()
    expect(operator.get_by_test_id("macro-last")).to_contain_text("stopped by")
    operator.get_by_test_id("macro-delete").click()
    operator.get_by_test_id("macro-delete").click()
    expect(operator.get_by_test_id("macro")).to_have_count(0)
    assert not findings, "\n".join(findings)
