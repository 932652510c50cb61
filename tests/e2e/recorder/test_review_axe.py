"""axe-core on Review: the list, one recording, the comparison, and what opens over them."""

import pytest
from playwright.sync_api import BrowserContext, expect

from tests.e2e.product import Product, open_page
from tests.e2e.recorded import record_circle
from tests.e2e.reviewing import choose_csv, open_link, review
from tests.e2e.ui.test_accessibility import in_both_schemes, load_axe

pytestmark = pytest.mark.keyed("frontend/src", "frontend/package-lock.json", "tests/e2e/*.py", imports=False)
"""How the page looks follows its own sources; what it shows has tests of its own that are always run."""


def test_axe_finds_nothing_serious_in_review_and_in_what_opens_there(context: BrowserContext, product: Product) -> None:
    made = [record_circle(product.recordings, f"Circle {n}", 3.0).id for n in range(2)]
    page = open_page(context, product)
    load_axe(page)
    page.get_by_test_id("lease-take").click()
    findings = []
    review(page)
    expect(page.get_by_test_id("recordings")).to_be_visible()
    findings += in_both_schemes(page, "list", "main.review")
    for place in (f"#review/compare/{made[0]},{made[1]}", f"#review/{made[0]}"):
        open_link(page, place)
        expect(page.get_by_test_id("quick-plot")).to_have_count(6)
        findings += in_both_schemes(page, place, "main.review")
    page.get_by_test_id("export").click()
    expect(page.get_by_test_id("export-dialog")).to_be_visible()
    findings += in_both_schemes(page, "export", "[role=dialog]")
    page.get_by_role("button", name="Close").click()
    page.get_by_test_id("back").click()
    choose_csv(page, "time;x;y\n0;70;140\n1;a;150\n")
    page.get_by_test_id("import-send").click()
    expect(page.get_by_test_id("import-problem")).to_be_visible()
    findings += in_both_schemes(page, "import", "[role=dialog]")
    page.get_by_role("button", name="Close").click()
    row = page.locator(f"[data-id='{made[1]}']")
    row.hover()
    row.get_by_test_id("delete-recording").click()
    findings += in_both_schemes(page, "deletion", "[role=dialog]")
    page.get_by_test_id("delete-confirm").click()
    expect(page.get_by_test_id("undo-deletion")).to_be_visible()
    findings += in_both_schemes(page, "undo", ".review-undo")
    page.get_by_test_id("lease-release").click()
    assert not findings, "\n".join(findings)
