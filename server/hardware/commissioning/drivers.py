"""The drivers step: whether motion capture and valves run at their rate, and how old and how complete what comes is."""

import asyncio
from collections.abc import Sequence

from controller.errors import CommandRefused
from controller.schema.hardware import Drivers, DriverStatus
from server.hardware.commissioning.messages import Number
from server.hardware.commissioning.step_run import StepRun
from server.hardware.commissioning.store import Found

WATCHED_S, SAMPLE_S = 2.0, 0.2
"""For how long they are looked at, and how often [s]."""
LOSS_MAX = 0.01
"""Share of frames that may be lost or rejected."""
RATE_MIN = {"motion_capture": 40.0, "valves": 20.0}
"""Least usable frames a second, the rig vented: twice as many as it takes so that nothing counts as old or lost."""
LATENCY_MAX = 0.05
"""Of a frame from capture to arrival [s]: as old as the feedback takes it."""


async def do(run: StepRun) -> Found:
    """Look at both for a while. Raises CommandRefused where the rig has no drivers."""
    looks: list[Drivers] = []
    steps = int(WATCHED_S / SAMPLE_S)
    for step in range(steps + 1):
        run.say("watches both drivers", step / steps)
        looks.append(await asyncio.to_thread(run.parts.drivers))
        if not looks[-1].drivers:
            raise CommandRefused("the rig has no drivers: its plant is simulated")
        await asyncio.sleep(SAMPLE_S)
    return judged(looks)


def judged(looks: Sequence[Drivers]) -> Found:
    """What the drivers' states, one look after another, come to."""
    faults, numbers, words = [], list[Number](), []
    for last in looks[-1].drivers:
        seen = [one for look in looks for one in look.drivers if one.role == last.role]
        role = last.role.replace("_", " ")
        if bad := next((one for one in seen if one.state != "running" or one.detail), None):
            faults.append(f"{role} ({last.driver}) is {bad.state}{': ' if bad.detail else ''}{bad.detail}")
        found = _numbers(role, last.role, seen)
        numbers += found
        faults += [f"{one.name} is {one.value:.4g} {one.unit}: {one.bound}" for one in found if not one.kept]
        words.append(f"{role} {last.driver} {last.rate:.0f}/s, clock {last.clock}")
    if {one.role for one in looks[-1].drivers} != set(RATE_MIN):
        faults.append("the rig has not one driver of motion capture and one of valves")
    return Found(not faults, "; ".join(faults or words), tuple(numbers))


def _numbers(role: str, kind: str, seen: Sequence[DriverStatus]) -> list[Number]:
    first, last = seen[0], seen[-1]
    came = last.frames - first.frames
    gone = last.lost - first.lost
    bad = last.rejected - first.rejected if kind == "valves" else 0  # a camera's strangers are no loss
    loss = (gone + bad) / max(1, came + gone + bad)
    rate, least = min(one.rate for one in seen), RATE_MIN[kind]
    numbers = [
        Number(name=f"{role}, rate", value=rate, unit="1/s", bound=f"at least {least:g} 1/s", kept=rate >= least),
        Number(name=f"{role}, loss", value=loss, unit="1", bound=f"at most {LOSS_MAX:g}", kept=loss <= LOSS_MAX),
        Number(name=f"{role}, clock offset", value=last.clock_offset, unit="s"),
    ]
    known, late = last.latency >= 0.0, last.latency
    bound = f"at most {LATENCY_MAX:g} s" if known else ""
    kept = not known or late <= LATENCY_MAX
    return [*numbers, Number(name=f"{role}, latency", value=late if known else None, unit="s", bound=bound, kept=kept)]
