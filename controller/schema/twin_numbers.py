"""Numbers of the twin as a line of text, for the command line and the page: "kappa=12,torque_gain=[1.1,1.0]"."""

import tomllib

from pydantic import ValidationError

from controller.errors import ParameterError, sentence
from controller.schema.parameters import TwinParameters

NUMBERS_MAX = 1000
"""Longest such text."""


def twin_numbers(text: str, **given: object) -> TwinParameters:
    """The twin with the numbers of `text`, as a rig file's [twin] has them, and those `given`, set.

    Raises ParameterError with field, value and bound. What is not set is for `usual_twin` to say.
    """
    try:
        said = tomllib.loads(f"twin = {{{text}}}")["twin"]
        return TwinParameters.model_validate({**said, **given})
    except tomllib.TOMLDecodeError as error:
        raise ParameterError(f"twin = {text!r} is not like kappa=12,torque_gain=[1.1,1.0]: {error}") from error
    except ValidationError as error:
        raise ParameterError(f"twin: {sentence(error)}") from error
