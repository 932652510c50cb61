"""Static poses over both torques, and free decays: measured tables as `tendril identify` reads them."""

import asyncio
import csv
import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydantic import JsonValue

from controller.arrays import Array, Rows
from controller.errors import CommandRefused, ParameterError
from controller.schema.actuator import Actuator
from controller.system.whole_file import write_whole
from server.hardware.commissioning import planning
from server.hardware.commissioning.messages import Number
from server.hardware.commissioning.planning import Release, still_markers
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import KEPT_TEXT, Found
from server.hardware.first_mode.messages import MeasuredMode
from server.operate.procedure.motion import POLL_S, STILL_WINDOW_S, Torques

POSES, DECAYS = "poses.csv", "decays.csv"
STILL = 5e-4
"""A pose rests where its tip swings by less (rms) [m]."""
POSE_MIN_S, POSE_MAX_S = 0.8, 4.0
"""A pose is waited for so long at least, and at most [s]."""
STILL_SHARE = 0.8
"""Share of the poses that must have come to rest."""
WATCHED, DECAYS_LONGEST = 2.5, 6.0
"""A decay is watched so long at least, and at most [s]."""
FREE, FREE_LEAST = 0.05, 5e3
"""A release is over where the pressures are below this share of those before it, or below what a sensor may show of an
open chamber [Pa]."""
SAMPLE = 0.01
"""Between two samples of a decay at least [s]."""
SAMPLES_LEAST = 150
"""`tendril identify` takes no shorter decay."""
TRAVEL = 0.3
"""The tip is released from so far off its rest at most, as a share of the length: further out one mode is not all."""


async def statics(run: StepRun) -> Found:
    """Every pose of the grid, one after another, each at rest."""
    rods = run.file.motion_capture.rods
    torques = await run.parts.planner.do(planning.sweep_torques, run.parameters, run.body.grid, run.body.share)
    await run.take_rig()
    lines, rested, here = list[list[float]](), 0, (0.0, 0.0)
    for number, u in enumerate(torques):
        run.say(f"pose {number + 1} of {len(torques)}", number / len(torques))
        await run.lead(here, u)
        rested += await run.still(POSE_MIN_S, POSE_MAX_S, STILL)
        lines.append(_pose(run.late(STILL_WINDOW_S), rods))
        here = u
    await run.lead(here, (0.0, 0.0))
    await _write(run.parts.folder / POSES, ["p1", "p2", *_axes(rods)], lines)
    return judged_poses(np.array(lines), rested, run.actuator)


def judged_poses(poses: Array, rested: int, actuator: Actuator) -> Found:
    """By the table (n, 2 + 2 m) of pressures [Pa] and markers [m], `rested` of which came to rest."""
    tips, share = poses[:, -2:], rested / max(1, len(poses))
    bound = f"at least {STILL_SHARE:.0%}"
    swept = float(np.ptp(tips[:, 1])) if len(tips) else 0.0
    numbers = (
        Number(name="poses", value=len(poses), unit="1"),
        Number(name="poses at rest", value=share, unit="1", bound=bound, kept=share >= STILL_SHARE),
        Number(name="tip along y", value=swept, unit="m"),
        Number(name="furthest tip", value=float(np.linalg.norm(tips, axis=1).max(initial=0.0)), unit="m"),
    )
    data: dict[str, JsonValue] = {"tips": np.round(tips, 5).tolist(), "length": actuator.length}
    if share < STILL_SHARE:
        text = f"{rested} of {len(poses)} poses came to rest within {POSE_MAX_S:g} s: {bound}"
        return Found(False, text, numbers, data=data)
    return Found(True, f"{len(poses)} poses, tip over {swept * 1e3:.0f} mm along y", numbers, data=data)


async def decays(run: StepRun) -> Found:
    """Released to either side in turn, and watched until at rest."""
    rods, share = run.file.motion_capture.rods, run.body.share
    torques = await run.parts.planner.do(planning.release_torques, run.parameters, share, run.body.repeats)
    await run.take_rig()
    await run.still(POSE_MIN_S, POSE_MAX_S, STILL)
    rest = run.tip(STILL_WINDOW_S)
    parts, releases = list[Array](), list[Release]()
    for number, u in enumerate(torques):
        run.say(f"release {number + 1} of {len(torques)}", number / len(torques))
        part, release = await _decay(u, rest, rods, run)
        parts.append(part)
        releases.append(release)
    run.has_rig = False
    await run.give_back()
    lines = [[float(number), *row] for number, part in enumerate(parts) for row in part.tolist()]
    await _write(run.parts.folder / DECAYS, ["ID", "t", *_axes(rods)], lines)
    run.say("finds the mode that fits", 1.0)
    try:
        return judged_decays(parts, await run.parts.planner.do(planning.swing, tuple(releases), run.parameters))
    except ParameterError as error:
        return judged_decays(parts, str(error))


