"""People who leave, sleep or come in pairs."""

import time

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.person import Person
from server.campaign.processes import held
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require, wait

NIGHT = 7.0
"""For which a laptop sleeps, longer than the lease lasts [s]."""
WATCHED = 3.0
"""For which two people want the rig [s]."""


def page_closed(scene: Scene) -> Seen:
    """The socket ends, and with it everything that the page sent."""
    scene.drag()
    start = time.monotonic_ns()
    scene.operator.dragging = False
    scene.operator.vanish()
    observed, took = held(scene, start)
    scene.stays_calm()
    scene.operator.reconnect()
    scene.stays_calm()
    scene.acts_again()
    return Seen(f"{observed}; nothing moved when the page was open again", took)


def laptop_asleep(scene: Scene) -> Seen:
    """No message, no close; after waking the page goes on with its presence as if nothing had been."""
    scene.drag()
    start = time.monotonic_ns()
    scene.operator.asleep = True
    observed, took = held(scene, start)
    time.sleep(max(0.0, NIGHT - (time.monotonic_ns() - start) * 1e-9))
    other = Person(scene.url)
    try:
        lease = other.ask("GET", "/api/session")["lease"]
        require(not lease["held"], f"{lease['holder']} still holds the lease after {NIGHT:g} s")
    finally:
        other.close()
    scene.operator.asleep = False
    scene.stays_calm()
    scene.operator.dragging = False
    scene.operator.operate()
    scene.acts_again()
    return Seen(f"{observed}; the lease was free, waking moved nothing", took)


def two_operators(scene: Scene) -> Seen:
    """Judged twice: while both are there, and when only the one without the lease is."""
    scene.track()
    second, start = Person(scene.url), time.monotonic_ns()
    try:
        second.present = True
        codes = [
            second.request("POST", "/api/lease").status_code,
            second.request("POST", "/api/command", request="hold").status_code,
            second.request("POST", "/api/command", request="follow", target=[0.03, 0.14]).status_code,
        ]
        second.drag()
        time.sleep(WATCHED)
        require(all(400 <= code < 500 for code in codes), f"the second was answered with {codes}")
        wait(lambda: any("only the operator" in line for line in second.log), 5.0, "a refusal of the second's target")
        rows = scene.since(start)
        require((rows["mode"] == Mode.TRACK).all(), f"the first was disturbed: {trace.told(rows[-1])}")
        start = time.monotonic_ns()
        scene.operator.present = False
        observed, took = held(scene, start)
        scene.stays_calm()
    finally:
        second.close()
    scene.operator.operate()
    scene.acts_again()
    return Seen(f"the second was answered with {codes}; the first went on, and alone the second had {observed}", took)
