"""The paper's numbers as data, and which of them the twin was fitted to (docs/conventions.md).

Source of each: its tables "Step response average error characterization" and "Summary of Tasks 1 and 2", and the text
of Tasks 1 to 4. Units are those of `metrics.UNITS`.
"""

from dataclasses import dataclass
from typing import Literal

from controller.errors import DataError
from controller.reference.library import STEP
from controller.simulation.metrics import UNITS, Window, step_spread

Role = Literal["fit", "consulted", "held-out", "paper gives none"]
FIT: Role = "fit"
CONSULTED: Role = "consulted"
HELD_OUT: Role = "held-out"
NONE: Role = "paper gives none"

ACTUATORS = ("P1", "P2", "P3")
STEP_LAWS = ("ff", "ff+p", "ff+i", "ff+pi")
SENSING_LAWS = ("ff", "rod6", "rod10", "rod6+10")
DIGITS = tuple(f"digit_{digit}" for digit in range(10))
SENSING = ("sensing_sweep", "sensing_circle", "sensing_vertical")
PERIODIC = (
    *("vertical_0.25hz", "vertical_1hz", "horizontal_0.25hz", "horizontal_1hz"),
    *("circle_0.25hz", "circle_1hz", "circle_2hz", "sensing_circle", "sensing_vertical"),
)
EXPERIMENTS = tuple(
    dict.fromkeys(("step", *DIGITS, "digits", "vu", *PERIODIC, *SENSING, "live_path", "frequency_sweep"))
)
"""Every name that a row may have; "digits" is the mean over the ten."""


@dataclass(frozen=True)
class PaperRow:
    """What the paper says about one metric of one experiment."""

    experiment: str
    actuator: str
    law: str
    metric: str
    unit: str
    paper: float | None = None
    """The one number to compare with; None where the paper gives none, or only bounds."""
    paper_low: float | None = None
    paper_high: float | None = None
    role: Role = NONE
    """Whether the twin was fitted to it, or a choice made with it in view. Without one number in the paper: NONE."""

    @property
    def key(self) -> tuple[str, str, str, str]:
        """What the row is about; no two rows share it."""
        return self.experiment, self.actuator, self.law, self.metric


def row(what: str, paper: float | None, role: Role, low: float | None = None, high: float | None = None) -> PaperRow:
    """Row about `what`: "experiment actuator law metric"."""
    experiment, actuator, law, metric = what.split()
    return PaperRow(experiment, actuator, law, metric, UNITS[metric][0], paper, low, high, role)


STEP_TABLE = {
    "ff": (30.5, 15.7, 3309.0),
    "ff+p": (23.8, 11.3, 2007.0),
    "ff+i": (19.1, 1.0, 1131.0),
    "ff+pi": (14.4, 1.0, 625.0),
}
"""RMSE [mm], SSE [mm], ISE [mm^2 s] by law, means over the four steps of P1."""

STEP_SPREAD = {law: step_spread(ise / STEP, rmse) for law, (rmse, _, ise) in STEP_TABLE.items()}
"""Standard deviation of the steps' RMSE over the four corners [mm]: what ISE says beyond RMSE (13, 10, 3.5, 1 mm)."""

SENSING_REDUCTION = {"sensing_sweep": 0.27, "sensing_circle": 0.74, "sensing_vertical": 0.34}
"""By how much sensing only rod 6 reduces the RMSE of FF (paper, Task 4). Absolute values are in a figure only."""

FITTED = (
    *(row(f"step P1 {law} rmse", rmse, FIT) for law, (rmse, _, _) in STEP_TABLE.items()),
    *(row(f"step P1 {law} sse", sse, FIT) for law, (_, sse, _) in STEP_TABLE.items()),
    row("vu P1 ff+pi rmse", 1.9, FIT),
    row("circle_1hz P1 ff+pi rmse", 7.4, FIT),
    row("vertical_0.25hz P1 ff+pi rmse", 7.4, FIT),
    row("horizontal_0.25hz P1 ff+pi rmse", 9.2, FIT),
    *(row(f"step P1 {law} step_spread", spread, FIT) for law, spread in STEP_SPREAD.items()),
    *(row(f"{name} P1 rod6 reduction", 100.0 * share, FIT) for name, share in SENSING_REDUCTION.items()),
)
"""All that `tendril calibrate` may look at."""

