"""What the report says from the fit's own file: who fitted what, and how many near-equal fits there are."""

from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from controller.research.report.wording import number
from controller.text.document import NOTHING, table


def fits(fit: Mapping[str, Any]) -> int:
    """Number of near-equal fits behind the spread."""
    return int(fit["fit"]["fits"]) if fit.get("spread") else 0


def provenance(fit: Mapping[str, Any]) -> list[tuple[str, str]]:
    """What the file says of the fit (date, command, cost and so on), and what was fitted."""
    about = [(f"fit: {name}", _text(value)) for name, value in fit["fit"].items()]
    own = [name for name in fit["twin"] if name not in ("plant", "cosserat")]
    twin = ", ".join((*own, *(f"cosserat.{name}" for name in sorted(fields_of(fit)))))
    return [*about, ("fitted numbers of the twin", twin), ("fitted gains", ", ".join(fit["gains"]))]


def fields_of(fit: Mapping[str, Any]) -> set[str]:
    """Fitted fields of the Cosserat plant's own."""
    names = (name.split(".") for name in fit.get("ensemble", {}).get("names", ()))
    return {name[1] for name in names if name[0] == "cosserat"}


def margins_table(fit: Mapping[str, Any]) -> Markup:
    """What each trial of the loop's stability left; nothing before there are any."""
    margins = fit.get("margins", ())
    if not margins:
        return NOTHING
    head = [name.replace("_mm", " [mm]") for name in margins[0]]
    rows = [[_text(value) for value in one.values()] for one in margins]
    return Markup("<p>Trials of the loop's stability with these numbers:</p>{}").format(table(head, rows, ()))


def _text(value: Any) -> str:
    return number(value) if isinstance(value, float) else str(value)
