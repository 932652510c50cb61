"""`python -m recordings.size`: what an hour of each profile takes, on rows of the twin that follows the paper's VU."""

import tempfile
from pathlib import Path

import numpy as np

from controller.arrays import Rows
from controller.reference import library
from controller.schema.parameters import RigParameters, Settings
from controller.simulation.run import run
from recordings.format import tool
from recordings.format.about import About
from recordings.format.messages import Profile
from recordings.format.profiles import PROFILES
from recordings.write.rrd import RrdFile
from recordings.write.run_file import simulated_rig

BATCH = 130
"""Rows handed over at once, as the recorder does at 1 kHz."""
LATE_NS, STEP_NS = 60_000, 30_000
"""Typical lateness and duration of a tick: a simulated clock is never late, and its zeros would cost nothing."""


def main() -> None:
    """Print MB per hour of both profiles, as written and after compaction."""
    rows = twin_rows("vu")
    print("profile     MB/h as written   MB/h compacted")
    with tempfile.TemporaryDirectory(prefix="tendril-size-") as folder:
        for profile in PROFILES:
            written, compacted = megabytes_per_hour(rows, profile.name, Path(folder))
            print(f"{profile.name:10}  {written:15.0f}   {compacted:14.0f}")


def twin_rows(name: str) -> Rows:
    """Telemetry of the twin that tracks the library's reference `name`, with a live loop's times."""
    parameters = RigParameters()
    reference = library.reference(name, parameters.actuator, parameters.controller)
    return timed(run(parameters, reference, Settings(), seed=1))


def timed(rows: Rows) -> Rows:
    """`rows` with the jitter of a live loop in their times."""
    out, chance = rows.copy(), np.random.default_rng(1)
    out["lateness_ns"] = chance.gamma(4.0, LATE_NS / 4, len(rows))
    out["step_ns"] = chance.gamma(40.0, STEP_NS / 40, len(rows))
    out["t_ns"] = rows["slot"] * 1_000_000 + out["lateness_ns"]
    return out


def megabytes_per_hour(rows: Rows, profile: Profile, folder: Path) -> tuple[float, float]:
    """What `rows` take in the files (as written, compacted) beyond what a file without rows takes."""
    sizes = np.subtract(_sizes(rows, profile, folder), _sizes(rows[:0], profile, folder))
    written, compacted = sizes / 1e6 * 3.6e6 / len(rows)
    return float(written), float(compacted)


def _sizes(rows: Rows, profile: Profile, folder: Path) -> tuple[int, int]:
    path, small = folder / f"{profile}.rrd", folder / f"{profile}-compacted.rrd"
    file = RrdFile(path, About(profile, profile, simulated_rig(RigParameters()), Settings(), profile))
    for begin in range(0, len(rows), BATCH):
        file.write(rows[begin : begin + BATCH])
        file.flush()
    file.close()
    tool.run("rrd", "optimize", str(path), "-o", str(small), timeout=600.0)
    return path.stat().st_size, small.stat().st_size


if __name__ == "__main__":
    main()
