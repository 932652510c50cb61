"""Markers as a stream of the Lab Streaming Layer: a sample a frame, channels in groups of two or three coordinates."""

import re
import time
from typing import Annotated

import numpy as np
import pylsl
from pydantic import Field as Bounds
from pydantic import model_validator

from controller.arrays import Array
from controller.drivers.device import CaptureDevice, DeviceError, Sample, plausible
from controller.errors import spelled
from controller.schema.layout import Model

Text = Annotated[str, spelled(r"^[^'\"\x00-\x1f]{0,100}$", "at most 100 letters, without quotes")]

RESOLVING = 1.5
"""A stream that is not found within this is not there [s]."""
CHANNELS = 1536
"""Most that are taken."""
OLDEST = 10.0
"""No frame is older when it comes [s]."""
BEAT = 0.5
"""Between looks at the clocks [s]."""
LONGEST_CALL = 0.1
"""Of LSL [s]."""
SILENCE = 5.0
"""Without a sample for so long, the stream is looked for again [s]."""
_AXIS = re.compile(r"(?i)^(.*?)[\s_.:-]*(?:pos(?:ition)?)?[\s_.:-]*[xyz]$")


class LslOptions(Model):
    """Which stream, and what its channels are."""

    stream: Text = ""
    """Its name."""
    type: Text = "MoCap"
    """Its type; used where there is no name."""
    dimensions: Annotated[int, Bounds(ge=2, le=3)] = 3
    """Coordinates of each point."""
    labels: Annotated[tuple[Annotated[str, Bounds(max_length=64)], ...], Bounds(max_length=512)] = ()
    """Names of the points; none: from the stream's description, where it has one."""
    scale: Annotated[float, Bounds(gt=0.0, le=1e3)] = 1.0
    """Metres for each unit of the stream: 0.001 for millimetres."""

    @model_validator(mode="after")
    def _told(self) -> "LslOptions":
        if not (self.stream or self.type):
            raise ValueError("stream or type is needed")
        return self


class LslCapture(CaptureDevice[LslOptions]):
    """Points from a stream of the Lab Streaming Layer."""

    Options = LslOptions
    capabilities = ("labelled markers", "two-way clock")

    def __init__(self, options: LslOptions) -> None:
        """Touches nothing."""
        super().__init__(options)
        self._inlet: pylsl.StreamInlet | None = None
        self._labels: tuple[str, ...] = ()
        self._next_beat = self._heard = 0.0

    @property
    def name(self) -> str:
        """As "LSL stream Rods"."""
        o = self.options
        return f"LSL stream {o.stream}" if o.stream else f"LSL stream of type {o.type}"

    def open(self) -> None:
        """Find the stream and subscribe to it; raises DeviceError."""
        self.close()
        o = self.options
        key, value = ("name", o.stream) if o.stream else ("type", o.type)
        found = pylsl.resolve_byprop(key, value, 1, RESOLVING)
        if not found:
            raise DeviceError(f"no LSL stream of {key} {value} within {RESOLVING:g} s")
        count = found[0].channel_count()
        if not 0 < count <= CHANNELS or count % o.dimensions or found[0].channel_format() == pylsl.cf_string:
            raise DeviceError(f"{self.name} has {count} channels: not points of {o.dimensions} numbers each")
        self._inlet = inlet = pylsl.StreamInlet(found[0], max_buflen=1, max_chunklen=1, recover=False)
        try:
            self._labels = self._names(inlet, count // o.dimensions)
            inlet.open_stream(2.0)
            self._read_clocks(inlet)
            inlet.flush()  # what came while the clocks were compared is old
        except RuntimeError as error:
            self.close()
            raise DeviceError(f"{self.name} was lost: {error}") from error
        self._heard = time.monotonic()

    def close(self) -> None:
        """Leave the stream."""
        inlet, self._inlet = self._inlet, None
        if inlet is not None:
            inlet.close_stream()

    def read(self, timeout: float) -> Sample | None:
        """The next sample within `timeout` [s]; DeviceError once the stream has ended."""
        deadline = time.monotonic() + timeout
        while True:
            inlet = self._inlet  # another thread may close it, which ends no call of LSL's
            if inlet is None:
                raise DeviceError(f"{self.name} is not open")
            try:
                if time.monotonic() >= self._next_beat:
                    self._read_clocks(inlet)
                values, stamp = inlet.pull_sample(min(max(deadline - time.monotonic(), 1e-3), LONGEST_CALL))
            except RuntimeError as error:
                raise DeviceError(f"{self.name} was lost: {error}") from error
            now = time.monotonic()
            if values is not None and stamp is not None:
                self._heard = now
                return self._sample(np.array(values, float), stamp, time.monotonic_ns())
            if now - self._heard > SILENCE:
                raise DeviceError(f"nothing came from {self.name} for {SILENCE:g} s")
            if now >= deadline:
                return None

    def _sample(self, values: Array, stamp: float, arrived: int) -> Sample | None:
        points = values.reshape(-1, self.options.dimensions) * self.options.scale
        captured = round((stamp + self.clock_offset) * 1e9) if np.isfinite(stamp) else 0
        possible = abs(arrived - captured) < OLDEST * 1e9
        if not possible or not plausible(points):
            self.rejected += 1
            return None
        return Sample(min(captured, arrived), points, self._labels)

    def _read_clocks(self, inlet: pylsl.StreamInlet) -> None:
        """LSL asks the sender for its clock by itself; ours is LSL's plus what the two differ by here."""
        self._next_beat = time.monotonic() + BEAT
        correction = inlet.time_correction(2.0)
        before = time.monotonic_ns()
        local = pylsl.local_clock()
        ours = (before + time.monotonic_ns()) * 0.5e-9
        self.clock, self.clock_offset = "two-way", correction + ours - local

    def _names(self, inlet: pylsl.StreamInlet, points: int) -> tuple[str, ...]:
        """Labels of the points: the options', or the first channel's of each group without its axis."""
        told = self.options.labels
        if not told:
            channel = inlet.info(2.0).desc().child("channels").child("channel")
            every: list[str] = []
            while not channel.empty() and len(every) < CHANNELS:
                every.append(channel.child_value("label")[:64])
                channel = channel.next_sibling("channel")
            if len(every) != points * self.options.dimensions:
                return ()
            told = tuple(_without_axis(label) for label in every[:: self.options.dimensions])
        if len(told) != points:
            raise DeviceError(f"labels name {len(told)} points, {self.name} has {points}")
        return told


def _without_axis(label: str) -> str:
    """As "tip" of "tip_x"."""
    found = _AXIS.match(label)
    return found.group(1) if found and found.group(1) else label
