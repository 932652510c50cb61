"""The actuator from poses and decays: `tendril identify` in a process of its own, and what it found."""

import asyncio
import os
import re
import sys
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from controller.errors import CommandRefused
from controller.schema.actuator import Actuator, Tracking, parse_actuator, write_actuator
from server.commissioning.messages import Number, StepName
from server.commissioning.motion import Run, Through
from server.commissioning.store import Found, KeptResult
from server.commissioning.sweep import DECAYS, POSES

PATIENCE = 300.0
"""Longest time that it may take [s]."""
NICE = 10
KEPT_LINES = 80
"""Of what it says, for the report."""
RESIDUAL = r"^ *(residual, .+?) {2,}(\S+) +rms of \d+ +(\S+) *$"
"""A line of its table."""
CHANGED_MOST = 20.0
"""An actuator this many times stiffer or softer than was believed is another one, or was measured wrongly."""


async def identify(run: Run, through: Through, results: Mapping[StepName, KeptResult]) -> Found:
    """Run it on the tables of both steps. Raises CommandRefused where they are missing, or it says what is wrong."""
    run.moves = False
    folder, name = through.folder, f"{run.file.name}-identified.toml"
    tables = [folder / POSES, folder / DECAYS]
    if missing := [path.name for path in tables if not path.exists()]:
        raise CommandRefused(f"{missing[0]} is missing: measure it anew")
    out, base = folder / name, folder / "base.toml"
    await asyncio.to_thread(write_actuator, as_base(run.actuator, run.file.motion_capture.rods), base)
    run.say("runs tendril identify")
    asked, note = ["--actuator", str(base), "--out", str(out)], ""
    try:
        said = await _run(["identify", *map(str, tables), *asked], folder)
    except CommandRefused as error:
        if DECAYS not in str(error):
            raise
        note = str(error)  # a body that hardly swings tells its stiffness all the same
        run.say("runs tendril identify with the poses alone", 0.5)
        said = await _run(["identify", str(tables[0]), *asked], folder)
    try:
        text = await asyncio.to_thread(out.read_text)
        found = parse_actuator(text, name)
    except OSError as error:
        raise CommandRefused(f"{name} was not written: {error.strerror}") from error
    return judged(found, run.actuator, name, text, said, note)


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
        said, _ = await asyncio.wait_for(child.communicate(), PATIENCE)
    except TimeoutError as error:
        raise CommandRefused(f"tendril identify took more than {PATIENCE:g} s; it was ended") from error
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
