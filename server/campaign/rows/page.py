"""The operator's own page in a real chromium: killed, busy or hung, with a painter that throws, signing in twice."""

import contextlib
import os
import signal
import time
from collections.abc import Callable, Iterator
from typing import TYPE_CHECKING

from controller.schema.modes import Cause, Mode
from server.campaign import trace
from server.campaign.chromium import READY, a_browser, kill_browser, operating_page, press_and_move
from server.campaign.processes import held
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require, wait

if TYPE_CHECKING:
    from playwright.sync_api import Page

BUSY, HUNG = 2000, 12_000
"""For which the main thread does nothing else [ms]; for good as far as a watchdog is concerned."""
SILENT = "nothing was heard of the page for 5 s"
SPIN = "(ms) => { const end = performance.now() + ms; while (performance.now() < end); }"
THROW = """() => {
  const arc = CanvasRenderingContext2D.prototype.arc;
  window.mend = () => { CanvasRenderingContext2D.prototype.arc = arc; };
  CanvasRenderingContext2D.prototype.arc = function () { throw new Error("no arc"); };
}"""
"""The plan's painters of actuator and path draw arcs, those of grid and plots do not."""
SIGN_IN = """async ([token, times]) => {
  const field = document.querySelector("form input");
  if (!field) return; // the other tab was faster, and its session is this one's, too
  Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(field, token);
  field.dispatchEvent(new Event("input", { bubbles: true }));
  await new Promise((resolve) => setTimeout(resolve, 100));
  for (let i = 0; i < times; i++) field.form.requestSubmit();
}"""
TOGETHER = 3
"""Times that each of two tabs signs in at once."""


@contextlib.contextmanager
def _dragging(scene: Scene) -> "Iterator[Page]":
    """A page whose mouse holds the target; the scene's own operator leaves it the lease."""
    scene.drag()
    scene.operator.dragging = scene.operator.present = False
    scene.operator.command("hold")
    scene.operator.ask("DELETE", "/api/lease")
    with operating_page(scene.url) as page:
        press_and_move(page)
        scene.until(time.monotonic_ns(), (Mode.FOLLOW,), 10.0)
        yield page
    scene.operator.reconnect()
    scene.acts_again()


def killed(scene: Scene) -> Seen:
    """A real chromium, and a real mouse that is held down."""
    with _dragging(scene):
        start = time.monotonic_ns()
        kill_browser()
        observed, took = held(scene, start)
        scene.stays_calm()
    return Seen(observed, took)


def busy(scene: Scene) -> Seen:
    """As a machine under load makes it: the page is open, and hears nothing."""
    with _dragging(scene) as page:
        start = time.monotonic_ns()
        page.evaluate(SPIN, BUSY)
        page.wait_for_timeout(500)
        rows = scene.since(start)
        lost = rows[rows["cause"] == Cause.OPERATOR_LOST]
        require(not len(lost), "HOLD (operator lost) though the page was open")
        other = rows[rows["mode"] != Mode.FOLLOW]
        require(not len(other), f"went to {', '.join(trace.told(row) for row in other[:1])}")
    return Seen(f"FOLLOW through {(rows['t_ns'][-1] - start) * 1e-9:.1f} s", trace.longest_gap_ms(rows))


def hung(scene: Scene) -> Seen:
    """The worker lives on, and must not speak for a page that no one can use."""
    with _dragging(scene) as page:
        start = time.monotonic_ns()
        page.evaluate(f"() => {{ setTimeout({SPIN}, 0, {HUNG}) }}")
        row = scene.until(start, (Mode.HOLD,), HUNG / 1e3 - 2.0)
        require(row["cause"] == Cause.OPERATOR_LOST, f"{trace.told(row)} instead of HOLD (operator lost)")
        page.evaluate("1")  # it comes back
        scene.stays_calm()
    return Seen(f"{trace.told(row)}; nothing moved when it came back", (row["t_ns"] - start) * 1e-6)


def control_lost(scene: Scene) -> Seen:
    """While the mouse holds the target: who looks at the plan is told there, and can read it later."""
    found = [_lost(scene, *way) for way in WAYS]
    return Seen("; ".join(one.observed for one in found), max(one.reaction_ms for one in found))


