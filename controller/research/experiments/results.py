"""All that a reproduction found: what the table, the JSON file and the report are made of."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from controller.arrays import Array, Array32, Rows
from controller.reference.reference import Reference
from controller.research.experiments.paper_rows import PaperRow
from controller.schema.parameters import TwinParameters
from controller.simulation.case import Case, Setup
from controller.simulation.metrics import Window, true_tip

THINNED = 5
"""A trace keeps one tick of this many: 200 Hz draws everything that the arm does."""


@dataclass(frozen=True)
class Trace:
    """What figures need of a run, every THINNED-th tick; SI."""

    t: Array
    """(n,) [s] since the reference's first row."""
    p_ref: Array
    """(n, 2) [m] the tick's own reference, after speed limit and projection."""
    tip: Array
    """(n, 2) [m] the twin's true tip."""
    p_hat: Array
    """(n, 2) [m] the observer's tip."""
    u_ff: Array
    """(n, 2) [N m]."""
    u_fb: Array
    """(n, 2) [N m]."""
    pressure: Array
    """(n, 4) [Pa] measured in the chambers (u1+, u1-, u2+, u2-)."""
    pressure_cmd: Array
    """(n, 4) [Pa] asked of them."""
    backbone: Array32
    """(n, 21, 2) [m] the observer's."""
    twin_backbone: Array32
    """(n, 21, 2) [m] the twin's true one."""


def trace(rows: Rows, dt: float) -> Trace:
    """Every THINNED-th of `rows` (n,), ticks of dt [s]."""
    thin = rows[::THINNED]
    copies = {name: thin[name].copy() for name in ("p_ref", "p_hat", "u_ff", "u_fb", "pressure_cmd")}
    return Trace(
        t=THINNED * dt * np.arange(len(thin), dtype=np.float64),
        tip=true_tip(thin),
        pressure=thin["pressure_meas"].copy(),
        backbone=thin["backbone"].astype(np.float32),
        twin_backbone=thin["twin_backbone"].astype(np.float32),
        **copies,
    )


@dataclass(frozen=True)
class Finished:
    """A run that came to its end, light enough to keep: an `Outcome` with its telemetry thinned."""

    case: Case
    reference: Reference
    trace: Trace
    metrics: dict[Window, dict[str, float]]
    """In the units of `metrics.UNITS`; what does not apply is left out."""
    unkept: str = ""
    """Why its telemetry could not be kept."""


@dataclass(frozen=True)
class Failure:
    """A run that did not come to its end."""

    case: Case
    sentence: str


@dataclass(frozen=True)
class ResultRow:
    """One number of ours beside the paper's."""

    about: PaperRow
    ours: float | None
    """Mean over the seeds in the paper's window; None where a run failed."""
    ours_std: float | None
    """Standard deviation over the seeds; None with one."""
    window: Window
    """The paper's window, in which `ours` is."""
    ours_other_window: float | None
    seeds: int
    failed: str = ""
    """Why there is no number."""
    interval: tuple[float, float] | None = None
    """In which the near-equal fits put the number, from 5 to 95 %; None where the plant or the law is not the fit's."""
    extra: dict[str, Any] = field(default_factory=dict)
    """What only this row has: the frequency sweep's whole curve."""

    @property
    def ratio(self) -> float | None:
        """Ours over the paper's; None where either is missing."""
        paper = self.about.paper
        return None if self.ours is None or paper is None else self.ours / paper

    @property
    def inside(self) -> bool | None:
        """Whether the paper's number is in the interval; None where either is missing."""
        if self.about.paper is None or self.interval is None:
            return None
        return self.interval[0] <= self.about.paper <= self.interval[1]


@dataclass(frozen=True)
class SensedLaw:
    """One choice of sensors on one trajectory of Task 4."""

    law: str
    rmse: tuple[float, ...]
    """Of each run [mm], in the order of the seeds."""
    normalised: tuple[float, ...]
    """The same over the largest of all runs of this trajectory (the paper's axis)."""
    reduction: float
    """By which share the mean is below that of FF; nan where FF failed."""


