"""The kinds of arrays that signatures name. Shape and unit stand where an array is made."""

from collections.abc import Mapping
from typing import Any

import numpy as np

Array = np.ndarray[Any, np.dtype[np.float64]]
"""Real numbers."""
Pair = tuple[float, float]
"""Two components by value: of a point or a velocity (x, y), or of torques (u1, u2)."""
Array32 = np.ndarray[Any, np.dtype[np.float32]]
"""Real numbers in single precision: what is drawn, sent or kept in bulk."""
Words = np.ndarray[Any, np.dtype[np.int64]]
"""8-byte integers: counters, times [ns], indices, bits."""
Mask = np.ndarray[Any, np.dtype[np.bool_]]
"""What is chosen of an array of the same shape."""
Seed = np.ndarray[Any, np.dtype[np.uint64]]
"""State of a random generator, of one number."""
Rows = np.ndarray[Any, np.dtype[np.void]]
"""Records of one layout (controller/schema/layout.py)."""
Record = Any
"""One of `Rows` inside a kernel, where its fields are attributes; numpy's own types know of none."""
Values = np.ndarray[Any, Any]
"""Of one signal, in the type that it has."""
Columns = Mapping[str, Values]
"""Values by the name of their field, equally many of each."""
