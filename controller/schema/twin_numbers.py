"""Numbers of the twin as a line of text, for the command line and the page: "kappa=12,torque_gain=[1.1,1.0]"."""

import tomllib
from typing import Any

from pydantic import ValidationError

from controller.errors import ParameterError, sentence
from controller.schema.parameters import TwinParameters

NUMBERS_MAX = 1000
"""Longest such text."""


def twin_numbers(text: str, **given: object) -> TwinParameters:
    """The twin with the numbers of `text`, as a rig file's [twin] has them, and those `given`, set.

    Raises ParameterError with field, value and bound. What is not set is for `usual_twin` to say.
    """
    said = inline("twin", text, "kappa=12,torque_gain=[1.1,1.0]")
    try:
        return TwinParameters.model_validate({**said, **given})
    except ValidationError as error:
        raise ParameterError(f"twin: {sentence(error)}") from error


def inline(name: str, text: str, like: str) -> dict[str, Any]:
    """What a line like `like` says. Raises ParameterError, which calls it `name`, for any other."""
    try:
        found: dict[str, Any] = tomllib.loads(f"it = {{{text}}}")["it"]
    except tomllib.TOMLDecodeError as error:
        raise ParameterError(f"{name} = {text!r} is not like {like}: {error}") from error
    return found
