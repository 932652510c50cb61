"""The steps as data: what each is for and on which others it rests; and what the page is told of them."""

from typing import NamedTuple

from controller.schema.commissioned import RESTS_ON
from controller.schema.modes import Mode
from server.hardware.commissioning.messages import STEPS, TITLES, Change, StepName, StepView
from server.hardware.commissioning.store import KeptResult
from server.hardware.messages import RigFileState
from server.log.events import words


class About(NamedTuple):
    """What is said of a step."""

    purpose: str
    lacks: str


ABOUT: dict[StepName, About] = {
    "drivers": About(
        "Both drivers run at their rate for 2 s, and lose almost nothing.",
        "drivers not checked",
    ),
    "jog": About(
        "Fill one chamber after another at low pressure, while a button is held, and say which one fills.",
        "chambers not confirmed",
    ),
    "frame": About(
        "Touch the base, then the tip at rest, then let u1+ bend the actuator: this is the plane's frame.",
        "frame assumed, not measured",
    ),
    "signs": About(
        "With that frame u1+ and u2+ must both move the tip to +y.",
        "signs of both pairs not checked",
    ),
    "pressure": About(
        "Steps of pressure in each chamber, from which dead time, lag and, for raw valves, the loop's gains follow.",
        "dead time and lag assumed, not measured",
    ),
    "statics": About(
        "A slow sweep over both torques in open loop, with the poses at rest.",
        "no static poses measured",
    ),
    "decay": About(
        "Releases from bent poses, and how the actuator swings to rest.",
        "no free decays measured",
    ),
    "identify": About(
        "Stiffness and damping of the actuator from the poses and the decays.",
        "actuator assumed, not identified",
    ),
    "closed_loop": About(
        "A small slow circle under feedback, at half the gains and at most 0.05 m/s.",
        "no closed loop tried",
    ),
}
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
    result, told = seen.results.get(step), standing(seen.file).get(step)
    done = result.good if result else told is not None
    state = "running" if seen.running == step else "done" if done else "failed" if result else "todo"
    return StepView(
        name=step,
        title=TITLES[step],
        purpose=ABOUT[step].purpose,
        state=state,
        accepted=told is not None and (result is None or (result.text[: len(told)] == told and result.good)),
        result=result.text if result else told or "",
        numbers=result.numbers if result else [],
        writes=_writes(result),
        lacks=lacks(step, seen.file),
        withdrawn=seen.file.withdrawn.get(step, ""),
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
    done = standing(seen.file)
    found += [f"{TITLES[one]} must be accepted first" for one in RESTS_ON[step] if one not in done]
    if not seen.in_force:
        found.append("the rig does not run with what the rig file says: put it in force first")
    if seen.mode is None:
        found.append("the rig does not answer")
    elif seen.mode != Mode.VENTED and step not in STILL_STEPS:
        found.append(f"the rig is in {words(seen.mode)}, and must be vented to begin")
    return found


def lacks(step: StepName, file: RigFileState) -> str:
    """What the rig lacks until `step` is done, "" once it is and as long as it stands."""
    return "" if step in standing(file) else ABOUT[step].lacks


def lacking(file: RigFileState) -> list[str]:
    """What the rig lacks, in the order of the steps."""
    return [text for step in STEPS if (text := lacks(step, file))]


def standing(file: RigFileState) -> dict[str, str]:
    """Steps that were accepted and stand, and what came of them."""
    accepted = file.rig.commissioned if file.rig else {}
    return {step: text for step, text in accepted.items() if step not in file.withdrawn}


def _writes(result: KeptResult | None) -> list[Change]:
    if result is None:
        return []
    before = result.before
    return [Change(field=field, before=before.get(field), after=after) for field, after in result.changes.items()]


def resting_on(step: StepName) -> set[StepName]:
    """`step` and all that rest on it, directly or not."""
    found = {step}
    for name in STEPS:  # in their order: each rests on earlier ones
        if found & set(RESTS_ON[name]):
            found.add(name)
    return found
