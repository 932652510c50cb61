"""Groups: what kernels are handed by one address."""

import copy
import pickle
import subprocess
import sys
from typing import Any, NamedTuple

import numpy as np
import pytest

from controller.arrays import Array, Rows, Words
from controller.kernels.compiled import kernel
from controller.kernels.group import Group


class Inner(Group):
    """A group in a group."""

    k: Array
    n: int


class Value(NamedTuple):
    """Made of several fields itself."""

    x: float
    at: Words


class Outer(Group):
    """One field of each kind."""

    gain: float
    inner: Inner
    value: Value
    grid: Array
    rows: Rows
    pair: tuple[float, int]
    right: bool
    wrong: bool


def outer() -> Outer:
    rows = np.zeros(2, [("a", "<f8"), ("b", "<i8")])
    rows["a"], rows["b"] = [1.5, 2.5], [3, 4]
    value = Value(0.25, np.array([7, 8, 9]))
    grid = np.arange(24.0).reshape(2, 3, 4)[:, ::2]
    inner = Inner(np.array([1.0, 2.0]), -3)
    return Outer(0.5, inner, value, grid=grid, rows=rows, pair=(1.25, 6), right=True, wrong=False)


@kernel
def read(group: Outer, out: Array) -> None:
    out[0], out[1], out[2] = group.gain, group.inner.k[1], group.inner.n
    out[3], out[4], out[5] = group.value.x, group.value.at[2], group.grid[1, 1, 3]
    out[6], out[7] = group.rows[1].a, group.rows[1].b
    out[8], out[9] = group.pair
    out[10], out[11], out[12] = group.grid.shape[0], group.grid.shape[1], group.value.at.size
    out[13] = 1.0 if group.right and not group.wrong else 0.0


@kernel
def write(group: Outer) -> float:
    before = group.inner.k[0]
    group.inner.k[0], group.rows[0].b = 11.0, 12
    return before + group.inner.k[0]


def test_a_kernel_reads_every_kind_of_field() -> None:
    out = np.zeros(14)
    read(outer(), out)
    assert out.tolist() == [0.5, 2.0, -3.0, 0.25, 9.0, 23.0, 2.5, 4.0, 1.25, 6.0, 2.0, 2.0, 3.0, 1.0]


def test_what_a_kernel_writes_into_its_arrays_is_seen_by_all() -> None:
    group = outer()
    assert write(group) == 12.0
    assert group.inner.k[0] == 11.0 and group.rows["b"][0] == 12
    group.inner.k[0] = 1.0
    assert write(group) == 12.0


def test_the_fields_stay_and_another_group_has_others() -> None:
    group = outer()
    with pytest.raises(AttributeError, match="gain"):
        group.gain = 1.0  # type: ignore[misc]
    other, out = group._replace(gain=2.0), np.zeros(14)
    read(other, out)
    assert out[0] == 2.0 and group.gain == 0.5 and other.inner is group.inner
    assert other.kind == group.kind
    assert Inner(np.zeros((1, 1)), 0).kind != group.inner.kind


@pytest.mark.parametrize("copied", [copy.deepcopy, lambda group: pickle.loads(pickle.dumps(group))])
def test_a_copy_is_a_group_of_its_own(copied: Any) -> None:
    group = outer()
    other = copied(group)
    assert write(other) == 12.0 and other.inner.k[0] == 11.0 and group.inner.k[0] == 1.0
    assert write(copy.copy(group)) == 12.0 and group.inner.k[0] == 11.0, "this one has the same arrays"


UNFIT: list[Any] = ["text", None, [1.0], 1j]


@pytest.mark.parametrize("value", UNFIT)
def test_what_is_no_number_and_no_array_is_refused(value: Any) -> None:
    with pytest.raises(TypeError, match="holds arrays"):
        Inner(np.zeros(1), value)


@pytest.mark.parametrize(("values", "named"), [((1,), {}), ((1, 2, 3), {}), ((1,), {"k": 2}), ((1,), {"m": 2})])
def test_all_fields_are_given_once(values: tuple[Any, ...], named: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match="Inner takes k, n"):
        Inner(*values, **named)


@pytest.mark.process
def test_a_group_is_one_argument_whose_kernel_the_next_process_has_from_the_cache() -> None:
    """Its type's name says all of its fields, and is the same in every process."""
    told = """
import numpy as np
from controller.kernels.model.statics import points_on
from controller.assembly.rod import build_rod
from controller.kernels.model.statics import at_rest, places
from controller.schema.actuator import PRESETS
model = build_rod(PRESETS["P1"], 10)
points_on(at_rest(model).q, places(model, np.zeros(1)), np.zeros((1, 2)))
print(sum(points_on.stats.cache_misses.values()))
"""
    found = [subprocess.run([sys.executable, "-c", told], capture_output=True, text=True, check=True) for _ in range(2)]
    assert found[1].stdout == "0\n"