def _lost(scene: Scene, lose: Callable[[Scene, "Page"], str], why: str) -> Seen:
    with _dragging(scene) as page:
        mark, start = len(scene.operator.log), time.monotonic_ns()
        of_server = lose(scene, page)
        row = scene.until(start, (Mode.HOLD,), HUNG / 1e3 - 2.0)
        hint = page.get_by_test_id("hint").filter(has_text=why)
        hint.wait_for(timeout=READY)
        took, said = (time.monotonic_ns() - start) * 1e-6, hint.inner_text()
        page.get_by_role("tab", name="Log", exact=True).dispatch_event("click")  # the mouse is down elsewhere
        line = said.replace("Control lost", "You no longer operate")
        page.get_by_test_id("log").filter(has_text=line).wait_for(timeout=READY)
        if of_server:
            scene.operator.sees(of_server, mark)
        scene.stays_calm()
    return Seen(f"{trace.told(row)}, {said!r}", took)


def _stands_still(scene: Scene, page: "Page") -> str:
    page.evaluate(f"() => {{ setTimeout({SPIN}, 0, {HUNG}) }}")
    return f"no longer operates: {SILENT}"


def _taken_over(scene: Scene, page: "Page") -> str:
    scene.operator.ask("POST", "/api/lease/take-over", tag=scene.operator.status["people"]["holder"])
    return "took control from"


def _server_dies(scene: Scene, page: "Page") -> str:
    os.kill(scene.server_process, signal.SIGKILL)
    return ""  # its log ends with it


WAYS = (
    (_stands_still, SILENT),
    (_taken_over, "took control over"),
    (_server_dies, "the server was started again"),
)
"""How control is lost, and what is said of it."""


def painter(scene: Scene) -> Seen:
    """One of the plan's layers; the others, the plots and the numbers are painted as before."""
    with _dragging(scene) as page:
        start = time.monotonic_ns()
        page.evaluate(THROW)
        mark = page.get_by_test_id("not-drawn")
        mark.wait_for(timeout=READY)
        took = (time.monotonic_ns() - start) * 1e-6
        said = mark.inner_text()
        page.get_by_test_id("health").dispatch_event("click")  # the mouse is down elsewhere
        frames, seen = (page.evaluate("window.__tendril.frames"), page.get_by_test_id("command-age").inner_text())
        wait(lambda: page.get_by_test_id("command-age").inner_text() != seen, 10.0, "a number that is written on")
        require(page.evaluate("window.__tendril.frames") > frames, "the stream stood still")
        require((scene.since(start)["mode"] == Mode.FOLLOW).all(), "the drag ended")
        page.evaluate("window.mend()")
        mark.wait_for(state="detached", timeout=READY)
    return Seen(f"marked {said!r}, the drag and the numbers went on; mended it was drawn again", took)


def two_sign_ins(scene: Scene) -> Seen:
    """In two tabs of a browser without a session, each several times: a page has one live socket, of one session."""
    scene.drag()
    scene.operator.dragging = False
    token = scene.url.split("token=")[1]
    start = time.monotonic_ns()
    with a_browser() as browser:
        context = browser.new_context(viewport={"width": 1280, "height": 720})
        tabs = [context.new_page() for _ in range(2)]
        for tab in tabs:
            tab.goto(scene.operator.origin)
            tab.get_by_test_id("token").wait_for(timeout=READY)
        for tab in tabs:
            tab.evaluate(SIGN_IN, [token, TOGETHER])
        for tab in tabs:
            tab.get_by_test_id("state").wait_for(timeout=READY)
        viewers = 1 + len(tabs)  # the scene's operator is one
        wait(lambda: _viewers(scene) == viewers, 10.0, f"{viewers} live sockets; there are {_viewers(scene)}")
        took = (time.monotonic_ns() - start) * 1e-6
        names = {tab.get_by_test_id("me").get_attribute("aria-label") for tab in tabs}
        require(len(names) == 1, f"the tabs are of different sessions: {names}")
        time.sleep(2.0)
        require(_viewers(scene) == viewers, f"{_viewers(scene)} live sockets of {viewers} pages")
    wait(lambda: _viewers(scene) == 1, 10.0, "the sockets of closed tabs to end")
    scene.acts_again()
    return Seen(f"{viewers - 1} tabs signed in {TOGETHER} times each have one live socket each, of one session", took)


def _viewers(scene: Scene) -> int:
    return int(scene.operator.ask("GET", "/api/health")["viewers"])
