"""An MCAP file of messages that come many at once: their records, and where each begins, are made as arrays.

The mcap package's own Writer takes messages one by one, which is two thirds of the time of an export. What a file or a
chunk has once is serialized by that package.
"""

import zlib
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence
from concurrent.futures import Executor, Future
from typing import Any, BinaryIO

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from mcap.records import (
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)

from controller.arrays import Rows, Values
from recordings.exporting.json_texts import Messages

MAGIC = b"\x89MCAP0\r\n"
"""The first and the last bytes of a file."""
CHUNK_BYTES = 4 << 20
"""Of messages that are compressed together: a player reads so much at once."""
ZSTD_LEVEL = 3
"""The usual one: 1 takes half the time, but files of some signals grow by half."""
HEAD = np.dtype(
    {
        "names": ["opcode", "length", "channel", "sequence", "log_time", "publish_time"],
        "formats": ["u1", "<u8", "<u2", "<u4", "<u8", "<u8"],
    }
)
"""A message's record up to its data."""
UNCOUNTED = 9
"""Bytes of a record that its length does not count: opcode and length."""
ENTRY = np.dtype([("log_time", "<u8"), ("offset", "<u8")])
"""Of a message in the index of its channel; it begins at `offset` in the uncompressed chunk."""

Groups = Sequence[Sequence[McapRecord]]
"""Records by kind."""


class BatchWriter:
    """Writes a file from its beginning until `finish`; `beside` writes a chunk while the next one is made."""

    def __init__(self, file: BinaryIO, library: str, beside: Executor) -> None:
        self._file, self._beside = file, beside
        self._schemas: list[Schema] = []
        self._channels: list[Channel] = []
        self._metadata: list[MetadataIndex] = []
        self._chunks: list[ChunkIndex] = []
        self._counts: Counter[int] = Counter()
        self._open = OpenChunk()
        self._writing: Future[ChunkIndex] | None = None
        file.write(MAGIC + _serialized([Header(profile="", library=library)]))

    def add_metadata(self, name: str, words: dict[str, str]) -> None:
        """A record of words by name."""
        self._await_chunk()
        start, record = self._file.tell(), _serialized([Metadata(name=name, metadata=words)])
        self._file.write(record)
        self._metadata.append(MetadataIndex(offset=start, length=len(record), name=name))

    def add_channel(self, topic: str, schema: tuple[str, bytes], metadata: dict[str, str] | None = None) -> int:
        """The id of a new channel of JSON messages, of which `schema` is name and text of the JSON schema."""
        id, (name, text) = len(self._channels) + 1, schema
        self._schemas.append(Schema(id=id, name=name, encoding="jsonschema", data=text))
        self._channels.append(
            Channel(id=id, topic=topic, message_encoding="json", metadata=metadata or {}, schema_id=id)
        )
        self._open.add_records([self._schemas[-1], self._channels[-1]])
        return id

    def add_messages(self, channel: int, messages: Messages) -> None:
        """Any number of messages of a channel; their times are the log times."""
        if not len(messages.at):
            return
        self._counts[channel] += len(messages.at)
        self._open.add_messages(channel, messages)
        if self._open.size > CHUNK_BYTES:
            self._close_chunk()

    def finish(self) -> None:
        """Write what is left, and the summary."""
        if self._open.entries:
            self._close_chunk()
        self._await_chunk()
        self._file.write(_serialized([DataEnd(data_section_crc=0)]))
        start = self._file.tell()
        groups: Groups = [self._schemas, self._channels, [self._statistics()], self._chunks, self._metadata]
        summary, offsets = _summary(groups, start)
        footer = Footer(summary_start=start, summary_offset_start=start + len(summary), summary_crc=0)
        footer.summary_crc = zlib.crc32(summary + offsets + _serialized([footer])[:-4])
        self._file.write(summary + offsets + _serialized([footer]) + MAGIC)

    def _close_chunk(self) -> None:
        self._await_chunk()
        self._writing = self._beside.submit(self._open.write, self._file)
        self._open = OpenChunk()

    def _await_chunk(self) -> None:
        """Wait for the chunk that is being written: only one may write to the file."""
        if self._writing is not None:
            self._chunks.append(self._writing.result())
            self._writing = None

    def _statistics(self) -> Statistics:
        return Statistics(
            attachment_count=0,
            channel_count=len(self._channels),
            channel_message_counts=self._counts,
            chunk_count=len(self._chunks),
            message_count=self._counts.total(),
            message_end_time=max((chunk.message_end_time for chunk in self._chunks), default=0),
            message_start_time=min((chunk.message_start_time for chunk in self._chunks), default=0),
            metadata_count=len(self._metadata),
            schema_count=len(self._schemas),
        )


