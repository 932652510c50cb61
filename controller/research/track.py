"""Any path on the twin: read, planned, run through the real tick in TRACK, measured like the paper's experiments."""

import math
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from controller.arrays import Rows
from controller.assembly.controllers.registry import controllers
from controller.errors import DataError, ParameterError, TendrilError
from controller.reference.drawn import Wish, drawn
from controller.reference.feasible.within_reach import Carried
from controller.reference.path_file import read_samples
from controller.reference.reference import Reference
from controller.research.experiments.paper_rows import NONE, PaperRow
from controller.research.experiments.result_rows import ALWAYS
from controller.research.experiments.results import ResultRow
from controller.research.report.result_json import row_json
from controller.schema.actuator import Actuator
from controller.schema.fit import GAIN_NAMES
from controller.schema.parameters import DT, RigParameters, Settings, usual_twin
from controller.simulation.case import Case, Setup, controller_of, settings_of
from controller.simulation.metrics import UNITS, Window, measure
from controller.simulation.repeats import learn
from controller.simulation.run import for_reference, run, seeded
from controller.system.progress import ProgressCallback, no_progress

OFF_PATH = 1e-3
"""The loop's own reference is off the path where it is further than this from it: a change of branch [m]."""
PERIODIC = ("lag_deg_x", "lag_deg_y")
"""Metrics that a periodic path has beside those of every run."""


@dataclass(frozen=True)
class TrackTask:
    """What to run."""

    file: Path
    actuator: Actuator
    law: str = "ff+pi"
    seed: int = 0
    wish: Wish = field(default_factory=Wish)
    setup: Setup = field(default_factory=Setup)
    """The plant with its changes; its controller's period is the reference's."""
    body: Actuator | None = None
    """What is simulated, where it is another body than the model's `actuator`."""
    learn: int = 0
    """Repeats from which it is learned before it is measured."""


@dataclass(frozen=True)
class Facts:
    """What there is to know of a reference; SI."""

    name: str
    file: str
    duration: float
    """Without the approach [s]."""
    approach: float
    """In front of the shape [s]: what is not in the window after the approach."""
    own_approach: float
    """How much of it the file brings [s]."""
    steps: int
    """Of a path that holds still between jumps; 0 for any other."""
    length: float
    """Without the approach [m]."""
    peak_speed: float
    """Without the approach [m/s]; a jump counts as one tick's motion."""
    frequency: float | None
    """[Hz], of a periodic path."""
    axis_frequencies: tuple[float, float] | None
    """[Hz] at which x and y swing, where that is another one."""
    velocity_feedforward: bool
    projected_share: float
    """Share of the path that was out of reach and is the nearest reachable one instead."""
    projected_most: float
    """How far it was out of reach at most [m]."""
    branch_changes: tuple[float, ...]
    """When after the file's first point the static inverse has to go on in another pose [s]."""
    off_path_seconds: float | None = None
    """How long the loop's own reference was off the path because it changed the branch [s]; None for a broken run."""


@dataclass(frozen=True, eq=False)
class Tracked:
    """A run and its metrics, or why it was broken off."""

    task: TrackTask
    reference: Facts
    seconds: float
    """Of this computation."""
    window: Window
    """That of `rows`: the whole run of a periodic path, else after the approach, as in the reproduction."""
    windows: dict[Window, dict[str, float]]
    """All metrics that apply, in the units of `metrics.UNITS`; empty for a broken run."""
    path: Reference
    """That the rig was given."""
    parameters: RigParameters
    """Of the rig that ran, with the seed."""
    settings: Settings
    """In force in the run."""
    rows: Rows | None
    """Telemetry (n,), one row a tick of `path`; None for a broken run."""
    failed: str = ""
    """Why the rig broke the run off."""
    notes: tuple[str, ...] = ()
    """What the file does not say, as `Samples` has it."""
    learned: tuple[float, ...] = ()
    """RMSE after the approach of each repeat from which it was learned [m]; nan for one that was broken off."""


