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
        layout = context.call_conv.get_function_type(types.none, kernel.arguments)
        function = builder.bitcast(address, layout.as_pointer())
        unpacked = cgutils.unpack_tuple(builder, arguments)
        status, _ = context.call_conv.call_function(builder, function, types.none, kernel.arguments, unpacked)
        with cgutils.if_unlikely(builder, status.is_error):
            context.call_conv.return_status_propagate(builder, status)
        return context.get_dummy_value()

    return types.none(kernel, given), emit


known_by_address(FunctionPointer, FunctionPointerType)
call = extending.intrinsic(_call)
"""call(kernel, (a, b, ...)), in a compiled function: runs the FunctionPointer `kernel` with these arguments."""
