"""MCAP files written many messages at a time, beside those of the mcap package, which writes them one by one."""

import io
import json
import struct
import zlib
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Channel, Chunk, ChunkIndex, McapRecord, Message, MessageIndex, MetadataIndex, Schema
from mcap.stream_reader import StreamReader
from mcap.summary import Summary
from mcap.writer import Writer
from rerun.chunk import McapReader

from recordings.exporting import mcap_batches
from recordings.exporting.json_texts import Messages
from recordings.exporting.mcap_batches import BatchWriter
from recordings.exporting.mcap_file import write_mcap
from recordings.exporting.table import table_of
from tests.recordings.synthetic import telemetry_rows

Said = tuple[int, int, str]
"""A message: its channel, its log time [ns], its text."""
SCHEMAS = {"/a": ("of a", b"{}"), "/b": ("of b", b'{"type": "object"}'), "/never": ("of none", b"{}")}
TEXTS = ('{"x":1}', '{"y":"\u00e4\u4e2d"}', "", '{"z":' + "7" * 500 + "}")
WORDS = {"version": "1", "word": "\u00fc"}
ROWS = 5_000


def turns(count: int) -> Iterator[list[Said]]:
    """Messages of the channels 1 and 2 in turn, of the first often, of the second at times that fall, too."""
    for turn in range(count):
        yield [(1, 10**18 + 1000 * turn + place, TEXTS[(turn + place) % 4]) for place in range(turn % 7)]
        yield [(2, 10**18 + 1000 * (turn - turn % 3) - place, TEXTS[place % 4]) for place in range(turn % 3)]


def at_once(said: Iterator[list[Said]]) -> bytes:
    """A file of our own, each turn being one batch."""
    file = io.BytesIO()
    with ThreadPoolExecutor(1) as beside:
        writer = BatchWriter(file, "us", beside)
        writer.add_metadata("origin", WORDS)
        for topic, schema in SCHEMAS.items():
            writer.add_channel(topic, schema, {"of": topic})
        for turn in said:
            at = np.array([one[1] for one in turn], np.int64)
            writer.add_messages(
                turn[0][0] if turn else 1, Messages(at, pa.array([one[2] for one in turn], pa.string()))
            )
        writer.finish()
    return file.getvalue()


def one_by_one(said: Iterator[list[Said]]) -> bytes:
    """The same file by the mcap package."""
    file = io.BytesIO()
    writer = Writer(file, chunk_size=mcap_batches.CHUNK_BYTES)
    writer.start(library="us")
    writer.add_metadata("origin", WORDS)
    for topic, (name, text) in SCHEMAS.items():
        writer.register_channel(topic, "json", writer.register_schema(name, "jsonschema", text), {"of": topic})
    for channel, at, text in (one for turn in said for one in turn):
        writer.add_message(channel, at, text.encode(), at)
    writer.finish()  # type: ignore[no-untyped-call]
    return file.getvalue()


def records(file: bytes) -> list[McapRecord]:
    """All of a file but what depends on how well it is compressed, which two versions of zstd may do differently."""
    found = []
    for record in StreamReader(io.BytesIO(file), emit_chunks=True, validate_crcs=True).records:
        match record:
            case Chunk():
                found.append(replace(record, data=opened(record)))
            case ChunkIndex():
                channels = dict.fromkeys(record.message_index_offsets, 0)
                free = {"chunk_length": 0, "chunk_start_offset": 0, "compressed_size": 0}
                found.append(replace(record, **free, message_index_offsets=channels))
            case _ if type(record).__name__ not in ("SummaryOffset", "Footer"):
                found.append(record)
    return found


def opened(chunk: Chunk) -> bytes:
    data = zstandard.decompress(chunk.data, chunk.uncompressed_size)
    assert (zlib.crc32(data), len(data)) == (chunk.uncompressed_crc, chunk.uncompressed_size)
    return data


