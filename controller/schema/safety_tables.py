"""The tables of docs/safety.md, made from those by which the loop acts: `python -m controller.schema.safety_tables`."""

from pathlib import Path

from controller.schema.layout import quantity
from controller.schema.modes import Mode, Request
from controller.schema.parameters import SafetyLimits
from controller.schema.states import WATCHDOGS, Watchdog, next_mode
from controller.text import markdown
from controller.text.markdown import table

PAGE = Path("docs/safety.md")
REACTIONS = {Mode.HOLD: "HOLD", Mode.REST: "REST", Mode.FAULT: "FAULT, ramp to rest", Mode.E_STOP: "E_STOP, vent"}


def filled(page: str) -> str:
    """`page` with today's tables between its marks `<!-- name -->` and `<!-- /name -->`."""
    return markdown.filled(markdown.filled(page, "transitions", transitions()), "watchdogs", watchdogs())


def transitions() -> str:
    """Mode after each request; empty where it is refused."""
    rows = [[mode.name, *(_name(next_mode(mode, request)) for request in Request if request)] for mode in Mode]
    return table(["in", *(request.name for request in Request if request)], rows)


def watchdogs() -> str:
    """What is watched, its bound and what happens."""
    rows = [
        [dog.watched, _bounds(dog), _modes(dog), REACTIONS[dog.reaction], dog.cause.name] for dog in WATCHDOGS.values()
    ]
    return table(["watched", "bound", "in", "reaction", "cause"], rows)


def _name(mode: Mode | None) -> str:
    return "" if mode is None else mode.name


def _bounds(dog: Watchdog) -> str:
    return ", ".join(f"`{name}` {_value(name)}" for name in dog.limits)


def _value(name: str) -> str:
    unit = quantity(SafetyLimits, name).unit
    return f"{SafetyLimits.model_fields[name].default:g}" + (f" {unit}" if unit != "1" else "")


def _modes(dog: Watchdog) -> str:
    missing = [mode.name for mode in Mode if mode not in dog.modes]
    return f"all but {missing[0]}" if len(missing) == 1 else ", ".join(mode.name for mode in dog.modes)


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text()))
