"""How the real-time code is compiled: one typed decorator, and the atomic loads and stores that numba lacks."""

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

from controller.kernels.compiled import for_any_number
from controller.numba_internals import arrayobj, cgutils, extending, types
from controller.system.kernel_cache import use

use()

intrinsic: Any = extending.intrinsic
F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """`function` in machine code, without the GIL, cached on disk; a division by zero gives nan and never raises."""
    return cast(F, for_any_number(njit(cache=True, nogil=True, error_model="numpy")(function)))


def _element(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
    """Pointer to element `arguments[1]` of the array `arguments[0]`."""
    kind = signature.args[0]
    array = arrayobj.make_array(kind)(context, builder, arguments[0])
    return cgutils.get_item_pointer(context, builder, kind, array, [arguments[1]], wraparound=False)


def _load_acquire(typing: Any, array: Any, index: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.load_atomic(_element(context, builder, signature, arguments), "acquire", 8)

    return types.int64(array, types.intp), emit


def _store_release(typing: Any, array: Any, index: Any, value: Any) -> Any:
    def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        builder.store_atomic(arguments[2], _element(context, builder, signature, arguments), "release", 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.int64), emit


def _fence(order: str) -> Any:
    def fence(typing: Any) -> Any:
        def emit(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            builder.fence(order)
            return context.get_dummy_value()

        return types.void(), emit

    return intrinsic(fence)


load_acquire = intrinsic(_load_acquire)
"""load_acquire(words int64[:], index): later loads are not moved before this one."""
store_release = intrinsic(_store_release)
"""store_release(words int64[:], index, value): earlier stores are not moved behind this one."""
fence_acquire = _fence("acquire")
fence_release = _fence("release")