def read(file: bytes, start: int) -> ReadDataStream:
    """A file from `start` on."""
    return ReadDataStream(io.BytesIO(file[start:]))


def summary_of(file: bytes) -> Summary:
    summary = make_reader(io.BytesIO(file)).get_summary()
    assert summary is not None
    return summary


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """Rows as we export them, in several chunks."""
    target = tmp_path_factory.mktemp("mcap") / "rows.mcap"
    write_mcap([table_of(telemetry_rows(ROWS))], target, None)
    return target.read_bytes()


@pytest.mark.parametrize("count", [0, 1, 2, 40])
def test_single_messages_come_to_the_very_records_of_the_mcap_package(
    count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcap_batches, "CHUNK_BYTES", 2_000)
    alone = [[one] for turn in turns(count) for one in turn]
    ours, theirs = records(at_once(iter(alone))), records(one_by_one(iter(alone)))
    assert ours == theirs
    assert count < 40 or sum(isinstance(record, Chunk) for record in ours) >= 10


@pytest.mark.parametrize("chunk", [1, 3_000, 1 << 20])
def test_batches_come_to_the_messages_of_the_mcap_package_in_its_order(
    chunk: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mcap_batches, "CHUNK_BYTES", chunk)
    ours, theirs = at_once(turns(60)), one_by_one(turns(60))
    kinds = Schema, Channel, Message
    found, wanted = (
        [record for record in StreamReader(io.BytesIO(file), validate_crcs=True).records if isinstance(record, kinds)]
        for file in (ours, theirs)
    )
    assert found == wanted and sum(isinstance(record, Message) for record in found) == 234
    statistics = [summary_of(file).statistics for file in (ours, theirs)]
    assert replace(statistics[0], chunk_count=0) == replace(statistics[1], chunk_count=0)  # type: ignore[type-var]


@pytest.mark.keyed()
def test_an_index_leads_to_every_message_and_to_nothing_else(exported: bytes) -> None:
    summary, count = summary_of(exported), 0
    assert len(summary.chunk_indexes) > 2
    for index in summary.chunk_indexes:
        chunk = read(exported, index.chunk_start_offset)
        assert (chunk.read1(), chunk.read8()) == (Opcode.CHUNK, index.chunk_length - 9)
        data, times = opened(Chunk.read(chunk)), []
        end = index.chunk_start_offset + index.chunk_length + index.message_index_length
        assert exported[end] in (Opcode.CHUNK, Opcode.DATA_END)
        for channel, offset in index.message_index_offsets.items():
            stream = read(exported, offset)
            assert stream.read1() == Opcode.MESSAGE_INDEX and offset + 9 + stream.read8() <= end
            for at, place in MessageIndex.read(stream).records:
                opcode, _, *message = struct.unpack_from("<BQHIQQ", data, place)
                assert (opcode, message) == (Opcode.MESSAGE, [channel, 0, at, at])
                times.append(at)
        assert (min(times), max(times)) == (index.message_start_time, index.message_end_time)
        count += len(times)
    assert summary.statistics and count == summary.statistics.message_count == 6 * ROWS + 6 * ROWS


@pytest.mark.keyed()
def test_topics_and_times_find_what_a_reader_without_the_index_finds(exported: bytes) -> None:
    whole = [*NonSeekingReader(io.BytesIO(exported), validate_crcs=True).iter_messages(log_time_order=False)]
    first, reader = whole[0][2].log_time, make_reader(io.BytesIO(exported), validate_crcs=True)
    assert [*reader.iter_messages(log_time_order=False)] == whole
    start, end, topics = first + 10**9, first + 4 * 10**9, ["/state", "/arm"]
    part = {"starting_at": start, "ending_before": end, "topics": topics}
    chosen = [one for one in whole if start <= one[2].log_time < end and one[1].topic in topics]
    assert len(chosen) > 5_900 and {one[1].topic for one in chosen} == {*topics}
    assert [*reader.iter_messages(**part, log_time_order=False)] == chosen  # type: ignore[arg-type]
    rising = sorted(chosen, key=lambda one: one[2].log_time)
    assert [*reader.iter_messages(**part)] == rising  # type: ignore[arg-type]
    falling = [one[2].log_time for one in reader.iter_messages(**part, reverse=True)]  # type: ignore[arg-type]
    assert falling == [one[2].log_time for one in reversed(rising)]


