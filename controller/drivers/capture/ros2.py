"""Markers from a ROS 2 topic, without ROS: zenoh carries it (rmw_zenoh, or the bridge from DDS), rosbags reads it."""

import queue
import time
from typing import Annotated, Any, Literal

import numpy as np
import zenoh
from pydantic import Field as Bounds
from rosbags.serde import SerdeError
from rosbags.typesys import Stores, get_typestore

from controller.arrays import Array
from controller.drivers.clocks import OneWayClock
from controller.drivers.device import POINTS_MAX, CaptureDevice, DeviceError, Sample, plausible
from controller.errors import TendrilError, spelled
from controller.schema.layout import Model

LARGEST = 65535
"""No message is longer [bytes]."""
WAITING = 64
"""Messages that wait to be read; the oldest are dropped."""
CONNECTING_MS = 2000
SILENCE = 5.0
"""Without a message for so long, the topic is subscribed to again [s]."""
Message = Literal["PointStamped", "PoseStamped", "TransformStamped", "PoseArray"]


class Ros2Options(Model):
    """Which topic, and where zenoh is."""

    router: Annotated[str, spelled(r"^[A-Za-z0-9.-]{1,253}:[0-9]{1,5}$", "as 192.168.1.20:7447")]
    """Of rmw_zenoh, or the bridge from DDS."""
    topic: Annotated[str, spelled(r"^[A-Za-z0-9_*/]{1,200}$", "as 0/rods/** or rods, letters, digits and _ * /")]
    """zenoh's key: "DOMAIN/topic/**" with rmw_zenoh, the topic's name with the bridge."""
    message: Message = "PoseStamped"
    """Of geometry_msgs."""
    label: Annotated[str, Bounds(max_length=64)] = ""
    """Name of the point; those of a PoseArray have none."""


class _Refused(TendrilError):
    """A message that is no frame."""


class Ros2Capture(CaptureDevice[Ros2Options]):
    """Positions of one topic, each message a frame."""

    Options = Ros2Options
    capabilities = ("unlabelled markers", "rigid bodies")

    def __init__(self, options: Ros2Options) -> None:
        """Touches nothing."""
        super().__init__(options)
        self._types = get_typestore(Stores.ROS2_HUMBLE)
        self._session: zenoh.Session | None = None
        self._clock = OneWayClock()
        self._came: queue.Queue[tuple[bytes, int] | None] = queue.Queue(WAITING)
        """Messages and their times of arrival [ns]; None wakes a read that waits when the session is closed."""
        self._heard = 0.0

    @property
    def name(self) -> str:
        """As "ROS 2 topic rods by zenoh at 192.168.1.20:7447"."""
        return f"ROS 2 topic {self.options.topic} by zenoh at {self.options.router}"

    def open(self) -> None:
        """Join zenoh and subscribe; raises DeviceError."""
        self.close()
        config = zenoh.Config()
        config.insert_json5("mode", '"client"')
        config.insert_json5("connect/endpoints", f'["tcp/{self.options.router}"]')
        config.insert_json5("connect/timeout_ms", str(CONNECTING_MS))
        config.insert_json5("scouting/multicast/enabled", "false")
        self._clock, self._came, self._heard = OneWayClock(), queue.Queue(WAITING), time.monotonic()
        try:
            self._session = zenoh.open(config)
            self._session.declare_subscriber(self.options.topic, self._put)
        except zenoh.ZError as error:
            self.close()
            raise DeviceError(f"no zenoh at {self.options.router}: {error}") from error

    def close(self) -> None:
        """Leave zenoh."""
        session, self._session = self._session, None
        if session is not None:
            self._leave(None)
            session.close()  # type: ignore[no-untyped-call]

    def read(self, timeout: float) -> Sample | None:
        """The next message within `timeout` [s]; DeviceError once the topic is silent."""
        if self._session is None:
            raise DeviceError(f"{self.name} is not open")
        try:
            came = self._came.get(timeout=max(timeout, 1e-4))
        except queue.Empty:
            if time.monotonic() - self._heard > SILENCE:
                raise DeviceError(f"nothing came on {self.name} for {SILENCE:g} s") from None
            return None
        if came is None:
            raise DeviceError(f"{self.name} is not open")
        self._heard = time.monotonic()
        return self.take(*came)

    def take(self, payload: bytes, arrived: int) -> Sample | None:
        """What a message says that came at `arrived` [ns]; None, and counted, where it is no frame."""
        try:
            if len(payload) > LARGEST:
                raise _Refused(f"{len(payload)} bytes")
            told: Any = self._types.deserialize_cdr(payload, f"geometry_msgs/msg/{self.options.message}")
            points = self._points(told)
            stamp = told.header.stamp.sec * 1_000_000_000 + told.header.stamp.nanosec
            captured = self._clock.heard(stamp, arrived) if stamp else arrived
        except (SerdeError, _Refused):
            self.rejected += 1
            return None
        if stamp:
            self.clock, self.clock_offset = "one-way", self._clock.offset_ns(stamp) * 1e-9
        named = self.options.label and self.options.message != "PoseArray"
        return Sample(captured, points, (self.options.label,) if named else ())

    def _points(self, told: Any) -> Array:
        """(M,3) [m]."""
        match self.options.message:
            case "PoseArray":
                places = [pose.position for pose in told.poses]
            case "PoseStamped":
                places = [told.pose.position]
            case "TransformStamped":
                places = [told.transform.translation]
            case "PointStamped":
                places = [told.point]
        points = np.array([(at.x, at.y, at.z) for at in places], float).reshape(-1, 3)
        if len(points) > POINTS_MAX or not plausible(points):
            raise _Refused("too many points, or one that is too far")
        return points

    def _put(self, sample: zenoh.Sample) -> None:
        """Called by a thread of zenoh's."""
        self._leave((sample.payload.to_bytes(), time.monotonic_ns()))

    def _leave(self, came: tuple[bytes, int] | None) -> None:
        """For the next read; the oldest makes room."""
        while True:
            try:
                self._came.put_nowait(came)
                return
            except queue.Full:
                try:
                    self._came.get_nowait()
                except queue.Empty:
                    pass
