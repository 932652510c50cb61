"""The steps as data: what each is for, what the rig lacks without it, and on which others it rests."""

from typing import NamedTuple

from server.commissioning.messages import STEPS, StepName


class About(NamedTuple):
    """What is said of a step."""

    purpose: str
    lacks: str
    rests_on: tuple[StepName, ...]
    """Steps that must have been accepted before; going back behind one of them forgets this one, too."""


ABOUT: dict[StepName, About] = {
    "drivers": About(
        "Both drivers run at their rate for 2 s, and lose almost nothing.",
        "drivers not checked",
        (),
    ),
    "jog": About(
        "Fill one chamber after another at low pressure, while a button is held, and say which one fills.",
        "chambers not confirmed",
        ("drivers",),
    ),
    "frame": About(
        "Touch the base, then the tip at rest, then let u1+ bend the actuator: this is the plane's frame.",
        "frame assumed, not measured",
        ("jog",),
    ),
    "signs": About(
        "With that frame u1+ and u2+ must both move the tip to +y.",
        "signs of both pairs not checked",
        ("frame",),
    ),
    "pressure": About(
        "Steps of pressure in each chamber, from which dead time, lag and, for raw valves, the loop's gains follow.",
        "dead time and lag assumed, not measured",
        ("jog",),
    ),
    "statics": About(
        "A slow sweep over both torques in open loop, with the poses at rest.",
        "no static poses measured",
        ("signs", "pressure"),
    ),
    "decay": About(
        "Releases from bent poses, and how the actuator swings to rest.",
        "no free decays measured",
        ("signs", "pressure"),
    ),
    "identify": About(
        "Stiffness and damping of the actuator from the poses and the decays.",
        "actuator assumed, not identified",
        ("statics", "decay"),
    ),
    "closed_loop": About(
        "A small slow circle under feedback, at half the gains and at most 0.05 m/s.",
        "no closed loop tried",
        ("identify",),
    ),
}


def resting_on(step: StepName) -> set[StepName]:
    """`step` and all that rest on it, directly or not."""
    found = {step}
    for name in STEPS:  # in their order: each rests on earlier ones
        if found & set(ABOUT[name].rests_on):
            found.add(name)
    return found
