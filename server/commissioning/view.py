"""What the page is told of each step."""

from typing import NamedTuple

from controller.schema.modes import Mode
from controller.schema.rig_file import RigFile
from server.commissioning.messages import STEPS, TITLES, Change, StepName, StepView
from server.commissioning.steps import ABOUT
from server.commissioning.store import KeptResult
from server.hardware.messages import RigFileState
from server.log.events import words

STILL_STEPS = ("identify",)
"""What needs no rig at hand."""


class Seen(NamedTuple):
    """From what a step's view is made."""

    file: RigFileState
    results: dict[StepName, KeptResult]
    running: StepName | None
    mode: Mode | None
    """Of the rig; None while it does not answer."""
    in_force: bool
    """The rig runs with what the rig file says, or is a twin."""


def step_view(step: StepName, seen: Seen) -> StepView:
    """One step as the page shows it."""
    result, told = seen.results.get(step), commissioned(seen.file.rig).get(step)
    done = result.good if result else told is not None
    state = "running" if seen.running == step else "done" if done else "failed" if result else "todo"
    return StepView(
        name=step,
        title=TITLES[step],
        purpose=ABOUT[step].purpose,
        state=state,
        accepted=told is not None and (result is None or result.text[: len(told)] == told and result.good),
        result=result.text if result else told or "",
        numbers=result.numbers if result else [],
        writes=_writes(result),
        lacks=lacks(step, seen.file.rig),
        needs=needs(step, seen),
        by=result.by if result else "",
        at=result.at if result else None,
    )


def needs(step: StepName, seen: Seen) -> list[str]:
    """What is missing to begin `step`."""
    if seen.file.rig is None or seen.file.reason:
        return [seen.file.reason]
    found = []
    if seen.running is not None:
        found.append(f"{TITLES[seen.running]} is under way: stop it first")
    done = commissioned(seen.file.rig)
    found += [f"{TITLES[one]} must be accepted first" for one in ABOUT[step].rests_on if one not in done]
    if not seen.in_force:
        found.append("the rig does not run with what the rig file says: put it in force first")
    if seen.mode is None:
        found.append("the rig does not answer")
    elif seen.mode != Mode.VENTED and step not in STILL_STEPS:
        found.append(f"the rig is in {words(seen.mode)}, and must be vented to begin")
    return found


def lacks(step: StepName, rig: RigFile | None) -> str:
    """What the rig lacks until `step` is done, "" once it is."""
    if rig is None:
        return ABOUT[step].lacks
    flags = {"frame": rig.motion_capture.frame.measured, "pressure": rig.valves.measured}
    return "" if step in rig.commissioned and flags.get(step, True) else ABOUT[step].lacks


def lacking(rig: RigFile | None) -> list[str]:
    """What the rig lacks, in the order of the steps."""
    return [text for step in STEPS if (text := lacks(step, rig))]


def commissioned(rig: RigFile | None) -> dict[str, str]:
    """Steps that were accepted, and what came of them."""
    return rig.commissioned if rig else {}


def _writes(result: KeptResult | None) -> list[Change]:
    if result is None:
        return []
    return [Change(field=field, before=result.before.get(field), after=after) for field, after in result.changes.items()]
