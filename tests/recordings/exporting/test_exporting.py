"""What is exported, read back by programs that we did not write, is what rerun's own reader finds in the recording."""

import hashlib
import json
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import jsonschema_rs
import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
from mcap.reader import make_reader
from rerun.chunk import McapReader, RrdReader
from scipy.io import loadmat

from controller.errors import ParameterError
from controller.reference.path_file import read_samples
from controller.schema.modes import Mode
from controller.schema.origin import Origin
from controller.schema.parameters import Settings
from controller.system.origin import commit, our_version
from recordings.exporting.export import By, Format, export
from recordings.exporting.signals import offered
from recordings.exporting.table import Choice, RowReader, joined
from recordings.exporting.tip_path import Wanted, tip_path, write_path
from recordings.format import tool
from recordings.format.messages import Profile, Recording
from recordings.read.reader import read_rows
from recordings.write.rrd import About, RrdFile
from tests.recordings.synthetic import batches, rig_info, telemetry_rows

pytestmark = pytest.mark.keyed()

Record = Callable[..., Recording]
COUNT = 3210
WALL_NS = int(telemetry_rows(1)["t_ns"][0]) + rig_info().wall_offset_ns


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """One recording for all tests that only read."""
    path = tmp_path_factory.mktemp("exporting") / "source.rrd"
    file = RrdFile(path, About("source", "source", rig_info(), Settings()))
    for batch in batches(telemetry_rows(COUNT), 250):
        file.write(batch)
    file.close()
    return path


def exported(source: Path, kind: Format, *signals: str, start: float | None = None, stop: float | None = None) -> Path:
    target = source.with_name(f"exported.{kind}")
    export(source, target, kind, Choice(signals, start, stop))
    return target


def in_rerun(source: Path, entity: str) -> tuple[np.ndarray, np.ndarray]:
    """Times [ns] and scalars (n, series) of an entity, by rerun's reader alone."""
    t: list[int] = []
    values: list[list[float]] = []
    for chunk in RrdReader(source).stream().filter(content=[entity]):
        batch = chunk.to_record_batch()
        if "t" in batch.schema.names:
            t += batch.column("t").cast("int64").to_pylist()
            values += batch.column("Scalars:scalars").to_pylist()
    order = np.argsort(t)
    return np.array(t)[order], np.array(values)[order]


def test_csv_has_every_digit_in_pandas_and_units_in_its_header(source: Path) -> None:
    found = pd.read_csv(exported(source, "csv"))
    t, pressures = in_rerun(source, "/pressures")
    _, tip = in_rerun(source, "/tip/x")
    assert found.columns[0] == "t [s]" and len(found) == COUNT
    np.testing.assert_array_equal(found["t [s]"], t / 1e9)
    np.testing.assert_array_equal(found[[f"pressure_meas_{i} [Pa]" for i in (1, 2, 3, 4)]], pressures[:, 4:])
    np.testing.assert_array_equal(found["p_meas_x [m]"], tip[:, 2])
    assert found["mode"].dtype == np.int64


def test_what_is_slower_is_blank_between_its_values_and_nan_where_it_was_not_seen(source: Path) -> None:
    file = exported(source, "csv", "markers_10_x", "markers_4_x", "tick")
    lines = file.read_text().splitlines()
    assert lines[0] == "t [s],markers_10_x [m],markers_4_x [m],tick"
    assert [line.split(",")[1] == "" for line in lines[1:13]] == [False, *[True] * 9, False, True]
    assert lines[1].split(",")[2] == "nan"
    t, markers = in_rerun(source, "/markers")
    kept = pd.read_csv(file).dropna(subset="markers_10_x [m]")
    np.testing.assert_array_equal(kept["t [s]"], t / 1e9)
    np.testing.assert_array_equal(kept["markers_10_x [m]"], markers[:, 18])


