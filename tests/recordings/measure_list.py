"""`python -m tests.recordings.measure_list`: how long a list of 5 000 recordings takes, in ms, as medians."""

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from datetime import UTC, datetime, timedelta
from pathlib import Path

from controller.schema.parameters import Settings
from recordings.format import sidecar
from recordings.format.messages import Metrics, Recording
from recordings.read.query import matching, ordered
from recordings.store.store import Store
from server.recorder.routes import LIST

COUNT = 5000
TIMES = 11
COLD = """
import sys, time
from pathlib import Path
from recordings.store.store import Store
store = Store(Path(sys.argv[1]))
begin = time.perf_counter()
store.list()
print((time.perf_counter() - begin) * 1e3)
"""


def main() -> None:
    """Print one line for each way to list."""
    with tempfile.TemporaryDirectory(prefix="tendril-list-") as name:
        folder = Path(name)
        _fill(folder)
        print(f"no index file yet: {_ms(lambda: Store(folder).list()):.0f}")
        cold = [float(subprocess.check_output([sys.executable, "-c", COLD, name])) for _ in range(TIMES)]
        print(f"first of a new process: {statistics.median(cold):.0f}")
        store = Store(folder)
        print(f"again: {_median(store.list):.0f}")
        print(f"again, searched, sorted by rmse, as JSON: {_median(lambda: _answer(store)):.0f}")


def _fill(folder: Path) -> None:
    begin = datetime(2026, 1, 1, tzinfo=UTC)
    for n in range(COUNT):
        started = begin + timedelta(minutes=n)
        id = f"{started:%Y%m%d-%H%M%S}-circle"
        found = Recording(
            id=id,
            name=f"circle {n}",
            started=started,
            seconds=60.0,
            rows=60_000,
            gaps=0,
            bytes=10**7,
            actuator="P1",
            twin=True,
            complete=True,
            settings=Settings(),
            metrics=Metrics(rmse=(n * 7919 % COUNT) * 1e-6, max_error=0.01, lost=n % 7, on_time_share=0.999),
            tags=("bench", f"day-{n // 1440}"),
            notes="nothing to say",
        )
        sidecar.write(folder, found)
        (folder / f"{id}.rrd").touch()


def _answer(store: Store) -> bytes:
    return LIST.dump_json(ordered(matching(store.list(), "circle bench"), "rmse"))


def _median(work: Callable[[], object]) -> float:
    work()
    return statistics.median(_ms(work) for _ in range(TIMES))


def _ms(work: Callable[[], object]) -> float:
    begin = time.perf_counter()
    work()
    return (time.perf_counter() - begin) * 1e3


if __name__ == "__main__":
    main()
