"""A group of arrays and numbers that kernels are handed by its address.

numba hands a named tuple on by value: a kernel that took the observer so had some 500 arguments. They cost each of its
callers a copy, which was half of a tick, and the compiler most of its time. A group is one argument, of which a kernel
loads what it needs.
"""

import hashlib
from functools import cached_property
from typing import Any, ClassVar, Self, dataclass_transform

import numpy as np

from controller.numba_internals import cgutils, extending, ir, lower_getattr_generic, templates, typeof, types

Tuple: Any = types.BaseTuple
WORD = ir.IntType(64)
"""What kernels know by its address alone has in Python an `address` and its numba type, `kind`."""


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


@dataclass_transform(frozen_default=True)
class Group:
    """Base of groups: a subclass lists its fields, like a named tuple. They stay; what is in their arrays may change.

    A field is an array, a float, an int, a bool, a group, or a tuple of such; all that these are made of are words.
    """

    names: ClassVar[tuple[str, ...]]

    def __init_subclass__(cls) -> None:
        cls.names = tuple(cls.__annotations__)

    def __init__(self, *values: Any, **named: Any) -> None:
        given = dict(zip(self.names, values, strict=False)) | named
        if len(values) + len(named) != len(self.names) or given.keys() != set(self.names):
            raise TypeError(f"{type(self).__name__} takes {', '.join(self.names)}")
        words = np.array([word for name in self.names for word in _words_of(given[name])], np.int64)
        vars(self).update(given, _words=words, address=_address_of(words))

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"{type(self).__name__} keeps its fields: {name} cannot be set")

    def __reduce__(self) -> tuple[Any, ...]:
        """So that a copy lists its own fields, and a pickled one those of its process."""
        return type(self), tuple(getattr(self, name) for name in self.names)

    def _replace(self, **changed: Any) -> Self:
        """The same with some other fields, as of a named tuple."""
        return type(self)(**({name: getattr(self, name) for name in self.names} | changed))

    @cached_property
    def kind(self) -> "GroupType":
        """numba's type of it."""
        form = type(self), *(_form_of(getattr(self, name)) for name in self.names)
        if form not in _KINDS:
            _KINDS[form] = GroupType(type(self).__name__, {name: typeof(getattr(self, name)) for name in self.names})
        return _KINDS[form]


_KINDS: dict[tuple[Any, ...], "GroupType"] = {}
"""Of each form: numba takes long to name it, as often as a simulation is made."""


def _form_of(value: Any) -> Any:
    """What numba's type of a field depends on."""
    if isinstance(value, Group):
        return value.kind
    if isinstance(value, np.ndarray):
        flags = value.flags
        return value.dtype, value.ndim, flags.c_contiguous, flags.f_contiguous, flags.aligned, flags.writeable
    return typeof(value)


def _words_of(value: Any) -> list[int]:
    """A field as it lies in a group; of an array what numba keeps of one, with no owner: the group keeps it alive."""
    if isinstance(value, np.ndarray):
        return [value.size, value.itemsize, _address_of(value), *value.shape, *value.strides]
    if isinstance(value, Group):
        return [vars(value)["address"]]
    if isinstance(value, tuple):
        return [word for one in value for word in _words_of(one)]
    if isinstance(value, float):
        return [int(np.float64(value).view(np.int64))]
    if isinstance(value, int | np.int64):
        return [int(value)]
    raise TypeError(f"a group holds arrays, numbers and groups, not {value!r}")


def _address_of(array: np.ndarray) -> int:
    return int(array.__array_interface__["data"][0])


class GroupType(types.Type):  # type: ignore[misc]
    """Type of a group in kernels."""

    def __init__(self, name: str, fields: dict[str, Any]) -> None:
        self.fields = fields
        known = ", ".join(f"{field}: {kind}" for field, kind in fields.items())
        super().__init__(f"{name}<{hashlib.sha256(known.encode()).hexdigest()[:16]}>")  # in full it has thousands

    def place(self, name: str) -> int:
        """Where the field begins [words]."""
        before = list(self.fields).index(name)
        return sum(_size(kind) for kind in list(self.fields.values())[:before])


def _size(kind: Any) -> int:
    """Of a field [words]."""
    if isinstance(kind, types.Array):
        return 3 + 2 * int(kind.ndim)
    return sum(_size(one) for one in kind) if isinstance(kind, Tuple) else 1


class _Fields(templates.AttributeTemplate):  # type: ignore[misc]
    key = GroupType

    def generic_resolve(self, kind: GroupType, name: str) -> Any:
        return kind.fields.get(name)


def _load_field(context: Any, builder: Any, kind: GroupType, group: Any, name: str) -> Any:
    return _load(context, builder, kind.fields[name], cgutils.gep_inbounds(builder, group, kind.place(name)))


def _load(context: Any, builder: Any, kind: Any, words: Any) -> Any:
    """The field of type `kind` that begins at `words`."""
    if isinstance(kind, types.Array):
        return _load_array(context, builder, kind, words)
    if isinstance(kind, Tuple):
        ends = np.cumsum([0, *(_size(one) for one in kind)])
        begins = [cgutils.gep_inbounds(builder, words, int(end)) for end in ends[:-1]]
        values = [_load(context, builder, one, begin) for one, begin in zip(kind, begins, strict=True)]
        return context.make_tuple(builder, kind, values)
    found = _load_word(builder, words, 0, context.get_data_type(kind))  # of a bool the lowest byte
    return context.data_model_manager[kind].from_data(builder, found)


def _load_array(context: Any, builder: Any, kind: Any, words: Any) -> Any:
    array = context.make_array(kind)(context, builder)
    array.nitems, array.itemsize = (_load_word(builder, words, at, WORD) for at in range(2))
    array.data = _load_word(builder, words, 2, array.data.type)
    shape_and_strides = [_load_word(builder, words, 3 + at, WORD) for at in range(2 * kind.ndim)]
    array.shape = cgutils.pack_array(builder, shape_and_strides[: kind.ndim])
    array.strides = cgutils.pack_array(builder, shape_and_strides[kind.ndim :])
    return array._getvalue()


def _load_word(builder: Any, words: Any, at: int, kind: Any) -> Any:
    """Of LLVM's type `kind`. It never changes, so the compiler need not load it again after anything is written."""
    place = builder.bitcast(cgutils.gep_inbounds(builder, words, at), kind.as_pointer())
    found = builder.load(place)
    found.set_metadata("invariant.load", builder.module.add_metadata([]))
    return found


known_by_address(Group, GroupType)
templates.infer_getattr(_Fields)
lower_getattr_generic(GroupType)(_load_field)
