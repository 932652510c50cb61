"""NatNet as a driver: connection, version, clock and names, and every frame as a `Sample`."""

import ipaddress
import struct
import time
from typing import Annotated, Literal

from pydantic import Field as Bounds
from pydantic import field_validator

from controller.drivers.capture.natnet.definitions import MODEL_REQUESTS, Names, ServerInfo, parse_definitions
from controller.drivers.capture.natnet.link import Link, connect_request
from controller.drivers.capture.natnet.packets import (
    CONNECT,
    DISCONNECT,
    DISCONNECT_BY_TIMEOUT,
    ECHO_REQUEST,
    ECHO_RESPONSE,
    FRAME,
    KEEP_ALIVE,
    MESSAGE_STRING,
    MODEL_DEF,
    MODELS_CHANGED,
    REQUEST,
    REQUEST_MODEL_DEF,
    RESPONSE,
    SERVER_INFO,
    UNRECOGNIZED_REQUEST,
    VERSIONS,
    Frame,
    Malformed,
    Version,
    parse_frame,
)
from controller.drivers.capture.natnet.points import Naming, Wanted
from controller.drivers.clocks import OneWayClock, TwoWayClock
from controller.drivers.device import CaptureDevice, DeviceError, Sample
from controller.errors import spelled
from controller.schema.layout import Model

Host = Annotated[str, spelled(r"^[A-Za-z0-9.-]{1,253}$", "a host name or IPv4 address")]
LocalHost = Annotated[str, spelled(r"^[0-9.]{0,15}$", "an IPv4 address of this machine, or nothing for any")]
Port = Annotated[int, Bounds(ge=1, le=65535)]

BEAT = 0.5
"""Between questions for the server's clock, and between signs of life to it [s]."""
FIRST_ECHOES = 12
SILENCE = 2.0
"""A server that says nothing for so long is lost [s]."""
OLDEST = 10_000_000_000
"""No frame is older when it comes [ns]."""
_ECHO = struct.Struct("<QQ")
_STAMP = struct.Struct("<Q")


class NatNetOptions(Model):
    """Where Motive is and what it is to send."""

    server: Host
    """Address of the machine with Motive."""
    local_address: LocalHost = ""
    """Address of this machine's interface to the cameras' network; nothing: the system chooses."""
    command_port: Port = 1510
    data_port: Annotated[int, Bounds(ge=0, le=65535)] = 0
    """0: the one that the server names, 1511 as a rule."""
    multicast_address: LocalHost = ""
    """Group to which Motive sends, 239.255.42.99 as a rule; nothing: unicast."""
    version: Literal["auto", "3.0", "3.1", "4.0", "4.1"] = "auto"
    """Of the frames. A server from 4.0 on sends what is asked for, by unicast."""
    points: Wanted = "labelled"

    @field_validator("multicast_address", "local_address")
    @classmethod
    def _address(cls, text: str) -> str:
        if text:
            try:
                ipaddress.IPv4Address(text)
            except ValueError as error:
                raise ValueError("is no IPv4 address") from error
        return text

    @field_validator("multicast_address")
    @classmethod
    def _group(cls, text: str) -> str:
        if text and not ipaddress.IPv4Address(text).is_multicast:
            raise ValueError("is outside [224.0.0.0, 239.255.255.255]; leave it out for unicast")
        return text


