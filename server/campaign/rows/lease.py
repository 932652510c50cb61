"""Control that is lost while a run of the operator is on its way to the rig."""

import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import NamedTuple

import httpx

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.person import Person
from server.campaign.scene import CIRCLE, QUIET_SECONDS, Scene
from server.campaign.waiting import Seen, require, wait

HANGING = 30.0
"""For which the run would stay where control is lost [s]; it is let go on as soon as it was refused."""
PLANNED_S = 0.3
"""After which a request has come to be planned [s]."""


class Moment(NamedTuple):
    """Where the run is then, and how control is lost."""

    name: str
    call: str
    """What hangs meanwhile, """
    argument: str
    """if it is called with this."""
    reached: Callable[[Scene, int], bool]
    """Whether the run has come there, by what the page shows; the second is the id of the run before it."""
    lose: Callable[[Scene, Person], None]


def lost_planning(scene: Scene) -> Seen:
    """The one who has control then is present all the time, so that nothing but the permit keeps the rig still."""
    other = Person(scene.url)
    try:
        found = [_lost(scene, other, moment) for moment in MOMENTS]
    finally:
        other.close()
    scene.operator.operate()
    scene.acts_again()
    return Seen("; ".join(one.observed for one in found), max(one.reaction_ms for one in found))


def _lost(scene: Scene, other: Person, moment: Moment) -> Seen:
    scene.hold()
    before, start = _run(scene), time.monotonic_ns()
    order = {"calls": [moment.call], "argument": moment.argument, "how": "hang", "seconds": HANGING}
    scene.break_inside(scene.server_process, **order)
    with ThreadPoolExecutor(1) as pool:
        answer = pool.submit(scene.operator.request, "POST", "/api/run", reference=CIRCLE, laps=None)
        wait(lambda: answer.done() or moment.reached(scene, before), HANGING / 2, f"a run that is {moment.name}")
        require(not answer.done(), f"{moment.name}: the run did not wait")
        lost = time.monotonic_ns()
        moment.lose(scene, other)
        other.operate()
        told = _refused(answer)
    took = (time.monotonic_ns() - lost) * 1e-6
    scene.go_on_inside()
    _nothing_comes_of_it(scene, other, start)
    _give_back(scene, other)
    return Seen(f"{moment.name}: {told}", took)


def _refused(answer: Future[httpx.Response]) -> str:
    """The sentence by which the run was refused."""
    found = answer.result()
    require(400 <= found.status_code < 500, f"the run was answered with {found.status_code}: {found.text[:200]}")
    return str(found.json()["detail"])


def _nothing_comes_of_it(scene: Scene, other: Person, start: int) -> None:
    """Neither while the run hung nor once it went on: the rig holds, no run and no recording are left."""
    time.sleep(QUIET_SECONDS)
    rows = scene.since(start)
    require((rows["mode"] == Mode.HOLD).all() and not trace.calm(rows), f"moved all the same: {trace.calm(rows)}")
    over = other.request("POST", "/api/run/stop")
    require(over.status_code == 409 and "no run is under way" in over.text, f"a run is left: {over.text}")
    wait(lambda: not other.status["recording"]["recording"], 5.0, "the end of the run's recording")


def _give_back(scene: Scene, other: Person) -> None:
    other.present = False
    other.ask("DELETE", "/api/lease")
    scene.operator.ask("POST", "/api/session", token=scene.url.split("token=")[1])
    scene.operator.reconnect()


def _run(scene: Scene) -> int:
    """Of the last run; 0 before the first."""
    run = scene.operator.status["run"]
    return run["id"] if run else 0


def _taken_over(scene: Scene, other: Person) -> None:
    other.ask("POST", "/api/lease/take-over", tag=wait(lambda: other.status["people"]["holder"], 5.0, "who operates"))


def _signed_out(scene: Scene, other: Person) -> None:
    """The socket of its page ends with the session."""
    gone = scene.operator.request("DELETE", "/api/session")
    require(gone.status_code == 204, f"signing out was answered with {gone.status_code}: {gone.text}")


def _given_back(scene: Scene, other: Person) -> None:
    scene.operator.ask("DELETE", "/api/lease")


def _soon(scene: Scene, before: int) -> bool:
    time.sleep(PLANNED_S)  # no sign tells that it is planned
    return True


def _recorded(scene: Scene, before: int) -> bool:
    return bool(scene.operator.status["recording"]["recording"])


def _asked(scene: Scene, before: int) -> bool:
    return _run(scene) != before


MOMENTS = (
    Moment("planned", "server.rig.planner:Planner.call", "function lap ", _soon, _taken_over),
    Moment("uploaded", "server.rig.client:Rig.plan", "", _recorded, _signed_out),
    Moment("sent", "server.operate.operator:Operator._call", "TRACK", _asked, _given_back),
)
