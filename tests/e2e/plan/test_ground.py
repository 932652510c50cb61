"""Nothing that appears moves what is under the pointer, and a drag whose ground changes ends where it was."""

import random
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest
from playwright.sync_api import Browser, Page, expect

from controller.schema.modes import Mode
from tests.e2e.hand import Hand, arm
from tests.e2e.product import Product, remember, shot

pytestmark = pytest.mark.keyed("frontend/src", "server", "controller", "recordings", "tests/e2e/*.py", imports=False)
"""Of the whole product: whatever changes in it, this is tested again."""

PLACES = """() => Object.fromEntries(
  [".plan", ".plots", ".tabs", ...["e-stop", "arm", "hold", "follow"].map((name) => `[data-testid=${name}]`)]
    .map((at) => [at, JSON.stringify(document.querySelector(at).getBoundingClientRect())]))"""
STRANGE = "() => { const bar = document.createElement('div'); bar.style.height = '44px'; bar.className = 'strange';"
CHANGES: dict[str, Callable[[Page], object]] = {
    "a bar above the page": lambda page: page.evaluate(STRANGE + "document.body.prepend(bar); }"),
    "a bar above the plan": lambda page: page.evaluate(STRANGE + "document.querySelector('main').before(bar); }"),
    "scrolling": lambda page: page.evaluate(
        STRANGE + "document.body.append(bar); document.scrollingElement.scrollTop = document.body.scrollTop = 44; }"
    ),
    "zoom of the page": lambda page: page.evaluate("() => { document.documentElement.style.zoom = 1.25 }"),
    "size of the window": lambda page: page.set_viewport_size({"width": 1180, "height": 660}),
    "fit": lambda page: page.evaluate("() => document.querySelector('.plan-fit').click()"),
    "another view": lambda page: page.get_by_text("Review", exact=True).dispatch_event("click"),
}
"""By name: what moves the plan, or how it looks at the plane, under the pointer."""
CALM: dict[str, Callable[[Page], object]] = {
    "the wheel": lambda page: page.mouse.wheel(0, -300),
    "another tab": lambda page: page.get_by_role("tab", name="Log").dispatch_event("click"),
    "nothing": lambda page: None,
}
"""What does not, or is not heard meanwhile."""


@pytest.fixture
def asker(browser: Browser, product: Product) -> Iterator[Page]:
    """A viewer's page, in a profile of its own."""
    context = browser.new_context(viewport={"width": 900, "height": 600})
    remember(context, "tendril-guide", "seen")
    remember(context, "tendril-3d", "closed")
    page = context.new_page()
    page.goto(product.ready.viewer_url)
    expect(page.get_by_test_id("me")).to_have_attribute("data-role", "viewer")
    yield page
    context.close()


def held_within(product: Product, seconds: float) -> bool:
    """Whether the rig holds by then."""
    end = time.monotonic() + seconds
    while product.mode() != Mode.HOLD and time.monotonic() < end:
        time.sleep(0.02)
    return product.mode() == Mode.HOLD


def put_back(page: Page) -> None:
    """The page as it was."""
    page.evaluate("""() => {
      for (const bar of document.querySelectorAll('.strange')) bar.remove();
      document.documentElement.style.zoom = '';
      document.scrollingElement.scrollTop = document.body.scrollTop = 0; }""")
    page.set_viewport_size({"width": 1280, "height": 720})
    page.get_by_text("Live", exact=True).dispatch_event("click")
    page.get_by_role("tab", name="Control").dispatch_event("click")
    page.locator(".plan-fit").dispatch_event("click")
    page.wait_for_timeout(200)


def test_a_request_for_control_in_the_middle_of_a_drag_moves_nothing(page: Page, asker: Page, product: Product) -> None:
    arm(page)
    hand = Hand(page, product)
    hand.press()
    for _ in range(10):
        hand.move(-3, -4)
    hand.wait(Mode.FOLLOW)
    before, places = hand.settled(), page.evaluate(PLACES)
    asker.get_by_test_id("lease-menu").click()
    asker.get_by_test_id("lease-ask").click()
    expect(page.get_by_test_id("asking")).to_be_visible()
    assert page.evaluate(PLACES) == places
    shot(page, "asked-in-a-drag")
    hand.move(1, 0)
    assert np.linalg.norm(hand.settled() - before) <= 1.01 * hand.mm_per_px
    assert product.mode() == Mode.FOLLOW, "the drag goes on"
    hand.up()
    page.get_by_test_id("ask-refuse").click()
    expect(page.get_by_test_id("asking")).to_have_count(0)
    page.get_by_test_id("hold").click()
    page.get_by_test_id("lease-release").click()