class NatNet(CaptureDevice[NatNetOptions]):
    """Motion capture by OptiTrack's Motive, or by what speaks as it does."""

    Options = NatNetOptions
    capabilities = ("labelled markers", "unlabelled markers", "rigid bodies", "unicast", "multicast", "two-way clock")

    def __init__(self, options: NatNetOptions) -> None:
        """Touches nothing."""
        super().__init__(options)
        self.version: Version | None = None
        """Of the frames, once connected."""
        self._link: Link | None = None
        self._info = ServerInfo("", (0, 0), 0, 0, "")
        self._naming = Naming(Names())
        self._bad = 0
        self._reset(0.0)

    def _reset(self, now: float) -> None:
        self.clock = "one-way"
        self._two_way, self._one_way = TwoWayClock(), OneWayClock()
        self._asked: dict[int, None] = {}
        self._last = -1
        self._misread = 0
        self._stale_names = False
        self._heard = self._framed = now
        self._next_beat = 0.0

    @property
    def name(self) -> str:
        """As "NatNet 4.1 at 192.168.1.10:1510, unicast"."""
        told = self.version or (self.options.version if self.options.version != "auto" else "")
        version = ".".join(map(str, told)) if isinstance(told, tuple) else told
        way = f"multicast {self.options.multicast_address}" if self.options.multicast_address else "unicast"
        return f"NatNet {version} at {self.options.server}:{self.options.command_port}, {way}".replace("  ", " ")

    @property
    def rejected(self) -> int:  # type: ignore[override]  # counted in two places
        """Datagrams that were no frame of the server's."""
        link = self._link  # another thread asks
        return self._bad + (link.rejected if link else 0)

    def open(self) -> None:
        """Connect, agree on a version, learn names and clock; raises DeviceError or OSError."""
        self.close()
        o = self.options
        self._link = link = Link(o.server, o.command_port, o.local_address)
        try:
            wanted = _version(o.version)
            self._info = link.connect(wanted or VERSIONS[-1])
            self.version = self._agreed(link, self._info, wanted)
            link.listen(o.data_port or self._info.data_port, o.multicast_address)
            self._naming = Naming(self._definitions(link))
            self._reset(time.monotonic())
            self._first_echoes(link)
        except BaseException:
            self.close()
            raise

    def close(self) -> None:
        """Take leave of the server and close the sockets."""
        if self._link is not None:
            link, self._link = self._link, None
            self._bad += link.rejected
            try:
                link.send(DISCONNECT)
            except OSError:
                pass
            link.close()

    def read(self, timeout: float) -> Sample | None:
        """The next frame within `timeout` [s]; DeviceError once the server is silent or has ended the connection."""
        deadline = time.monotonic() + timeout
        while True:
            link = self._link  # another thread may close it
            if link is None:
                raise DeviceError(f"{self.name} is not open")
            now = time.monotonic()
            self._beat(link, now)
            got = link.receive(min(deadline, self._next_beat) - now)
            if got is not None and (sample := self._take(*got)) is not None:
                return sample
            if time.monotonic() >= deadline:
                return None

    def _agreed(self, link: Link, info: ServerInfo, wanted: Version | None) -> Version:
        """The version of the frames that will come; raises DeviceError where we cannot read them."""
        group = self.options.multicast_address
        if info.version < VERSIONS[0]:
            raise DeviceError(f"{info.application} speaks NatNet {_text(info.version)}; needed is 3.0 or later")
        if info.multicast and not group:
            raise DeviceError(
                f"Motive sends by multicast: set multicast_address = {info.multicast}, or unicast in Motive"
            )
        if group and info.multicast != group:
            told = f"multicast to {info.multicast}" if info.multicast else "unicast"
            raise DeviceError(f"multicast_address = {group}, but Motive sends by {told}")
        asked = wanted or min(info.version, VERSIONS[-1])
        if asked == info.version:
            return asked
        if group or info.version < (4, 0) or asked > info.version:
            raise DeviceError(
                f"Motive sends NatNet {_text(info.version)}, not {_text(asked)}: it sends a version below its own from "
                "4.0 on, and only by unicast"
            )
        if link.ask(REQUEST, (_bitstream(asked),), lambda kind, payload: _obeyed(kind, payload, asked)) is None:
            raise DeviceError(f"Motive does not send NatNet {_text(asked)} when asked to")
        return asked

    def _definitions(self, link: Link) -> Names:
        """Names, or none where the server tells none: points go without."""
        version = self.version or VERSIONS[0]
        found = link.ask(
            REQUEST_MODEL_DEF,
            MODEL_REQUESTS,
            lambda kind, payload: parse_definitions(payload, version) if kind == MODEL_DEF else None,
        )
        return found or Names()

    def _first_echoes(self, link: Link) -> None:
        """A dozen answers give the clock at once; a server that leaves three questions unanswered has none to give."""
        unanswered = 0
        for _ in range(FIRST_ECHOES):
            self._ask_clock(link)
            deadline = time.monotonic() + 0.05
            while self._asked and (left := deadline - time.monotonic()) > 0:
                if (got := link.receive(left)) is not None and got[0] == ECHO_RESPONSE:
                    self._answered(got[1], got[2])
            unanswered += bool(self._asked)
            self._asked.clear()
            if unanswered >= 3 and not self._two_way.known:
                return

    def _ask_clock(self, link: Link) -> None:
        stamp = time.monotonic_ns()
        self._asked[stamp] = None
        while len(self._asked) > 8:
            del self._asked[next(iter(self._asked))]
        link.send(ECHO_REQUEST, _STAMP.pack(stamp))

    def _answered(self, payload: bytes, arrived: int) -> None:
        if len(payload) < _ECHO.size:
            raise Malformed("an answer without a time")
        stamp, ticks = _ECHO.unpack_from(payload)
        if stamp not in self._asked:
            raise Malformed("an answer to no question")
        del self._asked[stamp]
        self._two_way.answered(stamp, self._nanoseconds(ticks), arrived)
        self.clock, self.clock_offset = "two-way", self._two_way.offset_ns * 1e-9

    def _nanoseconds(self, ticks: int) -> int:
        return ticks * 1_000_000_000 // self._info.frequency

    def _beat(self, link: Link, now: float) -> None:
        """What is due twice a second; raises DeviceError where the server is gone."""
        if now < self._next_beat:
            return
        if now - self._heard > SILENCE:
            raise DeviceError(f"nothing came from {self.name} for {SILENCE:g} s")
        if now - self._framed > SILENCE and self._misread:
            raise DeviceError(f"what {self.name} sends are no frames of that version")
        self._next_beat = now + BEAT
        self._ask_clock(link)
        if not self.options.multicast_address:
            link.send(KEEP_ALIVE)
        if now - self._framed > BEAT:  # it may have begun again, and not know us
            version = self.version or VERSIONS[-1]
            link.send(CONNECT, connect_request(version))
            if version != self._info.version:
                link.send(REQUEST, _bitstream(version))
        if self._stale_names:
            link.send(REQUEST_MODEL_DEF, MODEL_REQUESTS[int(now / BEAT) % len(MODEL_REQUESTS)])

    def _take(self, kind: int, payload: bytes, arrived: int) -> Sample | None:
        """What a message means; a sample where it is a frame that is new."""
        self._heard = time.monotonic()
        try:
            if kind == FRAME:
                self._misread += 1  # until it proves to be one
                return self._sample(parse_frame(payload, self.version or VERSIONS[0]), arrived)
            if kind == ECHO_RESPONSE:
                self._answered(payload, arrived)
            elif kind == MODEL_DEF:
                self._naming = Naming(parse_definitions(payload, self.version or VERSIONS[0]))
                self._stale_names = False
            elif kind in (DISCONNECT, DISCONNECT_BY_TIMEOUT):
                raise DeviceError(f"{self.name} ended the connection")
            elif kind not in (SERVER_INFO, RESPONSE, MESSAGE_STRING, UNRECOGNIZED_REQUEST):
                raise Malformed(f"message {kind}")
        except Malformed:
            self._bad += 1
        return None

    def _sample(self, frame: Frame, arrived: int) -> Sample | None:
        self._stale_names |= bool(frame.flags & MODELS_CHANGED)
        points, labels, quality = self._naming.points(frame, self.options.points)
        captured = self._captured(frame, arrived)
        self._framed, self._misread = time.monotonic(), 0
        if frame.number == self._last:
            return None  # Motive repeats a frame while its playback stands, and some servers send to both sockets
        self._last = frame.number
        return Sample(captured, points, labels, quality, frame.number)

    def _captured(self, frame: Frame, arrived: int) -> int:
        """Middle of the exposure on our clock [ns]; raises Malformed."""
        if frame.exposed and self._two_way.known:
            captured = self._two_way.ours(self._nanoseconds(frame.exposed))
            if not arrived - OLDEST < captured < arrived + OLDEST:
                raise Malformed("a time of capture that cannot be")
            return min(captured, arrived)
        if not 0 <= frame.timestamp < 1e9:
            raise Malformed("a time that cannot be")
        stamp = self._nanoseconds(frame.exposed) if frame.exposed else round(frame.timestamp * 1e9)
        captured = self._one_way.heard(stamp, arrived)
        self.clock, self.clock_offset = "one-way", self._one_way.offset_ns(stamp) * 1e-9
        return captured


def _version(text: str) -> Version | None:
    if text == "auto":
        return None
    major, _, minor = text.partition(".")
    return int(major), int(minor)


def _text(version: Version) -> str:
    return f"{version[0]}.{version[1]}"


def _bitstream(version: Version) -> bytes:
    """The command that asks for frames of `version`."""
    return f"Bitstream,{_text(version)}".encode() + b"\0"


def _obeyed(kind: int, payload: bytes, asked: Version) -> bool | None:
    """True where the server says that it sends `asked` now: by a 0, or by naming the version."""
    if kind == UNRECOGNIZED_REQUEST:
        return None
    named = payload.partition(b"\0")[0] == f"Bitstream,{_text(asked)}".encode()
    return True if kind == RESPONSE and (named or payload == bytes(4)) else None
