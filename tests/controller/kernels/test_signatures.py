"""Kernels as the house writes them: typed, inputs first, then what they carry on, at last what they only write."""

import ast
import re
from typing import NamedTuple

import pytest

from tests.docs.test_readme import ROOT, TABLE

SECTIONS = {
    "Constrained Dynamic Model",
    "Parameter Estimation",
    "Controller Architecture",
    "Quasi-Static Feedforward Control",
    "Dynamic observer",
    "Task-space PI control",
    "Stability and Passivity Analysis",
    "Experimental Platform",
    "Hardware setup",
    "Task 4: Reduced Sensing",
    "Task 5: Real-Time User-Defined Tracking",
}
"""Of the paper, as far as anything is taken from them."""


class Kernel(NamedTuple):
    name: str
    tree: ast.FunctionDef
    doc: str

    @property
    def arguments(self) -> list[str]:
        return [argument.arg for argument in self.tree.args.args]

    @property
    def in_place(self) -> set[str]:
        """Arguments that the docstring says are read and written."""
        found = re.search(r"In place: (.+?)\.(?:\s|$)", self.doc, re.DOTALL)
        words = re.findall(r"(?<![\w.])[a-zA-Z_]\w*", re.sub(r"\([^)]*\)", "", found[1])) if found else []
        return set(words) & set(self.arguments)

    def changes(self, argument: str) -> bool:
        return argument.startswith("out_") or argument in self.in_place


def kernels() -> dict[str, Kernel]:
    found = {}
    for path in sorted((ROOT / "controller" / "kernels").rglob("*.py")):
        for node in ast.parse(path.read_text()).body:
            if isinstance(node, ast.FunctionDef) and {ast.unparse(d) for d in node.decorator_list} & {
                "kernel",
                "inlined",
            }:
                assert node.name not in found, f"two kernels are called {node.name}"
                found[node.name] = Kernel(node.name, node, ast.get_docstring(node) or "")
    return found


KERNELS = kernels()


def root(node: ast.expr) -> str:
    """`control` of `control.state[0].u`; empty for what has no name."""
    while isinstance(node, ast.Attribute | ast.Subscript):
        node = node.value
    return node.id if isinstance(node, ast.Name) else ""


def aliases(kernel: Kernel) -> dict[str, str]:
    """Local names of (parts of) arguments."""
    found = {argument: argument for argument in kernel.arguments}
    for node in ast.walk(kernel.tree):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            names = target.elts if isinstance(target, ast.Tuple) else [target]
            both = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
            for name, part in zip(names, value.elts if both else [value] * len(names), strict=True):
                if isinstance(name, ast.Name) and root(part) in found:
                    found.setdefault(name.id, found[root(part)])
    return found


def written(kernel: Kernel) -> set[str]:
    """Arguments into which the kernel, or one that it calls, writes."""
    named, found = aliases(kernel), set()
    for node in ast.walk(kernel.tree):
        if isinstance(node, ast.Attribute | ast.Subscript) and isinstance(node.ctx, ast.Store):
            found.add(root(node))
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and (inner := KERNELS.get(node.func.id)):
            found |= {
                root(given) for given, taken in zip(node.args, inner.arguments, strict=True) if inner.changes(taken)
            }
    return {named[name] for name in found if name in named}


@pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
def test_a_kernel_is_typed_and_says_where_the_paper_has_it(kernel: Kernel) -> None:
    assert all(argument.annotation for argument in kernel.tree.args.args)
    assert kernel.tree.returns is not None
    text = " ".join(kernel.doc.split())
    cited = re.findall(r"[Pp]aper,? (?:[\w ,]*)\"([^\"]+)\"", text)
    equations = {name for name in re.findall(r"Eq\. \w+", text)}
    assert cited or equations or "ot in the paper" in text
    assert set(cited) <= SECTIONS
    assert equations <= {name for name, _, _ in TABLE}


@pytest.mark.parametrize("kernel", KERNELS.values(), ids=KERNELS)
def test_a_kernel_takes_inputs_first_then_what_it_carries_on_and_last_what_it_writes(kernel: Kernel) -> None:
    order = [2 if name.startswith("out_") else int(name in kernel.in_place) for name in kernel.arguments]
    assert order == sorted(order)
    assert {name for name in kernel.arguments if kernel.changes(name)} == written(kernel)
