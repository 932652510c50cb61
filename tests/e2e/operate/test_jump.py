"""A fault of the twin from the page's menus: the rig stops by itself, and the page says what to check."""

from playwright.sync_api import Page, expect

from tests.e2e.product import shot


def test_markers_that_jump_stop_the_rig_and_the_page_says_what_to_check(page: Page) -> None:
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    page.get_by_role("tab", name="Sensing").click()
    page.get_by_test_id("fault-jump").select_option("50 mm up")
    expect(page.get_by_role("alert")).to_contain_text(
        "FAULT: the rig went to rest by itself (markers jumped). "
        "Check that the camera was not moved and markers are not swapped, then the gains, then press Clear fault"
    )
    shot(page, "fault-jump")
    page.get_by_test_id("faults-off").click()
    expect(page.get_by_test_id("fault-jump")).to_have_value("no")
    page.get_by_test_id("clear-latch").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    page.get_by_test_id("lease-release").click()