@dataclass(frozen=True)
class SensedTrajectory:
    """One trajectory of Task 4; `laws` in the paper's order, without those that failed."""

    experiment: str
    laws: tuple[SensedLaw, ...]
    paper_reduction: float
    """Of rod 6 against FF."""
    ordered: bool
    """FF worst, rod 6 clearly better, rod 10 best or equal with 6+10 (means; `sensing_summary.EQUAL`)."""
    p_value: float | None
    """Of rod 10 against rods 6+10, Welch's t test; None with fewer than two runs. The paper: not significant."""


SensingSummary = tuple[SensedTrajectory, ...]


@dataclass(frozen=True)
class SweepPoint:
    """One frequency of the frequency sweep; None where a run failed."""

    frequency: float
    """[Hz]."""
    share: float | None
    """Of the feedback in the command, 0..1, mean over the seeds."""
    share_std: float | None
    share_pi: float | None
    """The same of PI alone: of a run with K_FF = 0, the first seed's."""
    rmse: float | None
    """[mm], after the approach."""
    lag_deg: tuple[float | None, float | None]
    """Along x and y."""
    paper: float | None
    """The paper's share, where it gives one."""
    failed: str = ""
    seeds: int = 1
    """Runs."""


@dataclass(frozen=True)
class PressureStep:
    """A chamber's answer to a step of its setpoint."""

    begin: float
    """Setpoint before the step [Pa]."""
    end: float
    """Setpoint after it [Pa]."""
    t: Array
    """(n,) [s], 0 at the step."""
    pressure: Array
    """(n,) [Pa]."""
    dead_time: float
    """Until 2 % of the step are done [s]; nan if never."""
    t63: float
    """From there until 63 % are done [s]; nan if never."""

    @property
    def rises(self) -> bool:
        """Whether the chamber is filled."""
        return self.end > self.begin


@dataclass(frozen=True)
class ObserverGain:
    """The observer with other gains than the paper's."""

    K_o: float
    """[N/m]."""
    B_o: float
    """[N s/m]."""
    carry_on: bool
    """Whether a marker is carried on to the present with its velocity, or held."""
    observer_rmse: dict[str, float]
    """By reference, over the whole run [mm]; nan for a run that was broken off."""


@dataclass(frozen=True)
class LetterRow:
    """RMSE of one run by our law and by the paper's equations to the letter [mm], in the paper's window."""

    experiment: str
    actuator: str
    paper: float | None
    ours: float | None
    """None, as the next, where the rig broke the run off."""
    letter: float | None
    failed: str = ""
    """Why the letter's run was broken off."""


@dataclass(frozen=True)
class Results:
    """A whole reproduction."""

    outcomes: tuple[Finished, ...]
    """In the order of the catalogue, whatever ran first."""
    failures: tuple[Failure, ...]
    """Those with other gains included, which no row is about."""
    rows: tuple[ResultRow, ...]
    sensing: SensingSummary
    sweep: tuple[SweepPoint, ...]
    pressure: tuple[PressureStep, ...]
    observer: tuple[ObserverGain, ...]
    seconds: float
    """From the command to here, the report excluded."""
    setup: Setup
    seeds: tuple[int, ...]
    workers: int
    quick: bool
    runs: int
    """All that were made, those with other gains or laws included, which are not in `outcomes`."""
    letter: tuple[LetterRow, ...] = ()
    """The paper's equations to the letter beside ours; empty where they were not run."""

    @property
    def twin(self) -> TwinParameters:
        """The plant; its own seed is replaced by that of each run."""
        return self.setup.twin

    def of(self, reference: str, actuator: str = "P1", law: str = "ff+pi") -> tuple[Finished, ...]:
        """The finished runs of one case, a run a seed."""
        wanted = reference, actuator, law
        return tuple(one for one in self.outcomes if (one.case.reference, one.case.actuator, one.case.law) == wanted)