def test_parquet_is_exact_with_types_and_units(source: Path) -> None:
    found = pyarrow.parquet.read_table(exported(source, "parquet"))
    t, torques = in_rerun(source, "/u")
    units = {field.name: field.metadata[b"unit"].decode() for field in found.schema}
    assert (units["t"], units["u_1"], units["pressure_cmd_3"], units["mode"]) == ("s", "N m", "Pa", "1")
    np.testing.assert_array_equal(found["t"].to_numpy(), t / 1e9)
    np.testing.assert_array_equal(np.column_stack([found["u_1"], found["u_2"]]), torques[:, :2])
    assert found["backbone_20_x"].type == "float" and found["backbone_20_x"].null_count == COUNT - COUNT // 10


def test_mat_is_exact_and_slow_signals_have_their_own_times(source: Path) -> None:
    found = loadmat(exported(source, "mat"), simplify_cells=True)["tendril"]
    t, tip = in_rerun(source, "/tip/y")
    marked, markers = in_rerun(source, "/markers")
    np.testing.assert_array_equal(found["t"], t / 1e9)
    np.testing.assert_array_equal(found["p_ref_y"], tip[:, 1])
    np.testing.assert_array_equal(found["markers_t"], marked / 1e9)
    np.testing.assert_array_equal(found["markers_10_y"], markers[:, 19])
    assert found["units"]["p_ref_y"] == "m" and found["started_unix_ns"] == WALL_NS


def test_mcap_is_exact_on_topics_that_a_plotter_understands(source: Path) -> None:
    said: dict[str, list[tuple[int, dict[str, Any]]]] = defaultdict(list)
    with exported(source, "mcap").open("rb") as file:
        for schema, channel, message in make_reader(file, validate_crcs=True).iter_messages():
            assert schema and (schema.encoding, channel.message_encoding) == ("jsonschema", "json")
            if schema.name.startswith("foxglove."):
                continue
            properties = json.loads(schema.data)["properties"]
            text = json.loads(message.data)
            assert set(text) <= set(properties)
            said[channel.topic].append((message.log_time, text))
    assert set(said) == {
        *("/tip", "/torques", "/pressures", "/observer", "/timing", "/state"),
        *("/markers", "/backbone", "/twin_backbone"),
    }
    t, pressures = in_rerun(source, "/pressures")
    assert [at for at, _ in said["/pressures"]] == (t + WALL_NS).tolist()
    for index in range(4):
        name = f"pressure_cmd_{index + 1}"
        np.testing.assert_array_equal([text[name] for _, text in said["/pressures"]], pressures[:, index])
    marked, markers = in_rerun(source, "/markers")
    assert [at for at, _ in said["/markers"]] == (marked + WALL_NS).tolist()
    np.testing.assert_array_equal([text["markers_10_x"] for _, text in said["/markers"]], markers[:, 18])
    assert "markers_4_x" not in said["/markers"][0][1], "nan is no JSON"


def test_the_arm_in_mcap_is_what_foxglove_s_published_schemas_ask_for(source: Path) -> None:
    drawn: dict[str, list[dict[str, Any]]] = defaultdict(list)
    with exported(source, "mcap").open("rb") as file:
        for schema, channel, message in make_reader(file).iter_messages(["/arm", "/pose/tip", "/pose/reference"]):
            assert schema
            assert schema.name == f"foxglove.{'SceneUpdate' if channel.topic == '/arm' else 'PoseInFrame'}"
            text = json.loads(message.data)
            if len(drawn[channel.topic]) < 5:
                jsonschema_rs.validate(json.loads(schema.data), text)
            at = text["timestamp"] if "pose" in text else text["entities"][0]["timestamp"]
            assert at["sec"] * 10**9 + at["nsec"] == message.log_time
            drawn[channel.topic].append(text)
    rows = read_rows(source)
    assert {topic: len(found) for topic, found in drawn.items()} == {
        topic: len(rows["backbone"]) for topic in ("/arm", "/pose/tip", "/pose/reference")
    }
    names = {entity["id"]: entity for entity in drawn["/arm"][7]["entities"]}
    assert set(names) == {"observer", "twin", "reference", "measured tip"}
    for name, field in (("observer", "backbone"), ("twin", "twin_backbone")):
        (line,) = names[name]["lines"]
        points = [[point["x"], point["y"]] for point in line["points"]]
        np.testing.assert_allclose(points, rows[field][7], atol=1e-6)
    at = int(np.flatnonzero(rows["tick"] == rows["backbone_tick"][7])[0])
    for name, field in (("reference", "p_ref"), ("measured tip", "p_meas")):
        where = names[name]["spheres"][0]["pose"]["position"]
        np.testing.assert_allclose([where["x"], where["y"]], rows[field][at], atol=1e-6)
    pose, last = drawn["/pose/tip"][7]["pose"], rows["backbone"][7][-2:].astype(float)
    turn = 2.0 * np.arctan2(pose["orientation"]["z"], pose["orientation"]["w"])
    along = np.diff(last, axis=0)[0]
    np.testing.assert_allclose([np.cos(turn), np.sin(turn)], along / np.linalg.norm(along), atol=1e-9)


