"""Whether what a rig file may say of a device has bounds, each of them kept."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from pydantic import ValidationError

from controller.drivers.conformance.trial import Failed, NotShown, Trial, require
from controller.schema.layout import Model

LOW, HIGH = ("minimum", "exclusiveMinimum"), ("maximum", "exclusiveMaximum")
PLAIN = ("string", "boolean", "null")
"""Types that hold no number."""


class Number(NamedTuple):
    """A place for a number in an option."""

    about: dict[str, Any]
    """Its schema."""
    within: Callable[[float], Any]
    """The option with this number in it."""


def options_are_bounded(trial: Trial) -> str:
    """Each number has a least and a most, and is refused beyond; unknown options are refused."""
    kind = getattr(trial.kind, "Options", None)
    require(isinstance(kind, type) and issubclass(kind, Model), "Options is no model (controller/schema/layout.py)")
    assert isinstance(kind, type) and issubclass(kind, Model)
    valid = kind.model_validate(trial.options).model_dump()
    found: int = 0
    for name, about in kind.model_json_schema(mode="validation")["properties"].items():
        for number in _numbers(name, about):
            found += 1
            _require_bounds(kind, valid, name, number)
    _require_refused(kind, valid | {"no_such_option": 1}, "no_such_option")
    return f"{found} numbers, each with its bounds"


def _numbers(name: str, about: dict[str, Any]) -> Iterator[Number]:
    """The numbers of an option: itself, one of several types, or those of a list. NotShown for what lies deeper."""
    if "anyOf" in about:
        for one in about["anyOf"]:
            yield from _numbers(name, one)
    elif "enum" in about or "const" in about or about.get("type") in PLAIN:
        return
    elif about.get("type") in ("integer", "number"):
        yield Number(about, lambda value: value)
    elif about.get("type") == "array" and "items" in about:
        for item in _numbers(name, about["items"]):
            yield Number(item.about, _list_of(item.within, max(1, about.get("minItems", 1))))
    else:
        raise NotShown(f"options.{name} is no number, text, truth value or list of them", "a test of your own")


def _list_of(within: Callable[[float], Any], length: int) -> Callable[[float], Any]:
    return lambda value: [within(value)] * length


def _require_bounds(kind: type[Model], valid: dict[str, Any], name: str, number: Number) -> None:
    for keys in (LOW, HIGH):
        bound = next((number.about[key] for key in keys if key in number.about), None)
        require(bound is not None, f"options.{name} has no {keys[0]}")
        assert bound is not None
        _require_refused(kind, valid | {name: number.within(bound - 1 if keys is LOW else bound + 1)}, name)
    if number.about["type"] == "number":
        _require_refused(kind, valid | {name: number.within(float("nan"))}, name)


def _require_refused(kind: type[Model], options: dict[str, Any], name: str) -> None:
    try:
        kind.model_validate(options)
    except ValidationError as error:
        named = any(name in item["loc"] for item in error.errors())
        require(named, f"what is refused of options.{name} = {options[name]} does not name it")
        return
    raise Failed(f"options.{name} = {options[name]} is not refused")
