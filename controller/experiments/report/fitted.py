"""What the report says from the fit's own file: who fitted what, and how far near-equal fits lie apart."""

from collections.abc import Mapping
from typing import Any

from controller.experiments.report.wording import number

Key = tuple[str, str, str, str]


def spread_of(fit: Mapping[str, Any]) -> dict[Key, str]:
    """Lowest and highest held-out predictions over the near-equal fits, by row; empty before there are any."""
    return {_key(one): f"{number(one['low'])} .. {number(one['high'])}" for one in fit.get("spread", ())}


def fits(fit: Mapping[str, Any]) -> int:
    """Number of near-equal fits behind the spread."""
    return max((int(one["fits"]) for one in fit.get("spread", ())), default=0)


def provenance(fit: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Facts of the fit: date, command, cost, what was fitted."""
    about = fit["fit"]
    return [
        ("date of the fit", str(about["date"])),
        ("command of the fit", str(about["command"])),
        ("cost of the fit", number(about["cost"])),
        ("fitted numbers of the twin", ", ".join(fit["twin"])),
        ("fitted gains", ", ".join(fit["gains"])),
    ]


def _key(one: Mapping[str, Any]) -> Key:
    return one["experiment"], one["actuator"], one["law"], one["metric"]
