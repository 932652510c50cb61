"""The phases of a run as data: where each event leads, how long each phase may last, and what its end closes.

`Runs` acts by these tables, docs/running.md shows them, and the tests walk through them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum, auto
from pathlib import Path
from time import monotonic

from controller.text.markdown import filled, table
from server.runs import messages

PAGE = Path("docs/running.md")


class Phase(Enum):
    """Where a run is; the last four are ends."""

    PREPARING = "being prepared"
    """Planned, held, recorded, uploaded: nothing moves yet."""
    STARTING = "starting"
    """The rig was asked to track it."""
    APPROACH = "in approach"
    RUNNING = "running"
    PAUSING = "being paused"
    """The rig was asked to hold, for a pause."""
    STOPPING = "being stopped"
    """The same, for the end."""
    BREAKING = "being broken off"
    """The same, because its operator no longer operates."""
    PAUSED = "paused"
    RETURNING = "paused, and being prepared"
    """It is to go on: held, uploaded."""
    RESUMING = "going on"
    """It is to go on, and the rig was asked to track it."""
    DONE = "done"
    STOPPED = "stopped"
    BROKEN = "broken off"
    REFUSED = "refused"
    """It never began."""


class Event(Enum):
    """What can happen to a run."""

    PAUSE = "asked to pause"
    RESUME = "asked to go on"
    STOP = "asked to stop"
    READY = "prepared"
    REFUSED = "refused by the rig, or cannot be"
    UNHELD = "the rig refused to hold"
    LEAD = "row of the approach"
    SHAPE = "row of the shape"
    FINISHED = "row: reference done"
    HELD = "row: HOLD, asked for"
    REDIRECTED = "row: another mode, asked for"
    LEFT = "row: left TRACK by itself"
    LEASE_LOST = "its operator no longer operates"
    RIG_LOST = "rig restarted, or silent for 5 s"
    ROWS_LOST = "its rows were not read"
    LATE = "it took too long"
    CLOSED = "the server ends"


_P, _E = Phase, Event
_BROKEN: dict[Event, Phase] = {event: _P.BROKEN for event in (_E.RIG_LOST, _E.ROWS_LOST, _E.LATE, _E.CLOSED)}
_TRACKED: dict[Event, Phase] = {
    _E.LEAD: _P.APPROACH,
    _E.SHAPE: _P.RUNNING,
    _E.FINISHED: _P.DONE,
    _E.HELD: _P.STOPPED,
    _E.REDIRECTED: _P.STOPPED,
    _E.LEFT: _P.BROKEN,
    _E.STOP: _P.STOPPING,
    _E.LEASE_LOST: _P.BREAKING,
    **_BROKEN,
}
"""Of every phase in which the rig may move."""
_WAITING: dict[Event, Phase] = {
    _E.STOP: _P.STOPPED,
    _E.REDIRECTED: _P.STOPPED,
    _E.LEFT: _P.BROKEN,
    _E.LEASE_LOST: _P.BROKEN,
    **_BROKEN,
}
"""Of every phase between two legs."""


def _halting(phase: Phase, held: Phase) -> dict[Event, Phase]:
    """While the rig is to hold its rows change nothing until it does, or has left by itself."""
    return {**_TRACKED, _E.LEAD: phase, _E.SHAPE: phase, _E.HELD: held, _E.UNHELD: _P.RUNNING}


TRANSITIONS: dict[Phase, dict[Event, Phase]] = {
    _P.PREPARING: {
        _E.READY: _P.STARTING,
        **dict.fromkeys((_E.REFUSED, _E.STOP, _E.LEASE_LOST, _E.RIG_LOST, _E.ROWS_LOST, _E.LATE), _P.REFUSED),
        _E.CLOSED: _P.REFUSED,
    },
    _P.STARTING: {**_TRACKED, _E.REFUSED: _P.REFUSED},
    _P.APPROACH: {**_TRACKED, _E.PAUSE: _P.PAUSING},
    _P.RUNNING: {**_TRACKED, _E.PAUSE: _P.PAUSING},
    _P.PAUSING: {**_halting(_P.PAUSING, _P.PAUSED)},
    _P.STOPPING: {**_halting(_P.STOPPING, _P.STOPPED), _E.REFUSED: _P.STOPPED},
    _P.BREAKING: {
        **_halting(_P.BREAKING, _P.BROKEN),
        _E.REFUSED: _P.BROKEN,
        _E.STOP: _P.BREAKING,
        _E.UNHELD: _P.BREAKING,
    },
    _P.PAUSED: {**_WAITING, _E.RESUME: _P.RETURNING, _E.LATE: _P.STOPPED},
    _P.RETURNING: {**_WAITING, _E.READY: _P.RESUMING, _E.REFUSED: _P.PAUSED, _E.LATE: _P.PAUSED},
    _P.RESUMING: {**_TRACKED, _E.REFUSED: _P.PAUSED},
    _P.DONE: {},
    _P.STOPPED: {},
    _P.BROKEN: {},
    _P.REFUSED: {},
}
"""Phase after an event; what is missing is refused where a person asked for it, and changes nothing else."""

ASKED = (_P.STARTING, _P.RESUMING)
"""The rig was asked to track, and no row has shown it yet."""
HALTING = (_P.PAUSING, _P.STOPPING, _P.BREAKING)
"""The rig was asked to hold."""
MOVING = (_P.STARTING, _P.RESUMING, _P.APPROACH, _P.RUNNING, *HALTING)
"""The rig tracks it, or may: an end out of these that no row shows asks the rig to hold."""
ENDS = (_P.DONE, _P.STOPPED, _P.BROKEN, _P.REFUSED)

HOUR = 3600.0
SILENCE = 5.0
"""Longest wait for a row that tells [s]: the link asks twice for half a second each, and a busy machine is slower."""
DEADLINES: dict[Phase, float] = {
    _P.PREPARING: 60.0,
    _P.STARTING: SILENCE,
    _P.PAUSING: SILENCE,
    _P.STOPPING: SILENCE,
    _P.BREAKING: SILENCE,
    _P.PAUSED: HOUR,
    _P.RETURNING: 15.0,
    _P.RESUMING: SILENCE,
}
"""Longest stay [s]. APPROACH and RUNNING last as long as rows in TRACK come, and 5 s beyond them."""


class Closes(Enum):
    """What an end closes, beside the inbox, which every end does."""

    RECORDING = auto()
    """The one that was begun for the run."""
    RESULT = auto()
    """Kept and told."""
    MOTION = auto()
    """The rig is asked to hold, unless its rows say that it does."""


CLOSES: dict[Phase, tuple[Closes, ...]] = {
    _P.DONE: (Closes.RECORDING, Closes.RESULT),
    _P.STOPPED: (Closes.RECORDING, Closes.RESULT, Closes.MOTION),
    _P.BROKEN: (Closes.RECORDING, Closes.RESULT, Closes.MOTION),
    _P.REFUSED: (Closes.RECORDING,),
}

SHOWN: dict[Phase, messages.Phase] = {
    _P.PREPARING: "approach",
    _P.STARTING: "approach",
    _P.APPROACH: "approach",
    _P.RUNNING: "running",
    _P.PAUSED: "paused",
    _P.RETURNING: "paused",
    _P.RESUMING: "approach",
    _P.DONE: "done",
    _P.STOPPED: "stopped",
    _P.BROKEN: "broken off",
    _P.REFUSED: "broken off",
}
"""What the page is told; while the rig is to hold, what the run was before."""


@dataclass
class Machine:
    """The phase of one run, why, and since when. It does nothing but follow the table."""

    clock: Callable[[], float] = monotonic
    phase: Phase = Phase.PREPARING
    reason: str = ""
    """Why it was paused or ended, or will be once the rig holds."""
    shown: messages.Phase = "approach"
    since: float = 0.0

    def __post_init__(self) -> None:
        self.since = self.clock()

    @property
    def moving(self) -> bool:
        """Whether the rig tracks it, or may."""
        return self.phase in MOVING

    @property
    def ended(self) -> bool:
        """Whether nothing more comes of it."""
        return self.phase in ENDS

    def allows(self, event: Event) -> bool:
        """Whether the event leads anywhere from here."""
        return event in TRANSITIONS[self.phase]

    def meet(self, event: Event, reason: str = "") -> bool:
        """Go where the event leads, because of `reason`; False where it leads nowhere.

        Where a hold was asked for, the reason is that of who asked, not of the row that says it.
        """
        after = TRANSITIONS[self.phase].get(event)
        if after is None:
            return False
        if after == self.phase:
            return True
        asked = self.phase in HALTING and event in (Event.HELD, Event.REFUSED)
        self.reason = self.reason if asked else reason
        self.phase, self.since = after, self.clock()
        self.shown = SHOWN.get(after, self.shown)
        return True

    def late(self) -> bool:
        """Whether the phase has lasted longer than it may."""
        return self.clock() - self.since > DEADLINES.get(self.phase, float("inf"))


def where(machine: Machine) -> str:
    """The phase in words, and why."""
    return ": ".join(filter(None, [f"the run is {machine.phase.value}", machine.reason]))


def too_long(machine: Machine) -> str:
    """What has lasted longer than it may."""
    seconds = DEADLINES[machine.phase]
    if machine.phase in HALTING:
        return f"the rig did not hold within {seconds:g} s"
    if machine.phase in ASKED:
        return f"the rig did not answer within {seconds:g} s"
    if machine.phase == Phase.RETURNING:
        return machine.reason
    return f"it was {machine.phase.value} for {seconds:g} s"


def markdown() -> str:
    """The table of docs/running.md: one line a phase, where its events lead."""
    rows = []
    for phase, events in TRANSITIONS.items():
        if phase in ENDS:
            continue
        ways = {after: [e.value for e, to in events.items() if to == after] for after in events.values()}
        led = "; ".join(f"**{to.value}**: {', '.join(names)}" for to, names in ways.items() if to != phase)
        rows.append([phase.value, _bound(phase), led])
    return table(["phase", "ends at the latest", "where it leads"], rows)


def _bound(phase: Phase) -> str:
    seconds = DEADLINES.get(phase)
    return "5 s after the last row" if seconds is None else f"{seconds:g} s"


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(), "phases", markdown()))
