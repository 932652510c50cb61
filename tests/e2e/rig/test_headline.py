"""The one mark and number that are always on screen: the number is that of the name beside it, from the first on."""

import pytest
from playwright.sync_api import Page, expect

pytestmark = pytest.mark.keyed("frontend/src", "server/health", "tests/e2e/*.py", imports=False)

NOTE_HEADLINES = """() => {
  const said = (window.__said = []), note = () => {
    const [name, number] = [".health-name", ".number"].map(
      (one) => document.querySelector(`[data-testid=health] ${one}`).textContent);
    if (!said.some(([a, b]) => a === name && b === number)) said.push([name, number]);
  };
  new MutationObserver(note).observe(document, { subtree: true, childList: true, characterData: true });
}"""
"""Keeps all that the headline says from now on: who asks a page ten times a second may miss one."""
A_ROUND_TRIP_MOST = 900.0
"""[ms]; the share of ticks on time, 1 or a little less, would read as nearly 1000 ms."""


def test_the_headline_never_shows_one_measures_number_under_anothers_name(page: Page) -> None:
    headline = page.get_by_test_id("health")
    expect(headline).to_contain_text("on time")
    expect(headline).to_contain_text("%")
    page.get_by_role("tab", name="Health").click()
    page.get_by_test_id("alarm-limits").click()
    page.evaluate(NOTE_HEADLINES)
    for colour, limit in (("amber", "0.01"), ("red", "0.02")):
        field = page.get_by_test_id(f"limit-round_trip-{colour}")
        field.fill(limit)
        field.press("Enter")
        expect(field).to_have_value(limit)
    expect(headline).to_contain_text("round trip")
    page.get_by_test_id("alarm-reset").click()
    expect(headline).to_contain_text("on time")
    page.wait_for_timeout(1000)  # beyond the next look at the number
    said: list[tuple[str, str]] = page.evaluate("window.__said")
    by_name = {name: [one for which, one in said if which == name] for name, _ in said}
    assert all(float(one.removesuffix(" ms")) < A_ROUND_TRIP_MOST for one in by_name["round trip"]), said
    assert all(float(one.removesuffix(" %")) > 50 for one in by_name["on time"]), said