JUDGED = (
    row("digits P1 ff+pi rmse", 1.9, HELD_OUT, 1.5, 2.3),
    row("vu P2 ff+pi rmse", 3.7, HELD_OUT),
    row("circle_1hz P2 ff+pi rmse", 9.1, HELD_OUT),
)
"""The rows by which the reproduction is judged: no choice was made with one of them in view."""

SEEN = (
    row("vertical_1hz P1 ff+pi rmse", 8.8, CONSULTED),
    row("horizontal_1hz P1 ff+pi rmse", 12.4, CONSULTED),
    row("vu P3 ff+pi rmse", 2.6, CONSULTED),
    row("circle_1hz P3 ff+pi rmse", 5.5, CONSULTED),
    row("circle_2hz P3 ff+pi rmse", 11.4, CONSULTED),
    row("circle_2hz P3 ff+pi lag_deg_x", 27.0, CONSULTED),
)
"""Predicted as well, but looked at for a choice, now or in an earlier version: they prove little."""

BESIDE = tuple(row(f"step P1 {law} ise", ise, CONSULTED) for law, (_, _, ise) in STEP_TABLE.items())
"""No news beside the fitted rows: RMSE and `step_spread` make it up."""

PREDICTED = (*JUDGED, *SEEN, *BESIDE)
"""All rows with a number that the twin was not fitted to."""

BOUNDS = (
    *(row(f"{digit} P1 ff+pi rmse", None, NONE, 1.5, 2.3) for digit in DIGITS),
    *(
        row(f"{digit} P1 ff+pi {axis}", None, NONE, high=5.0)
        for digit in (*DIGITS, "digits")
        for axis in ("max_x", "max_y")
    ),
    *(row(f"vu P1 ff+pi {axis}", None, NONE, high=4.0) for axis in ("max_x", "max_y")),
)
"""Where the paper gives bounds, but no one number."""

PAPER_ROWS = (*FITTED, *PREDICTED, *BOUNDS)

FEEDBACK_SHARE = {0.1: 0.12, 2.0: 0.32}
"""Share of the feedback in the command by frequency [Hz] (paper, "supplementary frequency sweep"). Not a row: the paper
names neither shape nor actuator, and a row has no frequency."""

_BY_KEY = {paper_row.key: paper_row for paper_row in PAPER_ROWS}


def paper_row(experiment: str, actuator: str, law: str, metric: str) -> PaperRow:
    """What the paper says, if only that it says nothing. Raises DataError for a name that no row may have."""
    laws = SENSING_LAWS if experiment in SENSING else STEP_LAWS
    known = {experiment: EXPERIMENTS, actuator: ACTUATORS, law: laws, metric: tuple(UNITS)}
    for name, names in known.items():
        if name not in names:
            raise DataError(f"{name} is none of {', '.join(names)}")
    key = experiment, actuator, law, metric
    return _BY_KEY.get(key) or row(" ".join(key), None, NONE)


def window_of(experiment: str) -> Window:
    """Window of the paper's number: the whole run of a periodic task and of a live path (which has no approach).

    The paper says so of P3 at 2 Hz, the only window that it names for one (docs/conventions.md). The frequency sweep's
    share is of one frequency, so the approach, which has none, is left out. Raises DataError for an unknown name.
    """
    if experiment not in EXPERIMENTS:
        raise DataError(f"{experiment} is none of {', '.join(EXPERIMENTS)}")
    return Window.WHOLE if experiment in (*PERIODIC, "live_path") else Window.AFTER_APPROACH
