"""The actuator from poses and decays: `tendril identify` in a process of its own, and what it found."""

import asyncio
import hashlib
import os
import re
import sys
from contextlib import suppress
from datetime import datetime
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from controller.errors import CommandRefused
from controller.schema.actuator import Actuator, Tracking, parse_actuator, write_actuator
from controller.schema.parameters import KAPPA, OBSERVER_KAPPA
from controller.system.work_process import NICE
from server.hardware.commissioning import planning
from server.hardware.commissioning.messages import Number
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found, KeptResult
from server.hardware.commissioning.sweep import DECAYS, POSES
from server.hardware.first_mode.messages import Interval, KeptMode, MeasuredMode, Plant

IDENTIFY_MAX_S = 300.0
"""Longest time that it may take [s]."""
KEPT_LINES = 80
"""Of what it says, for the report."""
RESIDUAL = r"^ *(residual, .+?) {2,}(\S+) +rms of \d+ +(\S+) *$"
"""A line of its table."""
ZETA = r"^ *zeta +\S+ +(\S+) \.\. (\S+) "
"""The line of the damping ratio that it found, with its interval."""
CHANGED_MOST = 20.0
"""An actuator this many times stiffer or softer than was believed is another one, or was measured wrongly."""


async def identify(run: StepRun) -> Found:
    """Run it on the poses, with the damping ratio that the decays told; where they told none, on their table.

    Raises CommandRefused where a table is missing, or it says what is wrong.
    """
    run.has_rig = False
    folder, name = run.parts.folder, f"{run.file.name}-identified.toml"
    poses, decays = folder / POSES, folder / DECAYS
    if missing := [path.name for path in (poses, decays) if not path.exists()]:
        raise CommandRefused(f"{missing[0]} is missing: measure it again")
    out, base = folder / name, folder / "base.toml"
    believed = await asyncio.to_thread(unbounded, run)
    await asyncio.to_thread(write_actuator, as_base(believed, run.file.motion_capture.rods), base)
    run.say("runs tendril identify")
    mode = mode_in(run.parts.store.kept.results.get("decay"))
    damping = [str(decays)] if mode is None else ["--zeta", f"{mode.zeta.value:.4g}"]
    asked, note = ["--actuator", str(base), "--out", str(out)], ""
    try:
        said = await _run(["identify", str(poses), *damping, *asked], folder)
        _require_told(said)
    except CommandRefused as error:
        if DECAYS not in str(error):
            raise
        note = str(error)  # a body that hardly swings tells its stiffness all the same
        run.say("runs tendril identify with the poses alone", 0.5)
        said = await _run(["identify", str(poses), *asked], folder)
    try:
        text = await asyncio.to_thread(out.read_text)
        found = parse_actuator(text, name)
    except OSError as error:
        raise CommandRefused(f"{name} was not written: {error.strerror}") from error
    result = judged(found, run.actuator, file_name(run.file.name, text), text, said, note)
    if mode is None:
        return result
    rig = run.parameters.with_actuator(found)
    return with_mode(result, mode, await run.parts.planner.do(planning.kappa_of, mode.frequency.value, rig))


def file_name(rig: str, text: str) -> str:
    """Of the actuator that `text` describes, beside the file of `rig`.

    By its content: the file that the rig runs with stays as it is until the rig file names another one, so that what is
    in force and what is asked for can be compared, and a refusal leaves all as it was.
    """
    return f"{rig}-identified-{hashlib.sha256(text.encode()).hexdigest()[:8]}.toml"


def mode_in(result: KeptResult | None) -> MeasuredMode | None:
    """The first mode that a step's result has; None where it told none."""
    try:
        return MeasuredMode.model_validate(result.data["mode"]) if result and "mode" in result.data else None
    except ValidationError:
        return None


def with_mode(result: Found, mode: MeasuredMode, kappa: float) -> Found:
    """`result` with the damping ratio that its actuator has now, and kappa, by which the observer's inertia goes."""
    frequency = mode.frequency
    spread = {name: kappa * (f / frequency.value) ** 2 for name, f in frequency.model_dump().items()}
    mode = mode.model_copy(update={"kappa": Interval(**spread)})
    numbers = [
        Number(name=name, unit="1", **one.model_dump())
        for name, one in (("damping ratio", mode.zeta), ("kappa", mode.kappa))
    ]
    text = f"{result.text}, damping ratio {mode.zeta.value:.3f}, kappa {kappa:.0f}" if result.good else result.text
    data = {**result.data, "mode": mode.model_dump(mode="json")}
    swings = {
        "controller.observer_kappa": within(kappa, OBSERVER_KAPPA),
        "twin.kappa": within(kappa, KAPPA),
        "twin.zeta": round(mode.zeta.value, 4),
    }
    changes = {**result.changes, **swings} if result.good else result.changes
    return result._replace(text=text, numbers=(*result.numbers, *numbers), changes=changes, data=data)


def within(kappa: float, bounds: tuple[float, float]) -> float:
    """As a rig file may have it: within a tenth, which is less than its interval, and within the bounds."""
    return round(min(max(kappa, bounds[0]), bounds[1]), 1)


