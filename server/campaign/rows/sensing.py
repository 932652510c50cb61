"""Motion capture that fails, as the twin's own faults do it."""

import time
from typing import Any

import numpy as np

from controller.schema.modes import Cause, Freeze, Mode
from server.campaign import trace
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require
from server.log.events import words

OLD = 0.05
"""Age of a sample from which on there is no feedback [s] (SafetyLimits.measurement_old)."""
SLACK = 3.0
"""After which a reaction is not waited for any more [s]."""
NONE: dict[str, Any] = {"sample_loss": 0.0}
NO_SAMPLE: dict[str, Any] = {"sample_loss": 1.0}


def inject(scene: Scene, **faults: Any) -> None:
    """Break the twin like this, and in no other way."""
    scene.operator.ask("PUT", "/api/twin/faults", **faults)


def latched(scene: Scene, mode: Mode, cause: Cause, seconds: float, **faults: Any) -> Seen:
    """Inject `faults` for `seconds`: the rig has to go to `mode` because of `cause` and stay there until cleared."""
    scene.track()
    mark, start = len(scene.operator.log), time.monotonic_ns()
    inject(scene, **faults)
    try:
        row = scene.until(start, (mode,), SLACK + seconds)
        line = scene.operator.sees(f"rig: {words(mode)}", mark)
        time.sleep(max(0.0, seconds - (time.monotonic_ns() - start) * 1e-9))
    finally:
        inject(scene, **NONE)
    require(row["cause"] == cause, f"{trace.told(row)} instead of {cause.name}")
    scene.stays_calm()
    require(scene.mode == mode, f"in {scene.mode.name} though no one cleared it")
    scene.acts_again()
    return Seen(f"{trace.told(row)}, latched; page: {line}", (row["t_ns"] - start) * 1e-6)


def dropout_short(scene: Scene) -> Seen:
    """Two samples."""
    return _dropout(scene, 0.02)


def dropout_long(scene: Scene) -> Seen:
    """Longer than a sample is good for."""
    seen = _dropout(scene, 0.2)
    require("off" in seen.observed, "the feedback was never off")
    return seen


def lost(scene: Scene) -> Seen:
    """Longer than the rig waits."""
    return latched(scene, Mode.FAULT, Cause.MEASUREMENT_LOST, 5.0, **NO_SAMPLE)


def nan(scene: Scene) -> Seen:
    """Samples come, and none has a number in it."""
    return latched(scene, Mode.FAULT, Cause.MEASUREMENT_LOST, 2.0, marker_loss=1.0)


def old(scene: Scene) -> Seen:
    """A camera program that hangs, and a driver that goes on."""
    return latched(scene, Mode.FAULT, Cause.MEASUREMENT_LOST, 2.0, freeze=Freeze.OLD_TIME)


def frozen(scene: Scene) -> Seen:
    """The same with a driver that says when it asked, not when the camera looked."""
    return latched(scene, Mode.FAULT, Cause.MEASUREMENT_FROZEN, 2.0, freeze=Freeze.FRESH_TIME)


def jump(scene: Scene) -> Seen:
    """A camera that was pushed."""
    return latched(scene, Mode.FAULT, Cause.MEASUREMENT_JUMPED, 2.0, jump=[0.05, 0.0])


def _dropout(scene: Scene, seconds: float) -> Seen:
    scene.track()
    start = time.monotonic_ns()
    inject(scene, **NO_SAMPLE)
    time.sleep(seconds)
    inject(scene, **NONE)
    time.sleep(1.0)
    rows = scene.since(start)
    age, blind = rows["measurement_age"], rows["sensed"] == 0
    require((rows["mode"] == Mode.TRACK).all(), f"the rig went to {trace.told(rows[-1])}")
    require(not (blind & (age < OLD)).any(), "the feedback was off though samples were fresh")
    require(not blind[-1], "the feedback stayed off")
    stale = rows[(age > OLD) & ~blind]
    late = float(np.max(stale["measurement_age"] - OLD, initial=0.0))
    scene.acts_again()
    off = f"feedback off for {blind.sum()} ms" if blind.any() else "feedback on"
    return Seen(f"TRACK, oldest sample {1e3 * age.max():.0f} ms, {off}", 1e3 * late)
