"""How a kernel is compiled: nogil machine code that cannot allocate; a division by zero gives nan and never raises.

Without numba's runtime (`_nrt`) a kernel that would make an array does not compile, and the arrays that kernels pass to
one another are not counted, which took two fifths of a tick: the caller's references keep them alive. "contract" lets
the compiler fuse a product and a sum, and nothing else: sums keep their order.
"""

from collections.abc import Callable
from typing import Any, TypeVar

from numba import njit

from controller.numba_internals import unliteral
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


def kernel(function: F) -> F:
    """Decorator of a kernel."""
    return for_any_number(njit(**OPTIONS)(function))


def inlined(function: F) -> F:
    """Decorator of a kernel that is part of its caller: what it is given stays in registers."""
    return for_any_number(njit(forceinline=True, **OPTIONS)(function))


def for_any_number(function: Any) -> Any:
    """The same compiled function, but one for all whole numbers that callers name: numba compiles one for each."""
    of_numba = function.get_call_template

    def get_call_template(arguments: Any, keywords: Any) -> Any:
        return of_numba([unliteral(one) for one in arguments], {name: unliteral(keywords[name]) for name in keywords})

    function.get_call_template = get_call_template
    return function


TINY = 1e-60
"""Motion that dies out must not end in denormal numbers: they take the processor a hundred times as long."""


@inlined
def flushed(x: float) -> float:
    """x rounded to a multiple of 1e-76; no branch, so a loop over it uses the vector unit. Not in the paper: speed."""
    return (x + TINY) - TINY