def judged_decays(parts: Sequence[Array], swing: MeasuredMode | str) -> Found:
    """By the decays (n, 1 + 2 m): time [s] and markers [m]; and the mode that they tell, or why they tell none."""
    short = [number for number, part in enumerate(parts) if len(part) <= SAMPLES_LEAST]
    swings = [float(np.linalg.norm(part[:, -2:] - part[-20:, -2:].mean(axis=0), axis=1).max()) for part in parts]
    bound = f"more than {SAMPLES_LEAST}"
    least = min(len(part) for part in parts)
    numbers = (
        Number(name="decays", value=len(parts), unit="1"),
        Number(name="samples of the shortest", value=least, unit="1", bound=bound, kept=not short),
        Number(name="largest swing without air", value=max(swings), unit="m"),
        *(() if isinstance(swing, str) else _mode_numbers(swing)),
    )
    curves = [np.round(part[:: max(1, len(part) // 300)][:, [0, -2, -1]], 5).tolist() for part in parts]
    data: dict[str, JsonValue] = {"curves": curves}
    if short:
        return Found(False, f"decay {short[0]} has {least} samples, {bound} are needed", numbers, data=data)
    told = f"{len(parts)} releases"
    if isinstance(swing, str):
        return Found(True, f"{told}, which tell no damping: {swing}"[:KEPT_TEXT], numbers, data=data)
    data["mode"] = swing.model_dump(mode="json")
    mode = f"{swing.frequency.value:.2f} Hz, damping ratio {swing.zeta.value:.3f}"
    return Found(True, f"{told}: {mode} ({swing.zeta.low:.3f} to {swing.zeta.high:.3f})", numbers, data=data)


def _mode_numbers(swing: MeasuredMode) -> tuple[Number, ...]:
    return (
        *(
            Number(name=name, unit=unit, **one.model_dump())
            for name, unit, one in (
                ("first mode, undamped", "Hz", swing.frequency),
                ("damping ratio", "1", swing.zeta),
            )
        ),
        Number(name="dry friction, shift of the rest", value=swing.friction, unit="m"),
        Number(name="left over by that mode", value=swing.misfit, unit="1"),
    )


async def _decay(u: Torques, rest: Array, rods: Sequence[int], run: StepRun) -> tuple[Array, Release]:
    """One release on the way to `u`: (n, 1 + 2 m), from when the chambers are empty on; and all of it from the start.

    The arm's real stiffness is not known yet, so the tip itself says how far is far enough.
    """
    seen, far = run.gather("slot", "pressure_meas", "u_hat", "p_meas"), TRAVEL * run.actuator.length

    def far_enough() -> bool:
        seen.take(run.now())
        return bool(np.linalg.norm(run.row()["p_meas"] - rest) > far)

    await run.lead((0.0, 0.0), u, far_enough)
    await run.still(POSE_MIN_S, POSE_MAX_S, STILL)
    full = float(np.abs(run.pressures(STILL_WINDOW_S)).max())
    begin, slot = run.now(), run.slot()
    await run.torque((0.0, 0.0))
    await run.still(WATCHED, DECAYS_LONGEST, STILL)
    part = await _long_enough(begin, full, rods, run)
    seen.take(run.now())
    rows = seen.rows()
    slots, pressures, sent, tip = (rows[name].copy() for name in ("slot", "pressure_meas", "u_hat", "p_meas"))
    release = Release(slots, pressures, sent, tip, slot)
    return part, release


async def _long_enough(begin: float, full: float, rods: Sequence[int], run: StepRun) -> Array:
    """The free part of what was measured since `begin` [s], once it is long enough: valves and cameras may be slow."""
    while True:
        part = free_part(run.between(begin, run.now()), full, rods)
        if len(part) > SAMPLES_LEAST or run.now() > begin + 2 * DECAYS_LONGEST:
            return part
        await asyncio.sleep(2 * POLL_S)


def free_part(rows: Rows, full: float, rods: Sequence[int]) -> Array:
    """Samples (n, 1 + 2 m) of telemetry from when no chamber has FREE of `full` [Pa] any more: time [s], markers [m].

    Raises CommandRefused where the chambers do not empty.
    """
    most = max(FREE_LEAST, FREE * full)
    free = np.flatnonzero((np.abs(rows["pressure_meas"]) < most).all(axis=1))
    if not free.size:
        raise CommandRefused(f"the chambers did not come below {most:.0f} Pa after the release")
    rows = rows[free[0] :]
    markers = rows["markers"][:, np.array(rods) - 1].reshape(len(rows), -1)
    t = (rows["t_ns"] - rows["t_ns"][0]) * 1e-9
    fresh = np.isfinite(markers).all(axis=1)
    fresh[1:] &= (markers[1:] != markers[:-1]).any(axis=1)  # a marker is held between two samples
    found, last = list[int](), -np.inf
    for row in np.flatnonzero(fresh):
        if t[row] >= last + 0.9 * SAMPLE:
            found.append(int(row))
            last = t[row]
    return np.column_stack((t, markers))[found]


def _pose(rows: Rows, rods: Sequence[int]) -> list[float]:
    """Differences of pressure [Pa] and markers [m], averaged."""
    p = rows["pressure_meas"].mean(axis=0)
    markers = still_markers(rows, tuple(rods))
    if not np.isfinite(markers).all():
        unseen = [rod for rod, marker in zip(rods, markers, strict=True) if not np.isfinite(marker).all()]
        raise CommandRefused(f"the marker of rod {unseen[0]} is not seen in this pose")
    return [float(p[0] - p[1]), float(p[2] - p[3]), *markers.ravel().tolist()]


def _axes(rods: Sequence[int]) -> list[str]:
    return [f"{axis}{number}" for number in range(1, len(rods) + 1) for axis in "xy"]


async def _write(path: Path, header: Sequence[str], lines: Sequence[Sequence[float]]) -> None:
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(header)
    table.writerows([[f"{value:.7g}" for value in line] for line in lines])
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        await asyncio.to_thread(write_whole, path, text.getvalue())
    except OSError as error:
        raise CommandRefused(f"{path} cannot be written: {error.strerror}") from error
