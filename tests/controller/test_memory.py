"""What a process keeps of its start."""

import ctypes
import json
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import json
from pathlib import Path
from controller.kernels.model.rod import accelerate  # numba and its compiler
from controller.system.memory import forget_start

def resident():
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096

import llvmlite.binding as llvm
module = llvm.parse_assembly("define i64 @one() { ret i64 1 }")
before = resident()
forget_start()
after = resident()
again = str(llvm.parse_assembly("define i64 @two() { ret i64 2 }"))
print(json.dumps([before, after, again]))
"""


@pytest.mark.skipif(not hasattr(ctypes.CDLL(None), "malloc_trim"), reason="glibc only")
def test_code_that_only_the_start_needed_is_given_back_and_can_be_called_again() -> None:
    root = Path(__file__).parents[2]
    said = subprocess.run([sys.executable, "-c", PROGRAM], cwd=root, check=True, capture_output=True, text=True).stdout
    before, after, again = json.loads(said)
    assert after < before - 5e6 and "ret i64 2" in again
