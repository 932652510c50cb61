"""The thread behind the Review tab: what is left behind by a killed writer is mended, or said to be damaged."""

from datetime import UTC, datetime
from pathlib import Path

from recordings import sidecar
from recordings.messages import Recording
from recordings.store import Store
from server.review import Review
from tests.server.live_server import wait_for


def test_what_cannot_be_mended_is_listed_with_the_reason(tmp_path: Path) -> None:
    started = datetime(2026, 11, 20, 12, tzinfo=UTC)
    id, lock = sidecar.claim(tmp_path, "torn", started)
    lock.close()
    (tmp_path / f"{id}.rrd").write_bytes(b"no rerun data at all")
    left = Recording(
        id=id,
        name="torn",
        started=started,
        seconds=0.0,
        rows=0,
        gaps=0,
        bytes=20,
        actuator="P1",
        twin=True,
        complete=False,
    )
    sidecar.write(tmp_path, left)
    store = Store(tmp_path)
    assert store.list()[0].problem == ""
    Review(store)
    assert "verify failed" in wait_for(lambda: store.list()[0].problem, "the reason")
    assert not store.list()[0].recovered
