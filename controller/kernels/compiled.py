"""How a kernel is compiled: nogil machine code that cannot allocate; a division by zero gives nan and never raises.

Without numba's runtime (`_nrt`) a kernel that would make an array does not compile, and the arrays that kernels pass to
one another are not counted, which took two fifths of a tick: the caller's references keep them alive. "contract" lets
the compiler fuse a product and a sum, and nothing else: sums keep their order.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

from controller.system.kernel_cache import use

use()

OPTIONS: dict[str, Any] = {
    "cache": True,
    "nogil": True,
    "error_model": "numpy",
    "fastmath": {"contract"},
    "_nrt": False,
}

F = TypeVar("F", bound=Callable[..., Any])

kernel: Callable[[F], F] = njit(**OPTIONS)
"""Decorator of a kernel."""
inlined: Callable[[F], F] = njit(forceinline=True, **OPTIONS)
"""Decorator of a kernel that is part of its caller: what it is given stays in registers."""
