"""What a process keeps of its start."""

import ctypes
import gc
import json
import subprocess
import sys
from pathlib import Path

import pytest

from controller.system.memory import SELDOM, collect_seldom

pytestmark = pytest.mark.process

PROGRAM = """
import json
from pathlib import Path
from controller.kernels.model.rod import accelerate  # numba and its compiler
from controller.system.memory import forget_start

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

def constants():
    # resident part of the compiler's tables, which are no code [kB]
    found, ours = 0, False
    for line in Path("/proc/self/smaps").read_text().splitlines():
        if "-" in line.split()[0]:
            ours = "libllvmlite" in line and " r--p " in line
        elif ours and line.startswith("Rss:"):
            found += int(line.split()[1])
    return found

import llvmlite.binding as llvm
module = llvm.parse_assembly("define i64 @one() { ret i64 1 }")
before = resident(), constants()
forget_start()
after = resident(), constants()
again = str(llvm.parse_assembly("define i64 @two() { ret i64 2 }"))
print(json.dumps([before, after, again]))
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="glibc only")
def test_code_and_constants_that_only_the_start_needed_are_given_back_and_can_be_used_again() -> None:
    root = Path(__file__).parents[3]
    said = subprocess.run([sys.executable, "-c", PROGRAM], cwd=root, check=True, capture_output=True, text=True).stdout
    before, after, again = json.loads(said)
    assert after[0] < before[0] - 5e6 and after[1] < before[1] / 2 and "ret i64 2" in again


def test_what_is_young_is_collected_as_often_as_ever() -> None:
    before = gc.get_threshold()
    try:
        collect_seldom()
        assert gc.get_threshold() == (*before[:2], SELDOM)
    finally:
        gc.set_threshold(*before)
