"""Bookmarks: where they stand in the file and beside it, and that nothing which happens to a recording loses them."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
from mcap.reader import make_reader
from scipy.io import loadmat

from controller.errors import RecordingError
from controller.schema.parameters import Settings
from recordings.exporting.export import export
from recordings.exporting.table import Choice
from recordings.format.messages import BOOKMARKS_MAX, Bookmark, Recording
from recordings.read.query import matching
from recordings.read.reader import read_bookmarks
from recordings.store.edits import with_bookmark, with_label, without_bookmark
from recordings.store.store import Store
from recordings.write.writer import Recorder
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

COUNT, AT = 4000, (999, 2499)
ROWS = telemetry_rows(COUNT)
TIMES = [float(ROWS["t_ns"][at] - ROWS["t_ns"][0]) * 1e-9 for at in AT]


def marked(folder: Path, recorder: Recorder) -> Recording:
    """A recording in which two ticks were marked, the second without a label."""
    recorder.start("marked", rig_info(), Settings())
    store, begin = Store(folder), 0
    for at, label in zip(AT, ("touched, with a comma", ""), strict=True):
        recorder.rows(ROWS[begin : at + 1])
        id, mark = recorder.mark(label)
        recorder.bookmarked(store.revise(id, lambda found, mark=mark: with_bookmark(found, mark)))
        begin = at + 1
    recorder.rows(ROWS[begin:])
    return recorder.stop()


def test_a_bookmark_names_the_newest_row_in_the_file_and_beside_it(tmp_path: Path, recorder: Recorder) -> None:
    done = marked(tmp_path, recorder)
    wanted = (
        Bookmark(n=1, tick=AT[0], t=TIMES[0], label="touched, with a comma"),
        Bookmark(n=2, tick=AT[1], t=TIMES[1]),
    )
    assert done.bookmarks == Store(tmp_path).find(done.id).bookmarks == wanted
    found = read_bookmarks(tmp_path / f"{done.id}.rrd")
    assert [(mark.n, mark.tick, mark.label) for mark in found] == [(mark.n, mark.tick, mark.label) for mark in wanted]
    np.testing.assert_allclose([mark.t for mark in found], TIMES, atol=1e-9)


def test_the_state_tells_them_and_where_time_begins(tmp_path: Path, recorder: Recorder) -> None:
    recorder.start("told", rig_info(), Settings())
    recorder.rows(ROWS[:500])
    id, mark = recorder.mark("here")
    recorder.bookmarked(Store(tmp_path).revise(id, lambda found: with_bookmark(found, mark)))
    for batch in batches(ROWS[500:1500]):
        recorder.rows(batch)
    recorder.mark()  # whatever was handed over before is written now
    state = recorder.state()
    assert state.bookmarks == (mark,)
    assert state.origin + mark.t == pytest.approx(float(ROWS["t_ns"][499]) * 1e-9, abs=1e-6)


def test_they_can_be_named_and_removed_and_keep_their_numbers(tmp_path: Path, recorder: Recorder) -> None:
    done, store = marked(tmp_path, recorder), Store(tmp_path)
    store.revise(done.id, lambda found: with_label(found, 2, "let go"))
    assert matching(store.list(), "let go") == store.list()
    left = store.revise(done.id, lambda found: without_bookmark(found, 1))
    assert [(mark.n, mark.label) for mark in left.bookmarks] == [(2, "let go")]
    for gone in (lambda found: with_label(found, 1, "x"), lambda found: without_bookmark(found, 1)):
        with pytest.raises(RecordingError, match="has no bookmark 1"):
            store.revise(done.id, gone)


@pytest.mark.process
def test_mending_compacting_and_a_lost_description_keep_them(tmp_path: Path, recorder: Recorder) -> None:
    done, store = marked(tmp_path, recorder), Store(tmp_path)
    assert store.compact(done.id).bookmarks == done.bookmarks
    (tmp_path / f"{done.id}.json").unlink()
    found = store.repair(done.id).bookmarks
    assert [(mark.n, mark.label) for mark in found] == [(1, "touched, with a comma"), (2, "")]


def test_nothing_is_marked_before_a_row_without_a_recording_or_beyond_the_most(recorder: Recorder) -> None:
    with pytest.raises(RecordingError, match="no recording is running"):
        recorder.mark("x")
    recorder.start("empty", rig_info(), Settings())
    with pytest.raises(RecordingError, match="nothing is recorded yet"):
        recorder.mark("x")
    recorder.rows(ROWS[:100])
    for _ in range(BOOKMARKS_MAX):
        recorder.mark()
    with pytest.raises(RecordingError, match="100 bookmarks"):
        recorder.mark()


def test_every_export_carries_them(tmp_path: Path, recorder: Recorder) -> None:
    done = marked(tmp_path, recorder)
    source, texts = tmp_path / f"{done.id}.rrd", ["1 touched, with a comma", "2"]

    def exported(kind: str, choice: Choice = Choice(("u",))) -> Path:
        export(source, target := tmp_path / f"out.{kind}", kind, choice)  # type: ignore[arg-type]
        return target

    for found in (pd.read_csv(exported("csv"), dtype={"bookmark": str}), pd.read_parquet(exported("parquet"))):
        at = found["bookmark"].notna()
        assert (found["bookmark"][at].tolist(), np.flatnonzero(at).tolist()) == (texts, list(AT))
    mat = loadmat(exported("mat"), simplify_cells=True)["tendril"]
    assert mat["bookmark"].tolist() == texts
    np.testing.assert_allclose(mat["bookmark_t"], TIMES, atol=1e-9)
    with exported("mcap").open("rb") as file:
        said = [json.loads(message.data) for _, _, message in make_reader(file).iter_messages(["/bookmark"])]
    assert [one["text"] for one in said] == texts
    assert read_bookmarks(exported("rrd", Choice())) == read_bookmarks(source)
    later = exported("csv", Choice(("u",), start=TIMES[1] + 0.1))
    assert "bookmark" not in later.read_text().splitlines()[0], "none in the window: the columns are as ever"
    assert pyarrow.parquet.read_schema(exported("parquet")).names[-1] == "bookmark"
