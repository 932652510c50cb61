"""A marker that goes round, sent by a process of its own: an outlet of LSL, or zenoh with a topic of ROS 2.

python marker_source.py lsl STREAM RADIUS, or python marker_source.py ros2 ADDRESS RADIUS
"""

import json
import math
import os
import struct
import sys
import time
from collections.abc import Callable

PERIOD_S = 1 / 120
TURN = 0.5
"""Turns a second."""
TOPIC = "0/rods/tip"
FULL_KEY = f"{TOPIC}/geometry_msgs::msg::dds_::PoseStamped_/RIHS01_1234"
"""As rmw_zenoh has it: domain, topic, type and its hash."""

Send = Callable[[int, float, float], object]
"""Of a time [ns] on the monotonic clock, x and y [m]."""


def lsl(stream: str) -> Send:
    """Samples in millimetres; LSL's clock is the monotonic one here."""
    import pylsl

    info = pylsl.StreamInfo(stream, "MoCap", 3, 1 / PERIOD_S, "float32", f"tendril-{stream}")
    channels = info.desc().append_child("channels")
    for axis in "XYZ":
        channels.append_child("channel").append_child_value("label", f"tip_{axis}")
    outlet = pylsl.StreamOutlet(info, chunk_size=1)
    return lambda now, x, y: outlet.push_sample([1e3 * x, 1e3 * y, 0.0], now * 1e-9)


def ros2(address: str) -> Send:
    """Each frame a PoseStamped, in CDR written by hand."""
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"router"')
    config.insert_json5("listen/endpoints", json.dumps([f"tcp/{address}"]))
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)

    def send(now: int, x: float, y: float) -> None:
        header = b"\0\1\0\0" + struct.pack("<iII", *divmod(now, 10**9), 4) + b"map\0"
        aligned = header + bytes(-(len(header) - 4) % 8)
        session.put(FULL_KEY, aligned + struct.pack("<7d", x, y, 0.0, 0.0, 0.0, 0.0, 1.0))

    return send


def main(kind: str, place: str, radius: str) -> None:
    """Say "ready", then send until the process that started this one is gone."""
    parent, send = os.getppid(), {"lsl": lsl, "ros2": ros2}[kind](place)
    print("ready", flush=True)
    while os.getppid() == parent:
        now = time.monotonic_ns()
        turned = 2.0 * math.pi * TURN * now * 1e-9
        send(now, float(radius) * math.cos(turned), float(radius) * math.sin(turned))
        time.sleep(PERIOD_S)


if __name__ == "__main__":
    main(*sys.argv[1:])
