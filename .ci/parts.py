"""Makes the targets that are named, one after the other, and says how long each took and its memory at most.

python .ci/parts test-python test-browser
"""

import os
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

SAMPLE_S = 2.0


def parents() -> dict[int, int]:
    """Parent of every process."""
    found = {}
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            found[int(stat.parent.name)] = int(stat.read_text().rsplit(")", 1)[1].split()[1])
        except (OSError, IndexError):
            pass  # it has ended
    return found


def family(root: int) -> set[int]:
    """`root` and all that descends from it."""
    found, children = {root}, parents()
    while more := {one for one, parent in children.items() if parent in found} - found:
        found |= more
    return found


def resident(process: int) -> int:
    """Its share of the memory that it has [bytes]."""
    try:
        return 1024 * int(re.search(r"^Pss:\s+(\d+)", Path(f"/proc/{process}/smaps_rollup").read_text(), re.M)[1])
    except (OSError, TypeError):
        return 0


class Peak(threading.Thread):
    """Most memory that all processes of a part had together."""

    def __init__(self) -> None:
        super().__init__(daemon=True)
        self.bytes, self.done = 0, threading.Event()

    def run(self) -> None:
        """Look at it until `done`."""
        while not self.done.wait(SAMPLE_S):
            self.bytes = max(self.bytes, sum(map(resident, family(os.getpid()))))


def main(targets: list[str]) -> int:
    """Exit code: that of the first target that failed, with which it ends."""
    said, code = [], 0
    for target in targets:
        peak, began = Peak(), time.monotonic()
        peak.start()
        code = subprocess.run(["make", "--no-print-directory", target]).returncode
        peak.done.set()
        minutes, seconds = divmod(round(time.monotonic() - began), 60)
        said.append(f"{target:16} {minutes:3}:{seconds:02}  {peak.bytes / 2**30:5.1f} GB at most")
        if code:
            break
    print("\n".join([*said, "failed" if code else "all passed"]))
    return code


sys.exit(main(sys.argv[1:]))