def track(task: TrackTask, told: ProgressCallback = no_progress) -> Tracked:
    """Run and measure; the same task gives the same bits. `told` is told of the run, once the path is planned.

    Raises DataError and ParameterError for a file or a number that cannot be used. A run that the rig breaks off is no
    error here: its result says why.
    """
    begin = time.perf_counter()
    setup = replace(task.setup, twin=usual_twin(task.body or task.actuator, task.setup.twin))
    task = replace(task, setup=setup)
    parameters = RigParameters(
        actuator=task.actuator,
        controller=controller_of(task.law, setup.controller),
        twin=setup.twin,
        plant_actuator=task.body,
    )
    samples = read_samples(task.file)
    reference, path = drawn(samples, task.actuator, task.wish)
    case = Case(reference.name, task.actuator.name, task.law, task.seed)
    settings = for_reference(settings_of(case, setup.gains), reference)
    rows, windows, failed = None, {}, ""
    learned: tuple[float, ...] = ()
    if task.learn:
        found = learn(parameters, reference, settings, range(task.seed + 1, task.seed + 1 + task.learn), told)
        reference, learned = found.reference, found.rmse
    try:
        rows = run(parameters, reference, settings, task.seed, told)
        windows = {window: measure(rows, reference, window) for window in Window}
    except (DataError, ParameterError):
        raise
    except TendrilError as error:
        failed = f"{error} (the approach of {reference.start * DT:g} s included)"
    return Tracked(
        task=task,
        reference=facts(task.file, reference, path, rows),
        seconds=time.perf_counter() - begin,
        window=Window.AFTER_APPROACH if reference.frequency is None else Window.WHOLE,
        windows=windows,
        path=reference,
        parameters=seeded(parameters, task.seed),
        settings=settings,
        rows=rows,
        failed=failed,
        notes=samples.notes,
        learned=learned,
    )


def facts(file: Path, reference: Reference, path: Carried, rows: Rows | None) -> Facts:
    """Facts of `reference`; `rows` (n,) is the telemetry of its run, None where that was broken off."""
    shape = np.linalg.norm(np.diff(reference.p[reference.start :], axis=0), axis=1)
    off = None if rows is None else np.linalg.norm(rows["p_ref"] - reference.p, axis=1) > OFF_PATH
    return Facts(
        name=reference.name,
        file=str(file),
        duration=len(shape) * DT,
        approach=reference.start * DT,
        own_approach=(reference.start - (len(reference.p) - len(path.p))) * DT,
        steps=len(reference.steps),
        length=float(shape.sum()),
        peak_speed=float(shape.max(initial=0.0)) / DT,
        frequency=reference.frequency,
        axis_frequencies=reference.axis_frequencies,
        velocity_feedforward=reference.velocity_feedforward,
        projected_share=float(np.mean(path.distance > 0.0)),
        projected_most=float(path.distance.max()),
        branch_changes=tuple(row * DT for row in path.changes),
        off_path_seconds=None if off is None else float(off.sum() * DT),
    )


def result_rows(tracked: Tracked) -> list[ResultRow]:
    """Rows as those of a reproduction, of one run; the paper gives none of these."""
    task, reference = tracked.task, tracked.reference
    (other,) = set(Window) - {tracked.window}
    here, there = (tracked.windows.get(window, {}) for window in (tracked.window, other))
    return [
        ResultRow(
            about=PaperRow(reference.name, task.actuator.name, task.law, metric, UNITS[metric][0], role=NONE),
            ours=here.get(metric),
            ours_std=None,
            window=tracked.window,
            ours_other_window=there.get(metric),
            seeds=1,
            failed=tracked.failed,
        )
        for metric in UNITS
        if metric in (here or expected(reference))
    ]


def expected(reference: Facts) -> tuple[str, ...]:
    """Metrics that a run of `reference` would have had."""
    return (*ALWAYS, *(PERIODIC if reference.frequency else ()), *(("sse",) if reference.steps else ()))


def figures(tracked: Tracked) -> dict[str, Any]:
    """All of it as JSON."""
    twin = tracked.task.setup.twin.model_copy(update={"seed": tracked.task.seed})
    found: dict[str, Any] = {
        "rows": [row_json(row) for row in result_rows(tracked)],
        "seconds": tracked.seconds,
        "twin": twin.model_dump(mode="json"),
        "plant_actuator": tracked.task.body and tracked.task.body.name,
        "reference": asdict(tracked.reference),
        "windows": {str(window): metrics for window, metrics in tracked.windows.items()},
        "controller": controllers()[tracked.settings.controller].name,
        "gains": {name: getattr(tracked.task.setup.gains, name) for name in GAIN_NAMES},
    }
    if tracked.learned:
        found["learned"] = [1e3 * one if math.isfinite(one) else None for one in tracked.learned]
    return found | ({"failed": tracked.failed} if tracked.failed else {})
