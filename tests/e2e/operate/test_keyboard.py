"""By keys only: from the sign-in to two finished runs and their comparison; what vanishes hands the focus on."""

from playwright.sync_api import BrowserContext, expect

from tests.e2e.edge import ask
from tests.e2e.keyboard import Keys
from tests.e2e.product import Product, remember, wait_until
from tests.e2e.reviewing import coloured


def test_two_runs_and_their_comparison_need_no_pointer(context: BrowserContext, product: Product) -> None:
    remember(context, "tendril-guide", "seen")
    remember(context, "tendril-3d", "closed")
    page = context.new_page()
    page.goto(product.origin)
    keys, state = Keys(page), page.get_by_test_id("state")
    keys.at("token")
    page.keyboard.type(product.url.split("token=")[1])
    keys.press("Enter")
    keys.at("lease-take")
    keys.press("Enter")
    keys.at("primary-arm")
    keys.press("Enter")
    expect(state).to_contain_text("HOLD")
    keys.at("primary-follow")

    keys.press("2")
    expect(page.get_by_role("tab", name="Run")).to_be_focused()
    keys.go("reference")
    page.keyboard.type("Circle, 0.25")
    expect(page.get_by_role("listbox").get_by_role("option").first).to_have_text("Circle, 0.25 Hz")
    keys.press("ArrowDown", "Enter")
    expect(page.get_by_test_id("reference-facts")).to_be_visible()
    keys.go("run", most=13)
    keys.press("Enter")
    keys.at("pause-run")
    expect(page.get_by_test_id("run-result")).to_have_attribute("data-state", "done")
    keys.at("run")

    keys.press("4")
    keys.go("tuning-K_P")
    keys.press("ArrowUp", "Enter")
    keys.go("law", back=True)
    keys.press("Shift+Tab", "ArrowLeft", "ArrowLeft")
    expect(page.get_by_role("tab", name="Run")).to_be_focused()
    keys.go("run", most=13)
    keys.press("Enter")
    keys.at("pause-run")
    expect(page.get_by_test_id("run-compare")).to_be_visible()
    keys.at("run")

    keys.press("v")
    expect(page.get_by_role("heading", name="Recordings")).to_be_focused()
    first = page.get_by_test_id("recording").first
    keys.go("compare-tick", most=20)
    keys.press(" ", "ArrowDown", " ")
    expect(page.get_by_test_id("compare")).to_have_text("Compare 2")
    keys.go("compare", back=True, most=20)
    keys.press("Enter")
    expect(page.get_by_role("heading", name="2 recordings compared")).to_be_focused()
    rows = page.get_by_test_id("compare-table").locator("tbody tr")
    expect(rows).to_have_count(2)
    expect(page.get_by_test_id("quick-plot")).to_have_count(6)
    wait_until(lambda: coloured(page)[0] > 100)
    keys.go("back", back=True)
    keys.press("Enter")
    expect(first).to_be_visible()
    keys.look()
    assert keys.amiss == []
    ask(page, "DELETE", "/api/lease")