def test_a_window_between_two_backbones_has_no_arm_in_it(source: Path) -> None:
    with exported(source, "mcap", start=1.001, stop=1.004).open("rb") as file:
        reader = make_reader(file)
        assert "/arm" in {channel.topic for channel in reader.get_summary().channels.values()}  # type: ignore[union-attr]
        topics = [channel.topic for _, channel, _ in reader.iter_messages()]
    assert topics.count("/tip") == 3 and not {"/arm", "/pose/tip", "/backbone"} & set(topics)


def test_without_whole_backbones_there_is_no_arm(source: Path) -> None:
    with exported(source, "mcap", "p_ref", "backbone_20_x").open("rb") as file:
        channels = make_reader(file).get_summary().channels.values()  # type: ignore[union-attr]
        assert {channel.topic for channel in channels} == {"/tip", "/backbone"}


def origin_in(file: Path) -> Origin:
    match file.suffix:
        case ".mcap":
            with file.open("rb") as opened:
                (found,) = [one for one in make_reader(opened).iter_metadata() if one.name == "origin"]
            return Origin.model_validate_json(found.metadata["json"])
        case ".parquet":
            return Origin.model_validate_json(pyarrow.parquet.read_schema(file).metadata[b"origin"])
        case ".mat":
            return Origin.model_validate_json(loadmat(file, simplify_cells=True)["tendril"]["origin"])
    lines = [line.removeprefix("# ") for line in file.read_text().splitlines() if line.startswith("# ")]
    return Origin.model_validate({name: json.loads(text) for name, text in (line.split(": ", 1) for line in lines)})


@pytest.mark.parametrize("kind", ["csv", "parquet", "mat", "mcap"])
def test_every_export_says_where_it_comes_from(source: Path, kind: Format) -> None:
    target = source.with_name(f"origin.{kind}")
    export(source, target, kind, Choice(("mode", "u")), By("tendril recordings export source", comments=True))
    found, info = origin_in(target), rig_info()
    assert (found.version, found.commit) == (our_version(), commit())
    assert found.command == "tendril recordings export source"
    assert (found.actuators, found.controller) == ((info.parameters.actuator,), info.parameters.controller)
    assert (found.plant, found.seeds) == (info.parameters.twin, (info.parameters.twin.seed,))
    assert found.settings == Settings() and found.recorded_by == f"Tendril {info.version}"
    assert found.files == {"source.rrd": hashlib.sha256(source.read_bytes()).hexdigest()}
    assert found.codes["mode"]["TRACK"] == Mode.TRACK and found.codes["sensed"]["rod_10"] == 512


def test_codes_have_their_names_in_the_files_themselves(source: Path) -> None:
    field = pyarrow.parquet.read_schema(exported(source, "parquet", "mode", "sensed")).field("mode")
    assert json.loads(field.metadata[b"codes"])["E_STOP"] == Mode.E_STOP
    codes = loadmat(exported(source, "mat", "mode"), simplify_cells=True)["tendril"]["codes"]
    assert codes["cause"]["OSCILLATION"] == 21 and codes["law"]["FF_PI"] == 4
    with exported(source, "mcap", "mode").open("rb") as file:
        schemas = make_reader(file).get_summary().schemas.values()  # type: ignore[union-attr]
        (state,) = [json.loads(one.data) for one in schemas]
    assert state["properties"]["mode"]["description"].startswith("[1] 0 VENTED, 1 HOLD")