def test_the_summary_has_its_checksum_and_offsets_to_each_kind_of_record(exported: bytes) -> None:
    start, offsets, crc = struct.unpack("<QQI", exported[-28:-8])
    assert zlib.crc32(exported[start:-12]) == crc and exported[-8:] == exported[:8] == b"\x89MCAP0\r\n"
    places = [struct.unpack("<BQBQQ", exported[at : at + 26]) for at in range(offsets, len(exported) - 37, 26)]
    assert {(opcode, length) for opcode, length, *_ in places} == {(Opcode.SUMMARY_OFFSET, 17)}
    kinds = [Opcode.SCHEMA, Opcode.CHANNEL, Opcode.STATISTICS, Opcode.CHUNK_INDEX]
    assert [place[2] for place in places] == kinds
    assert [place[3] for place in places] + [offsets] == [start, *(place[3] + place[4] for place in places)]
    assert [exported[place[3]] for place in places] == kinds


def test_metadata_are_found_by_their_index() -> None:
    file = at_once(turns(3))
    (index,) = summary_of(file).metadata_indexes
    assert isinstance(index, MetadataIndex) and index.name == "origin"
    assert file[index.offset] == Opcode.METADATA
    assert file[index.offset + index.length] == Opcode.CHUNK
    (found,) = make_reader(io.BytesIO(file)).iter_metadata()
    assert found.metadata == WORDS


def test_rerun_reads_what_batches_are_written_to(tmp_path: Path) -> None:
    target = tmp_path / "batches.mcap"
    target.write_bytes(at_once(turns(60)))
    info = McapReader(target).info()
    assert {channel.topic: channel.message_count for channel in info.channels} == {"/a": 174, "/b": 60, "/never": 0}
    assert info.summary_source == "embedded"


def test_what_is_not_known_is_not_drawn_in_foxglove(tmp_path: Path) -> None:
    rows: Any = telemetry_rows(5)
    rows["backbone"][1, 3] = np.nan
    rows["p_ref"][2] = np.inf
    for field in ("backbone", "twin_backbone", "p_ref", "p_meas"):
        rows[field][3] = np.nan
    target = tmp_path / "drawn.mcap"
    write_mcap([table_of(rows)], target, None)
    with target.open("rb") as file:
        reader = make_reader(file)
        said = {
            topic: [(message.log_time, message.data.decode()) for *_, message in reader.iter_messages([topic])]
            for topic in ("/arm", "/pose/tip", "/pose/reference")
        }
    at = (rows["t_ns"] - rows["t_ns"][0]).tolist()
    assert [time for time, _ in said["/pose/tip"]] == [at[0], at[1], at[2], at[4]]
    assert [time for time, _ in said["/pose/reference"]] == [at[0], at[1], at[4]]
    assert [time for time, _ in said["/arm"]] == at and said["/arm"][3][1] == '{"deletions": [], "entities": []}'
    names = "observer", "twin", "reference", "measured tip"
    drawn = [[name for name in names if f'"id": "{name}"' in text] for _, text in said["/arm"]]
    assert drawn == [[*names], [*names[1:]], ["observer", "twin", "measured tip"], [], [*names]]
    points = json.loads(said["/arm"][4][1])["entities"][0]["lines"][0]["points"]
    assert [[point["x"], point["y"]] for point in points] == rows["backbone"][4].astype(float).round(6).tolist()


def test_a_full_disk_ends_the_export() -> None:
    with pytest.raises(OSError, match="No space left"):
        write_mcap([table_of(telemetry_rows(ROWS))], Path("/dev/full"), None)