def kept_mode(result: KeptResult, measured: datetime, plant: Plant) -> KeptMode | None:
    """The first mode of the actuator that `result` of this step has; None where the decays told none."""
    mode, name, text = mode_in(result), result.data.get("file"), result.data.get("text")
    if mode is None or not isinstance(name, str) or not isinstance(text, str):
        return None
    return KeptMode(actuator=parse_actuator(text, name), plant=plant, measured=measured, mode=mode)


def unbounded(run: StepRun) -> Actuator:
    """The actuator that the rig believes in, with its own u_max: how far the valves may go is nothing of the body."""
    named = run.file.found_actuator(run.folder)
    return named if run.parameters.with_actuator(named).actuator == run.actuator else run.actuator


def as_base(actuator: Actuator, rods: tuple[int, ...]) -> Actuator:
    """`actuator` with the places of the tracked rods, as the measured tables have them: in its own frame."""
    arcs = tuple(actuator.length * rod / 10 for rod in rods)
    return actuator.model_copy(update={"tracking": Tracking(base=(0.0, 0.0), axis=(1.0, 0.0), arcs=arcs)})


def judged(found: Actuator, before: Actuator, name: str, text: str, said: str, note: str = "") -> Found:
    """By the actuator that was `found`, in the file `name` with `text`, where `before` was believed in.

    `note` says why the decays were left out, "" where they were not.
    """
    soft, softer = stiffness(before), stiffness(found)
    ratio = softer / soft if soft > 0.0 else 0.0
    kept = 1.0 / CHANGED_MOST <= ratio <= CHANGED_MOST
    bound = f"{1.0 / CHANGED_MOST:g} to {CHANGED_MOST:g}"
    residuals = residuals_in(said)
    numbers = (
        Number(name="stiffness, mean of the joints", value=softer, unit="N m/rad"),
        Number(name="as it was believed", value=soft, unit="N m/rad"),
        Number(name="ratio", value=ratio, unit="1", bound=bound, kept=kept),
        Number(name="alpha", value=found.alpha, unit="1/s"),
        Number(name="alpha, as it was believed", value=before.alpha, unit="1/s"),
        *residuals,
    )
    lines = said.splitlines()[:KEPT_LINES]
    data = {"file": name, "text": text, "said": "\n".join([*lines, note]), "note": note}
    left = "; damping stays as it was believed: the decays do not tell it" if note else ""
    told = f"stiffness {ratio:.2f} of what was believed, residual {_worst(residuals)}{left}"
    if not kept:
        return Found(False, f"stiffness is {ratio:.3g} of what was believed: {bound}", numbers, data=dict(data))
    return Found(True, told, numbers, {"actuator": name}, dict(data))


def residuals_in(said: str) -> list[Number]:
    """What `tendril identify` says that is left over, rms."""
    return [
        Number(name=name, value=float(value), unit=unit)
        for name, value, unit in re.findall(RESIDUAL, said, re.MULTILINE)
    ]


def _require_told(said: str) -> None:
    """CommandRefused where the decays leave it open whether there is any damping."""
    found = re.search(ZETA, said, re.MULTILINE)
    if found is not None and float(found[1]) <= 0.0:
        raise CommandRefused(f"{DECAYS}: the damping ratio may be anything from {found[1]} to {found[2]}")


def _worst(residuals: list[Number]) -> str:
    whole = next((one for one in residuals if "all" in one.name), residuals[0] if residuals else None)
    return f"{whole.value:.3g} {whole.unit}" if whole is not None and whole.value is not None else "not told"


def stiffness(actuator: Actuator) -> float:
    """Mean stiffness of the joints, of a base by EI that of ten [N m/rad]."""
    EI = getattr(actuator, "EI", None)
    if EI is not None:
        return float(np.mean(EI)) / (actuator.length / 10)
    return float(np.mean(actuator.k))


async def _run(arguments: list[str], folder: Path) -> str:
    """What the child process says; CommandRefused with its last line where it ends otherwise than well."""
    environment = {**os.environ, "COLUMNS": "160", "NO_COLOR": "1"}
    child = await asyncio.create_subprocess_exec(
        sys.executable,
        "-m",
        "server",
        *arguments,
        cwd=folder,
        env=environment,
        stdin=asyncio.subprocess.DEVNULL,
        stdout=asyncio.subprocess.PIPE,
        stderr=asyncio.subprocess.STDOUT,
        start_new_session=True,
        preexec_fn=lambda: os.nice(NICE) and None,
    )
    try:
        said, _ = await asyncio.wait_for(child.communicate(), IDENTIFY_MAX_S)
    except TimeoutError as error:
        raise CommandRefused(f"tendril identify took more than {IDENTIFY_MAX_S:g} s; it was ended") from error
    finally:
        if child.returncode is None:
            with suppress(ProcessLookupError):
                child.kill()
            await child.wait()
    text = said.decode(errors="replace")
    if child.returncode != 0:
        lines = [line.strip(" │") for line in text.splitlines() if line.strip(" │╭╮╰╯─")]
        raise CommandRefused(f"tendril identify: {lines[-1] if lines else f'ended with {child.returncode}'}"[:400])
    return text
