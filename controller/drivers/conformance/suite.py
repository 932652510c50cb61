"""All checks of a driver, one after the other, and a row for each."""

from collections.abc import Callable, Collection
from typing import Any, Literal

from controller.drivers.conformance import common, frames, impossible, valves, watchdog
from controller.drivers.conformance.bench import Bench
from controller.drivers.conformance.options import options_are_bounded
from controller.drivers.conformance.trial import Failed, NotShown, Trial
from controller.drivers.device import CaptureDevice, Device, ValveDevice
from controller.drivers.registry import checked_options, driver_class
from controller.errors import ParameterError
from controller.schema.layout import Model

Answer = Literal["shown", "not shown", "failed"]
"""What was not seen is never "shown"."""
Check = Callable[[Trial], str]
FIRST: dict[str, Check] = {
    "options have bounds": options_are_bounded,
    "touches nothing before open": common.touches_nothing_before_open,
    "opens and closes twice": common.opens_and_closes_twice,
    "keeps to its time": frames.keeps_to_its_time,
    "frames are fresh": frames.is_fresh,
    "frames are well formed": frames.is_well_formed,
}
CAPTURE: dict[str, Check] = {"shows metres": frames.shows_metres}
VALVES: dict[str, Check] = {
    "follows setpoints": valves.follows_setpoints,
    "speaks pascal": valves.speaks_pascal,
    "sends nothing impossible": impossible.sends_nothing_impossible,
    "vents when told": valves.vents_when_told,
    "vents when the host dies": watchdog.vents_when_host_dies,
}
LAST: dict[str, Check] = {
    "ends when closed": common.ends_when_closed,
    "survives a loss": common.survives_a_loss,
}


class Row(Model):
    """What came of one check."""

    check: str
    answer: Answer
    detail: str
    """What was seen; for "not shown" why not, and what would show it."""


def check_driver(
    driver: str | type[Device[Any]],
    options: dict[str, Any] | None = None,
    bench: Bench | None = None,
    drive: bool = False,
    only: Collection[str] = (),
    tell: Callable[[Row], None] = lambda row: None,
) -> list[Row]:
    """Try `driver`, by name or class, against `bench` or the device that `options` name, perhaps by way of a Recorder.

    `only` the checks of these names, if there are any; `tell` hears each row at once.

    Pressures are commanded only to a stand-in, or with `drive`: then no one may be near the actuator. Raises
    ParameterError where there is no such driver, or it does not take the options.
    """
    kind = driver_class(driver) if isinstance(driver, str) else driver
    if not issubclass(kind, CaptureDevice | ValveDevice):
        raise ParameterError(f"{kind.__name__} is no CaptureDevice and no ValveDevice")
    if bench is not None:
        bench.plug()
    trial = Trial(kind, options or {}, bench, drive)
    checked_options(kind, trial.options, "driver")
    rows = []
    for name, check in (FIRST | (VALVES if trial.valves else CAPTURE) | LAST).items():
        if only and name not in only:
            continue
        rows.append(_row(name, check, trial))
        tell(rows[-1])
    return rows


def _row(name: str, check: Check, trial: Trial) -> Row:
    try:
        return Row(check=name, answer="shown", detail=check(trial))
    except NotShown as why:
        return Row(check=name, answer="not shown", detail=str(why))
    except Failed as why:
        return Row(check=name, answer="failed", detail=str(why))
    except Exception as error:  # whatever a driver raises is a row, not our end
        return Row(check=name, answer="failed", detail=f"raised {type(error).__name__}: {error}"[:300])
