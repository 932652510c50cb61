"""Work that takes the processor or Python's lock away from the rig."""

import os
import subprocess
import sys
import time

import numpy as np

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.processes import held
from server.campaign.scene import Scene
from server.campaign.table import GAP
from server.campaign.waiting import Seen, require, wait

HOGS = 2
"""Busy processes for every core."""
HOGGED = 5.0
BRIEF, LONG = 1.0, 4.0
"""How long the rig's GIL is held [s]: before and after it comes to rest."""


def cpu_hog(scene: Scene) -> Seen:
    """They have the usual priority, as a compiler has."""
    scene.track()
    start = time.monotonic_ns()
    hogs = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(HOGS * (os.cpu_count() or 1))]
    try:
        time.sleep(HOGGED)
        rows = scene.since(start)
    finally:
        for hog in hogs:
            hog.kill()
            hog.wait()
    modes = [Mode(mode) for mode in dict.fromkeys(rows["mode"].tolist())]
    require(modes in ([Mode.TRACK], [Mode.TRACK, Mode.HOLD]), f"went through {', '.join(mode.name for mode in modes)}")
    scene.acts_again()
    lost = int(rows["lost"][-1] - rows["lost"][0])
    return Seen(
        f"{' then '.join(mode.name for mode in modes)}; {lost} of {len(rows)} ticks lost", trace.longest_gap_ms(rows)
    )


def gil_hog(scene: Scene) -> Seen:
    """Pump, link and desk stand still; the loop needs none of them."""
    scene.track()
    start = time.monotonic_ns()
    scene.break_inside(scene.rig_process, hold_gil=BRIEF)
    observed, took = held(scene, start)
    time.sleep(BRIEF)
    gap = _loop_went_on(scene, start)
    scene.stays_calm()
    scene.acts_again()
    return Seen(f"{observed}; longest gap of the loop {gap:.0f} ms", took)


def pump_dead(scene: Scene) -> Seen:
    """Longer than the rig waits for its pump."""
    scene.track()
    start = time.monotonic_ns()
    scene.break_inside(scene.rig_process, hold_gil=LONG)
    row = scene.until(start, (Mode.REST,), LONG)
    time.sleep(max(0.0, LONG - (time.monotonic_ns() - start) * 1e-9))
    gap = _loop_went_on(scene, start)
    rows = scene.since(start)
    require(np.isin(rows["mode"], (Mode.HOLD,)).any(), "no HOLD before REST")
    wait(lambda: scene.mode == Mode.VENTED, 20.0, f"VENTED; the rig is in {scene.mode.name}")
    scene.stays_calm()
    scene.operator.reconnect()
    scene.acts_again()
    return Seen(f"HOLD, {trace.told(row)}, VENTED; longest gap of the loop {gap:.0f} ms", (row["t_ns"] - start) * 1e-6)


def _loop_went_on(scene: Scene, start: int) -> float:
    gap = trace.longest_gap_ms(scene.since(start))
    require(gap < 1e3 * GAP, f"the loop stood still for {gap:.0f} ms")
    return gap