def test_a_csv_file_has_comments_only_where_they_are_asked_for(source: Path) -> None:
    assert exported(source, "csv", "mode").read_text().startswith("t [s],mode\n")
    target = source.with_name("commented.csv")
    export(source, target, "csv", Choice(("mode",)), By(comments=True))
    pd.testing.assert_frame_equal(pd.read_csv(target, comment="#"), pd.read_csv(exported(source, "csv", "mode")))


def test_reruns_reader_of_mcap_finds_the_topics_messages_and_times(source: Path) -> None:
    info = McapReader(exported(source, "mcap")).info()
    counts = {channel.topic: channel.message_count for channel in info.channels}
    assert (counts["/tip"], counts["/pressures"], counts["/backbone"]) == (COUNT, COUNT, COUNT // 10)
    assert sum(counts.values()) == info.message_count and info.summary_source == "embedded"
    assert info.message_start_time_ns == WALL_NS
    assert {channel.schema.encoding for channel in info.channels if channel.schema} == {"jsonschema"}


def test_a_window_holds_the_rows_between_its_ends_and_slow_values_at_their_own_rows(source: Path) -> None:
    whole = pd.read_csv(exported(source, "csv", "tick", "markers"))
    part = pd.read_csv(exported(source, "csv", "tick", "markers", start=1.0, stop=2.0))
    wanted = whole[(whole["t [s]"] >= 1.0) & (whole["t [s]"] <= 2.0)].reset_index(drop=True)
    assert 990 < len(wanted) < 1010
    pd.testing.assert_frame_equal(part, wanted)


@pytest.mark.process
@pytest.mark.parametrize("profile", ["full", "standard"])
@pytest.mark.parametrize("end", ["closed", "compacted", "running"])
def test_small_pieces_come_to_what_is_read_at_once(tmp_path: Path, profile: Profile, end: str) -> None:
    source = tmp_path / "source.rrd"
    file = RrdFile(source, About("source", "source", rig_info(), Settings(), profile))
    for batch in batches(telemetry_rows(COUNT), 130):
        file.write(batch)
    file.flush()
    if end != "running":
        file.close()
    if end == "compacted":
        tool.run("rrd", "optimize", str(source), "-o", str(source), timeout=60)
    rows, pieces = read_rows(source), [*RowReader(source).pieces(Choice(), most=700)]
    assert [len(piece.t) for piece in pieces] == [700, 700, 700, 700, 410]
    np.testing.assert_array_equal(joined(pieces).t_ns, rows["t_ns"] - rows["t_ns"][0])
    for column in joined(pieces).columns:
        field, slow = column.signal.field, rows.get(f"{column.signal.field}_tick")
        np.testing.assert_array_equal(
            column.values, rows[field][(slice(None), *column.signal.index)], column.signal.name
        )
        assert column.values.dtype == rows[field].dtype
        assert (slow is None) == (column.at is None)
        if column.at is not None:
            np.testing.assert_array_equal(rows["tick"][column.at], slow)
    if end == "running":
        file.close()


@pytest.mark.parametrize("profile", ["full", "standard"])
def test_fields_are_read_alone_as_they_are_with_all_others(tmp_path: Path, profile: Profile) -> None:
    source = tmp_path / "source.rrd"
    file = RrdFile(source, About("source", "source", rig_info(), Settings(), profile))
    file.write(telemetry_rows(COUNT))
    file.close()
    whole, some = read_rows(source), read_rows(source, ("p_meas", "backbone", "energy"))
    assert {"tick", "t_ns", "p_meas", "backbone", "backbone_tick", "energy"} <= set(some)
    assert not {"markers", "twin_backbone"} & set(some)
    for name, values in some.items():
        np.testing.assert_array_equal(values, whole[name], name)


def test_rrd_is_the_file_itself(source: Path) -> None:
    assert exported(source, "rrd").read_bytes() == source.read_bytes()
    with pytest.raises(ParameterError, match="rrd is the whole file"):
        exported(source, "rrd", "p_meas")


@pytest.mark.parametrize(
    ("choice", "told"),
    [
        (Choice(("p_maes",)), "signals = p_maes: this recording has no such signal"),
        (Choice((), 7.0), r"from = 7 s is outside the recording's \[0, 3.2"),
        (Choice((), -1.0), "from = -1 s is outside"),
        (Choice((), float("nan")), "from = nan s is outside"),
        (Choice((), 2.0, 1.0), "to = 1 s is before from = 2 s"),
        (Choice((), 2.0, float("nan")), "to = nan s is before"),
        (Choice((), 2.0001, 2.0002), "has no row there"),
    ],
)
def test_what_a_recording_does_not_have_is_named(source: Path, choice: Choice, told: str) -> None:
    with pytest.raises(ParameterError, match=told):
        RowReader(source).table(choice)


def test_a_rig_without_a_twin_offers_no_twin(record: Record, tmp_path: Path) -> None:
    rows = telemetry_rows(100)
    rows["twin_backbone"] = np.nan
    source = tmp_path / f"{record(rows).id}.rrd"
    with pytest.raises(ParameterError, match="twin_backbone: this recording has no such signal"):
        RowReader(source).table(Choice(("twin_backbone",)))
    assert len(RowReader(source).table(Choice(("backbone",))).columns) == 42


@pytest.mark.parametrize("twin", [True, False])
def test_what_is_offered_can_be_had_whole_by_the_name_of_its_field(record: Record, twin: bool) -> None:
    found = offered(record(telemetry_rows(10)).model_copy(update={"twin": twin}))
    names = {field: [one.name for one in found if one.field == field] for field in {one.field for one in found}}
    assert ("twin_backbone" in names) == twin
    assert (names["u"], names["p_ref"], names["mode"]) == (["u_1", "u_2"], ["p_ref_x", "p_ref_y"], ["mode"])
    assert len(names["pressure_meas"]) == 4 and names["markers"][-1] == "markers_10_y"
    assert {one.unit for one in found if one.field == "power"} == {"W"}


def test_ticks_that_begin_again_keep_their_own_markers(record: Record, tmp_path: Path) -> None:
    before, after = telemetry_rows(95), telemetry_rows(60, first=10)
    after["t_ns"] += 10**9
    after["markers"] += 0.001
    source = tmp_path / f"{record(np.concatenate([before, after])).id}.rrd"
    (column,) = RowReader(source).table(Choice(("markers_10_x",))).columns
    assert column.at is not None and column.at.tolist() == [*range(0, 95, 10), *range(95, 155, 10)]


@pytest.mark.parametrize("what", ["p_meas", "p_ref", "marker"])
def test_a_recorded_path_can_be_tracked_again(source: Path, what: Any) -> None:
    file, rows = source.with_suffix(".csv"), telemetry_rows(COUNT)
    write_path(source, file, Wanted(what, rod=10, start=0.5))
    samples, (t, p) = read_samples(file), tip_path(source, Wanted(what, rod=10, start=0.5))
    np.testing.assert_allclose(samples.t, t, atol=1e-9)
    np.testing.assert_allclose(samples.p, p, atol=1e-9)
    field = "p_ref" if what == "p_ref" else "p_meas"
    np.testing.assert_array_equal(p[-1], rows[field][-1] if what != "marker" else rows[field][COUNT - 10])
    assert t[0] == 0.0


def test_a_marker_that_was_never_seen_is_no_path(source: Path) -> None:
    with pytest.raises(ParameterError, match="what = markers_4: it was seen at 0 times"):
        tip_path(source, Wanted("marker", rod=4))
