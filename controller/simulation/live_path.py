"""Task 5: a path that a user drew, replayed through FOLLOW as if it were drawn now.

The feedforward is solved at 100 Hz and K_FF is off, as in the paper; it has no limits of speed and acceleration, so
those of FOLLOW are at their maxima.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from controller import reference
from controller.arrays import Array, Rows
from controller.reference.path_file import read_samples
from controller.reference.reference import Reference
from controller.schema.modes import Mode, Request
from controller.schema.parameters import Settings
from controller.simulation.case import Case, Outcome, Setup, outcome, parameters_of, settings_of
from controller.simulation.run import armed, request, require_mode
from controller.simulation.simulate import Simulation

LIVE_PATH_FILE = Path(reference.__file__).parent / "data" / "live_path.csv"
INVERSE_PERIOD = 0.01
"""Of the feedforward [s] (paper, Task 5: "100 Hz")."""
LEAD = 3.0
"""How long the tip has, before the path begins, to go from rest to its first point [s]; not measured."""
FREE = {"feedforward_period": INVERSE_PERIOD, "K_FF": (0.0, 0.0), "speed_max": 1.0, "acceleration_max": 10.0}
"""Settings of a live reference; the limits are the largest that FOLLOW takes."""


@dataclass(frozen=True)
class MarkerPath:
    """Where a marker was when."""

    t: Array
    """(n,) [s], increasing."""
    p: Array
    """(n, 2) [m]."""

    def at(self, t: Array) -> Array:
        """The newest sample (m, 2) [m] at the times t (m,) [s] from the first on; before it, the first."""
        return self.p[np.clip(np.searchsorted(self.t - self.t[0], t, side="right") - 1, 0, None)]


def read_marker_path(path: Path = LIVE_PATH_FILE) -> MarkerPath:
    """The path in a CSV file, which `read_samples` describes. Raises DataError as it does."""
    samples = read_samples(path)
    return MarkerPath(samples.t, samples.p)


def run_live_case(case: Case, setup: Setup) -> Outcome:
    """Run the shipped path as `case` says. The reference of the outcome is the marker, projected into the reach."""
    return run_live(case, setup, read_marker_path())


def run_live(case: Case, setup: Setup, marker: MarkerPath) -> Outcome:
    """Follow `marker`; the same bits for the same case. Raises TendrilError if the rig does not to the end."""
    settings = live_settings(case, setup.gains)
    simulation = armed(parameters_of(case, setup), settings, case.seed)
    go_to(simulation, marker.p[0])
    rows, goals = replay_marker(simulation, marker)
    require_mode(rows, case.reference, Mode.FOLLOW, simulation.rig.control.dt)
    return outcome(case, Reference(case.reference, goals, start=0), rows)


def live_settings(case: Case, gains: Settings) -> Settings:
    """`gains` under the law of `case`, as a live reference has them."""
    return settings_of(case, gains).model_copy(update=FREE)


def go_to(simulation: Simulation, p: Array) -> None:
    """FOLLOW to the target p (2,) [m] for LEAD, until the next tick is one that solves the inverse."""
    simulation.command["target"] = p
    request(simulation, Request.FOLLOW)
    simulation.run(round(LEAD / simulation.rig.control.dt))
    simulation.run(-int(simulation.rig.control.state["tick"][0]) % inverse_ticks(simulation))


def inverse_ticks(simulation: Simulation) -> int:
    """Ticks from one inverse to the next."""
    return max(1, round(INVERSE_PERIOD / simulation.rig.control.dt))


def replay_marker(simulation: Simulation, marker: MarkerPath) -> tuple[Rows, Array]:
    """Telemetry (n,) while the target follows `marker`, and the marker projected into the reach (n, 2) [m].

    The target is written as often as it is looked at: what comes in between at the file's own rate is never seen.
    The projection is the tick's own, which is not in the telemetry: the tip's wish lags behind it.
    """
    pieces = round((marker.t[-1] - marker.t[0]) / INVERSE_PERIOD)
    rows, goals, every = [], np.empty((pieces, 2)), inverse_ticks(simulation)
    for piece, target in enumerate(marker.at(INVERSE_PERIOD * np.arange(pieces))):
        simulation.command["target"] = target
        rows.append(simulation.run(every))
        goals[piece] = simulation.rig.control.state["p_goal"][0]
    return np.concatenate(rows), np.repeat(goals, every, axis=0)
