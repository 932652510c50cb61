"""The 3D view: dragging viser's gizmo moves the same target as the plan view."""

import math
import time

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from controller.schema.modes import Mode
from server.http.frames import DRAW_SPARINGLY
from tests.e2e.product import Product, frame, open_page, pixels_of, shot, wait_until

pytestmark = pytest.mark.keyed("frontend/src", "server", "controller", "recordings", "tests/e2e/*.py", imports=False)
"""Of the whole product: whatever changes in it, this is tested again."""

BLUE = (54, 142, 226)
"""The square of viser's transform control for the xy plane, as it is drawn."""


def gizmo(page: Page) -> tuple[float, float] | None:
    """Where the gizmo is drawn [window pixels], None while it is not; only pixels tell: it has its own process."""
    box = page.locator("iframe[title*='3D']").bounding_box()
    assert box
    found = pixels_of(page, BLUE, dict(box))
    return tuple(found.mean(axis=0)) if len(found) > 8 else None


def settled(page: Page) -> list[float]:
    """The target once all that the slow view has heard of the pointer has reached the rig [m]."""
    seen = [frame(page)["target"]]
    while len(seen) < 5 or any(math.dist(one, seen[-1]) > 1e-6 for one in seen[-5:]):
        time.sleep(0.2)
        seen.append(frame(page)["target"])
    return list(seen[-1])


def test_dragging_the_gizmo_moves_the_target_and_the_tip_follows(context: BrowserContext, product: Product) -> None:
    page = open_page(context, product, with_3d=True)
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    wait_until(lambda: gizmo(page))
    at = gizmo(page)
    assert at
    before = frame(page)["p_ref"]
    page.mouse.move(*at)
    time.sleep(1.0)  # software rendering: the gizmo must have seen the pointer over it
    page.mouse.down()
    for step in range(1, 11):
        page.mouse.move(at[0] - 2 * step, at[1] - 3 * step)
        time.sleep(0.2)
    wait_until(lambda: math.dist(before, frame(page)["target"]) > 0.02)
    assert frame(page)["mode"] == Mode.FOLLOW
    there = settled(page)
    page.get_by_test_id("toggle-3d").evaluate("bar => { bar.parentElement.style.height = '90px' }")
    wait_until(lambda: frame(page)["mode"] == Mode.HOLD)
    page.mouse.move(at[0] - 60, at[1] - 90)
    time.sleep(0.5)
    assert frame(page)["mode"] == Mode.HOLD, "a drag whose frame moved is over"
    assert math.dist(there, frame(page)["target"]) < 1e-3
    page.mouse.up()
    page.get_by_test_id("follow").click()
    wait_until(lambda: math.dist(frame(page)["p_meas"], frame(page)["target"]) < 5e-3)
    shot(page, "gizmo")
    page.get_by_test_id("disarm").click()
    wait_until(lambda: frame(page)["mode"] == Mode.VENTED)
    page.get_by_test_id("lease-release").click()


def test_a_press_of_the_gizmo_without_control_says_why(context: BrowserContext, product: Product) -> None:
    page = open_page(context, product, with_3d=True)
    wait_until(lambda: gizmo(page))
    at = gizmo(page)
    assert at
    page.mouse.move(*at)
    time.sleep(1.0)  # as above
    page.mouse.down()
    expect(page.get_by_test_id("scene-hint")).to_contain_text("only the operator may do this")
    shot(page, "gizmo refused")
    page.mouse.up()


def test_a_3d_view_drawn_in_software_draws_less_while_the_target_is_held(
    context: BrowserContext, product: Product
) -> None:
    stand_in = f"""<head>{DRAW_SPARINGLY.decode()}</head><script>
      let before = 0;
      window.gaps = [];
      const step = (now) => {{ gaps.push(now - before); before = now; requestAnimationFrame(step); }};
      requestAnimationFrame(step);
    </script>"""
    headers = {
        "content-type": "text/html",
        "cross-origin-embedder-policy": "require-corp",
    }  # as our page asks of frames
    context.route("**/viser/seat/**", lambda route: route.fulfill(body=stand_in, headers=headers))
    page = open_page(context, product, with_3d=True)
    scene = page.locator("iframe[title*='3D']").element_handle().content_frame()
    assert scene
    page.get_by_test_id("lease-take").click()
    page.get_by_test_id("arm").click()
    expect(page.get_by_test_id("state")).to_contain_text("HOLD")
    wait_until(lambda: scene.evaluate("window.gaps && Math.min(...gaps.slice(-20)) < 60"))
    x, y = page.evaluate("window.__tendril.handle()")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x - 5, y)
    wait_until(lambda: scene.evaluate("gaps.length > 5 && Math.min(...gaps.slice(-5)) > 95"))
    page.mouse.up()
    wait_until(lambda: scene.evaluate("Math.min(...gaps.slice(-20)) < 60"))
    page.get_by_test_id("disarm").click()
    page.get_by_test_id("lease-release").click()
