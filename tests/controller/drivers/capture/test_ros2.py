"""The ROS 2 door against a zenoh session that puts CDR bytes written by hand."""

import json
import random
import socket
import struct
import time

import numpy as np
import pytest

pytest.importorskip("rosbags")
import zenoh

from controller.drivers.capture import ros2
from controller.drivers.capture.ros2 import Ros2Capture, Ros2Options
from controller.drivers.device import DeviceError
from tests.controller.drivers.conftest import frames

FUZZ = 100_000


def header(stamp_ns, frame_id=b"map\0"):
    """Encapsulation (little endian), stamp, frame."""
    return b"\0\1\0\0" + struct.pack("<iII", *divmod(stamp_ns, 10**9), len(frame_id)) + frame_id


def aligned(message, size=8):
    """CDR pads to the size of what follows, counted from behind the encapsulation."""
    return message + bytes(-(len(message) - 4) % size)


POSE = (0.1, 0.2, 0.3, 0.0, 0.0, 0.0, 1.0)
MESSAGES = {
    "PointStamped": lambda stamp: aligned(header(stamp)) + struct.pack("<3d", *POSE[:3]),
    "PoseStamped": lambda stamp: aligned(header(stamp)) + struct.pack("<7d", *POSE),
    "TransformStamped": lambda stamp: aligned(header(stamp) + b"\4\0\0\0tip\0") + struct.pack("<7d", *POSE),
    "PoseArray": lambda stamp: aligned(header(stamp) + b"\1\0\0\0") + struct.pack("<7d", *POSE),
}


def taking(message):
    return Ros2Capture(Ros2Options(router="127.0.0.1:7447", topic="rods", message=message, label="tip"))


def free_address():
    """Where nothing listens."""
    with socket.create_server(("127.0.0.1", 0)) as asked:
        return f"127.0.0.1:{asked.getsockname()[1]}"


@pytest.fixture
def router():
    """A zenoh session that others connect to, and its address."""
    address = free_address()
    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/{address}"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    yield session, address
    session.close()


@pytest.mark.parametrize("message", MESSAGES)
def test_positions_of_each_message_are_read(message):
    device = taking(message)
    sample = device.take(MESSAGES[message](10**18), 10**12)
    assert sample is not None and sample.labels == (() if message == "PoseArray" else ("tip",))
    assert sample.points.tolist() == [[0.1, 0.2, 0.3]] and sample.t_ns == 10**12
    assert device.clock == "one-way" and device.rejected == 0


def test_a_topic_is_read_as_rmw_zenoh_and_the_bridge_name_it(opened, router):
    session, address = router
    for topic, key in (
        ("0/rods/**", "0/rods/geometry_msgs::msg::dds_::PoseStamped_/RIHS01_1234"),
        ("rods/tip", "rods/tip"),
    ):
        device = opened(Ros2Capture(Ros2Options(router=address, topic=topic, label="tip")))
        end = time.monotonic() + 3.0
        sample = None
        while sample is None and time.monotonic() < end:
            session.put(key, MESSAGES["PoseStamped"](time.time_ns() - 5_000_000))
            sample = device.read(0.05)
        assert sample is not None and np.allclose(sample.points, [[0.1, 0.2, 0.3]])
        session.put(key, MESSAGES["PoseStamped"](time.time_ns())[:-9])
        session.put(key, MESSAGES["PoseStamped"](time.time_ns()))
        frames(device, 1)
        assert device.rejected == 1


def test_where_no_zenoh_is_the_error_says_so(monkeypatch):
    monkeypatch.setattr(ros2, "CONNECTING_MS", 300)
    with pytest.raises(DeviceError, match="no zenoh at"):
        Ros2Capture(Ros2Options(router=free_address(), topic="rods")).open()


@pytest.mark.keyed()
def test_a_hundred_thousand_random_and_mutated_messages_are_read_or_counted(capsys):
    rng = random.Random(4)
    devices = {message: taking(message) for message in MESSAGES}
    read = 0
    for _ in range(FUZZ):
        message = rng.choice(list(MESSAGES))
        hostile = bytearray(MESSAGES[rng.choice((message, "PoseArray"))](rng.randrange(2**31 * 10**9)))
        for _ in range(rng.randrange(4)):
            hostile[rng.randrange(len(hostile))] = rng.randrange(256)
        if rng.random() < 0.3:
            del hostile[rng.randrange(len(hostile)) :]
        read += devices[message].take(bytes(hostile), 10**12) is not None
    refused = sum(device.rejected for device in devices.values())
    assert read + refused == FUZZ
    with capsys.disabled():
        print(f"\n{FUZZ} messages: {read} read, {refused} refused")
