"""Compiled kernels are kept for exactly the sources that they were made from."""

import re
from pathlib import Path

import controller

ROOT = Path(controller.__file__).parent


def test_a_change_of_any_constant_that_kernels_import_makes_a_new_cache() -> None:
    """Else the loop would go on by the old table of states."""
    imported = set()
    for path in (ROOT / "kernels").glob("*.py"):
        imported |= set(re.findall(r"^from controller\.([a-z_.]+) import", path.read_text(), re.MULTILINE))
    outside = {ROOT / f"{name}.py" for name in imported if not name.startswith("kernels")}
    assert ROOT / "states.py" in outside
    assert outside <= set(controller.compiled_sources())
