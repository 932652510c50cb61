"""A process that records, stops, compacts, edits, removes, imports and keeps its state; it says what it has done."""

import sys
import time
from pathlib import Path

from controller.schema.parameters import Settings
from controller.system.keys import made_key
from recordings.importing.tip import import_text
from recordings.read.quick import prepare
from recordings.store.edits import Edit
from recordings.store.store import Store
from recordings.write.writer import Recorder
from tests.recordings.lateness import Lateness
from tests.recordings.synthetic import rig_info, telemetry_rows

BATCH, ROWS = 10, 3000


def say(text: str) -> None:
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main(folder: Path, edited: str, removed: str) -> None:
    store, recorder, rows = Store(folder), Recorder(folder), telemetry_rows(ROWS)
    running = recorder.start("cut", rig_info(), Settings()).id
    say(f"started {running}")
    start, lateness = time.monotonic(), Lateness()
    for first in range(0, ROWS, BATCH):
        time.sleep(max(0.0, start + first * 1e-3 - time.monotonic()))
        recorder.rows(rows[first : first + BATCH])
        say(f"tick {first + BATCH - 1} {lateness.ticks}")
        if first == ROWS // 2:
            store.edit(edited, Edit(name="new name"))
            say("edited")
    recorder.stop()
    say("stopped")
    store.compact(running)
    prepare(store.path(running))
    store.measure(running)
    say("compacted")
    say("removing")
    store.remove(removed)
    say("removed")
    imported, _ = import_text(
        folder, "imported", b"time,x,y\n0,0.1,0\n0.1,0.1,0.01\n0.2,0.1,0.02\n", {"t": "s", "x": "m", "y": "m"}
    )
    say(f"imported {imported.id}")
    made_key(folder / "rig.key")
    say("key")


if __name__ == "__main__":
    main(Path(sys.argv[1]), *sys.argv[2:])