class OpenChunk:
    """Records that will be compressed together, and where each channel's messages are among them."""

    def __init__(self) -> None:
        self.size = 0
        """Of all records [bytes]."""
        self.entries: dict[int, list[Rows]] = defaultdict(list)
        self._records: list[Any] = []

    def add_records(self, records: Iterable[McapRecord]) -> None:
        """Schemas and channels."""
        self._add(_serialized(records))

    def add_messages(self, channel: int, messages: Messages) -> None:
        """At least one message of a channel."""
        records, starts = _records(channel, messages)
        entries = np.empty(len(starts), ENTRY)
        entries["log_time"], entries["offset"] = messages.at, self.size + starts
        self.entries[channel].append(entries)
        self._add(records)

    def write(self, file: BinaryIO) -> ChunkIndex:
        """Write the chunk, which has a message, and after it the index of each channel's messages."""
        start, chunk = file.tell(), self._compressed()
        length = file.write(_serialized([chunk]))
        indexes = {channel: _message_index(channel, parts) for channel, parts in self.entries.items()}
        places = np.cumsum([start + length, *map(len, indexes.values())]).tolist()
        file.write(b"".join(indexes.values()))
        return ChunkIndex(
            chunk_length=length,
            chunk_start_offset=start,
            compression=chunk.compression,
            compressed_size=len(chunk.data),
            message_end_time=chunk.message_end_time,
            message_index_length=places[-1] - places[0],
            message_index_offsets=dict(zip(indexes, places, strict=False)),
            message_start_time=chunk.message_start_time,
            uncompressed_size=chunk.uncompressed_size,
        )

    def _add(self, records: Any) -> None:
        self._records.append(records)
        self.size += len(records)

    def _compressed(self) -> Chunk:
        data = b"".join(self._records)
        times = [entries["log_time"] for parts in self.entries.values() for entries in parts]
        return Chunk(
            compression="zstd",
            data=pa.Codec("zstd", compression_level=ZSTD_LEVEL).compress(data, asbytes=True),
            message_end_time=max(int(at.max()) for at in times),
            message_start_time=min(int(at.min()) for at in times),
            uncompressed_crc=zlib.crc32(data),
            uncompressed_size=len(data),
        )


def _records(channel: int, messages: Messages) -> tuple[Any, Values]:
    """The records of n messages, one after another, and where each begins among them (n,) [bytes]."""
    at, texts = messages
    heads = np.zeros(len(at), HEAD)
    heads["opcode"], heads["channel"], heads["log_time"], heads["publish_time"] = Opcode.MESSAGE, channel, at, at
    heads["length"] = HEAD.itemsize - UNCOUNTED + pc.binary_length(texts).to_numpy()
    buffers = [None, pa.py_buffer(heads)]
    packed = pa.FixedSizeBinaryArray.from_buffers(pa.binary(HEAD.itemsize), len(at), buffers)
    records = pc.binary_join_element_wise(packed.cast(pa.binary()), texts.cast(pa.binary()), b"")
    _, offsets, data = records.buffers()
    starts = np.frombuffer(offsets, np.int32, len(at) + 1)
    return data[: starts[-1]], starts[:-1]


def _message_index(channel: int, entries: Sequence[Rows]) -> bytes:
    """The record MessageIndex: the package writes each of its entries alone."""
    data = np.concatenate(entries).tobytes()
    builder = RecordBuilder()
    builder.start_record(Opcode.MESSAGE_INDEX)
    builder.write2(channel)
    builder.write4(len(data))
    builder.write(data)
    builder.finish_record()  # type: ignore[no-untyped-call]
    return bytes(builder.end())  # type: ignore[no-untyped-call]


def _summary(groups: Groups, start: int) -> tuple[bytes, bytes]:
    """The summary of records by kind, which begins at `start` in its file, and the offsets of those of each kind."""
    summary, offsets = b"", []
    for group in filter(None, groups):
        records = _serialized(group)
        offsets.append(SummaryOffset(records[0], start + len(summary), len(records)))
        summary += records
    return summary, _serialized(offsets)


def _serialized(records: Iterable[McapRecord]) -> bytes:
    builder = RecordBuilder()
    for record in records:
        record.write(builder)
    return bytes(builder.end())  # type: ignore[no-untyped-call]
