"""JSON texts of many rows at once, by Arrow's functions for arrays of strings."""

from typing import Any, NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from controller.arrays import Values

Texts = Any
"""An Arrow array of n strings (pyarrow has no types)."""


class Messages(NamedTuple):
    """Messages of one topic: their times (n,) [Unix ns], their JSON."""

    at: Values
    texts: Texts


def digits(values: Values) -> Texts:
    """Numbers (n,) as text that reads back exactly, float32 with the digits of the same float64; null if not finite."""
    if values.dtype.kind != "f":
        return pa.array(values).cast(pa.string())
    known = np.isfinite(values)
    return pa.array(values.astype(np.float64, copy=False), mask=None if known.all() else ~known).cast(pa.string())


def joined(*parts: str | Texts) -> Texts:
    """Each row's parts one after another, a string being the same in every row; null where one of them is."""
    return pc.binary_join_element_wise(*parts, "")