def test_what_the_rig_and_others_do_moves_no_control(page: Page, asker: Page) -> None:
    arm(page)
    places = page.evaluate(PLACES)
    asker.get_by_test_id("e-stop").click()
    expect(page.get_by_test_id("latched")).to_be_visible()
    assert page.evaluate(PLACES) == places
    page.get_by_test_id("clear").click()
    expect(page.get_by_test_id("state")).to_contain_text("VENTED")
    page.route("**/api/lease", lambda route: route.abort())  # a page that is offline might know it before the press
    page.get_by_test_id("lease-release").click()
    expect(page.locator(".mantine-Notification-root").first).to_be_visible()
    assert page.evaluate(PLACES) == places
    page.unroute("**/api/lease")
    page.get_by_test_id("lease-release").click()


@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.long) for seed in range(1, 8))])
def test_whatever_changes_in_the_middle_of_a_drag_no_target_goes_further_than_its_pointer(
    seed: int, page: Page, product: Product
) -> None:
    """Random drags on the real rig, judged by every row of its ring."""
    dice = random.Random(seed)
    arm(page)
    hand = Hand(page, product)
    names = [*CHANGES, *CALM]
    dice.shuffle(names)
    for name in names:
        page.mouse.move(*page.evaluate("window.__tendril.handle()"))
        page.mouse.wheel(0, dice.choice((-200, 200)))  # "fit" then changes something
        page.wait_for_timeout(100)
        hand.press()
        start = hand.target()
        hand.wait(Mode.FOLLOW)
        way = [np.zeros(2)]
        for _ in range(dice.randint(1, 4)):
            hand.move(*(step := np.array([dice.randint(-9, 9), dice.randint(-9, 9)])))
            way.append(way[-1] + step)
        before, t_ns = hand.settled(), time.monotonic_ns()
        (CHANGES | CALM)[name](page)
        steps = [np.zeros(2)]
        for _ in range(dice.randint(1, 4)):
            hand.move(*(step := np.array([dice.randint(-20, 20), dice.randint(-20, 20)])))
            steps.append(steps[-1] + step)
            page.wait_for_timeout(40)
        furthest = max(np.linalg.norm(steps, axis=1)) * hand.mm_per_px
        hand.settled()
        rows = hand.rows(t_ns)
        jumps = np.linalg.norm(1e3 * rows["target"] - before, axis=1)
        assert jumps.max() <= furthest + 0.01, (
            f"seed {seed}, {name}: {jumps.max():.2f} mm by {furthest:.2f} mm of mouse"
        )
        if name in CHANGES:
            assert held_within(product, 10.0), name
            assert jumps.max() <= 0.01, f"{name}: the drag is over"
        else:
            assert (rows["mode"] == Mode.FOLLOW).all(), name
            assert np.linalg.norm(hand.target() - start) > 0 or not np.any(way[-1] + steps[-1])
        hand.up()
        put_back(page)
        page.get_by_test_id("hold").dispatch_event("click")
        hand.wait(Mode.HOLD)
    page.get_by_test_id("lease-release").click()


def test_a_drag_that_was_ended_says_so_and_a_new_press_goes_on(page: Page, product: Product) -> None:
    arm(page)
    hand = Hand(page, product)
    hand.press()
    hand.move(-10, -10)
    hand.wait(Mode.FOLLOW)
    page.set_viewport_size({"width": 1200, "height": 700})
    hand.wait(Mode.HOLD)
    expect(page.get_by_test_id("hint")).to_contain_text("The plan moved under the pointer")
    hand.move(-30, -30)
    page.wait_for_timeout(300)
    assert product.mode() == Mode.HOLD
    hand.up()
    hand.press()
    hand.wait(Mode.FOLLOW)
    hand.up()
    page.get_by_test_id("lease-release").click()
