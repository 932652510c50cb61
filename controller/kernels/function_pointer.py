"""A pointer to a compiled kernel: its callers are compiled without it, and call it at its address.

numba puts the machine code of all that a kernel calls into the kernel, and optimises it there again. Loop and
simulations call the same tick with each kind of plant: in all of them it took two fifths of the time of compiling.
"""

from typing import Any

from controller.kernels.group import known_by_address
from controller.numba_internals import TypingError, cgutils, extending, typeof, types


class FunctionPointer:
    """A kernel for arguments of the types of `given`, compiled or loaded when this is made."""

    def __init__(self, kernel: Any, *given: Any) -> None:
        """`kernel` is one that returns nothing. Keep this as long as it may be called."""
        arguments = tuple(typeof(one) for one in given)
        kernel.compile(arguments)
        found = kernel.overloads[arguments]
        self.address = int(found.library.get_pointer_to_function(found.fndesc.llvm_func_name))
        self.kind = FunctionPointerType(arguments)
        """numba asks for it at every call of a caller, and its name is long: it is made once."""


class FunctionPointerType(types.Type):  # type: ignore[misc]
    """Type of a `FunctionPointer` in kernels; who calls it with other types than its own is not compiled."""

    def __init__(self, arguments: tuple[types.Type, ...]) -> None:
        self.arguments = arguments
        super().__init__(f"FunctionPointer{arguments}")


def _call(typing: Any, kernel: Any, given: Any) -> Any:
    if tuple(given) != kernel.arguments:
        raise TypingError(f"{given} are not the types for which this kernel was compiled: {kernel.arguments}")

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        address, arguments = values
        return _run(context, builder, kernel.arguments, address, arguments)

    return types.none(kernel, given), emit


def _call_at(typing: Any, address: Any, given: Any) -> Any:
    """As `_call`, of an address: that it is of a kernel for arguments of these types is not checked."""

    def emit(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        number, arguments = values
        function = builder.inttoptr(number, cgutils.voidptr_t)
        return _run(context, builder, tuple(given), function, arguments)

    return types.none(types.int64, given), emit


def _run(context: Any, builder: Any, kinds: tuple[Any, ...], address: Any, arguments: Any) -> Any:
    layout = context.call_conv.get_function_type(types.none, kinds)
    function = builder.bitcast(address, layout.as_pointer())
    unpacked = cgutils.unpack_tuple(builder, arguments)
    status, _ = context.call_conv.call_function(builder, function, types.none, kinds, unpacked)
    with cgutils.if_unlikely(builder, status.is_error):
        context.call_conv.return_status_propagate(builder, status)
    return context.get_dummy_value()


known_by_address(FunctionPointer, FunctionPointerType)
call = extending.intrinsic(_call)
"""call(kernel, (a, b, ...)), in a compiled function: runs the FunctionPointer `kernel` with these arguments."""
call_at = extending.intrinsic(_call_at)
"""call_at(address, (a, b, ...)): runs the kernel that was compiled for arguments of these types at this address."""
