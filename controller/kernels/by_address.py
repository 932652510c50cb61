"""What kernels know by its address alone: in Python an object that has an `address` and its numba type, `kind`."""

from typing import Any

from llvmlite import ir
from numba import extending as numba_extending

extending: Any = numba_extending

WORD = ir.IntType(64)


class _Address(extending.models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, kind: Any) -> None:
        super().__init__(manager, kind, WORD.as_pointer())


def _typeof(value: Any, context: Any) -> Any:
    return value.kind


def _unbox(kind: Any, value: Any, context: Any) -> Any:
    address = context.pyapi.object_getattr_string(value, "address")
    found = context.pyapi.long_as_ulonglong(address)
    context.pyapi.decref(address)
    return extending.NativeValue(context.builder.inttoptr(found, WORD.as_pointer()))


def known_by_address(python: type, kind: type) -> None:
    """Objects of the class `python` are pointers to words in kernels, of a type of the class `kind`."""
    extending.register_model(kind)(_Address)
    extending.typeof_impl.register(python)(_typeof)
    extending.unbox(kind)(_unbox)
