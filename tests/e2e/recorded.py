"""Recordings made without a rig, in the folder of a running product."""

from pathlib import Path

import numpy as np

from controller.reference.library import CENTRE
from controller.schema.parameters import Settings
from recordings.format.messages import Profile, Recording
from recordings.write.session import Context
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows


def record_circle(folder: Path, name: str, seconds: float, first: int = 0, profile: Profile = "full") -> Recording:
    """A circle of 0.5 Hz with noise, every tick from `first` on. Its reference can be followed from rest."""
    recorder = Recorder(folder)
    recorder.start(name, rig_info(), Settings(), Context(profile=profile))
    rows = telemetry_rows(round(seconds * 1e3), first)
    rows["p_ref"] = CENTRE + 0.2 * (rows["p_ref"] - rows["p_ref"].mean(axis=0))
    for batch in batches(rows, 500):
        recorder.rows(batch)
    done = recorder.stop()
    recorder.close()
    return done


def list_many(folder: Path, like: Recording, count: int) -> list[Path]:
    """`count` more rows in the list, each with an empty file: all files made."""
    made: list[Path] = []
    for n in range(count):
        id = f"20200101-{n // 3600:02d}{n // 60 % 60:02d}{n % 60:02d}"
        row = like.model_copy(update={"id": id, "name": f"old {n}", "bytes": int(np.sin(n) ** 2 * 1e6)})
        made += [folder / f"{id}.json", folder / f"{id}.rrd"]
        made[-2].write_text(row.model_dump_json())
        made[-1].touch()
    return made
