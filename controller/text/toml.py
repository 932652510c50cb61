"""TOML that users write, read as a model: whatever is wrong in it is said in a sentence, and soon."""

import re
import tomllib
from typing import TypeVar

from pydantic import BaseModel, ValidationError

from controller.errors import ParameterError, sentence

PARTS_MAX = 10
"""Parts of a TOML key: tomllib takes hours for one of 100 000."""
_DEEP = re.compile(r"""(?:\.[ \t]*(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*){10}""", re.ASCII)

M = TypeVar("M", bound=BaseModel)


def model_in(text: str, source: str, model: type[M]) -> M:
    """The `model` that the TOML `text` describes; ParameterError names `source`, field, value and bound."""
    if (found := _DEEP.search(text)) is not None:
        raise ParameterError(f"{source}: a key has more than {PARTS_MAX} parts: {found[0][:40]}...")
    try:
        return model.model_validate(tomllib.loads(text))
    except ValidationError as error:
        raise ParameterError(f"{source}: {sentence(error)}") from error
    except RecursionError as error:
        raise ParameterError(f"{source} is no TOML of this kind: it is nested too deeply") from error
    except ValueError as error:  # tomllib lets pass what int() refuses
        raise ParameterError(f"{source} is not TOML: {error}") from error
