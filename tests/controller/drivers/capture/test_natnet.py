"""The NatNet driver against our emulator of Motive, over loopback."""

import random
import socket
import time
from itertools import pairwise

import numpy as np
import pytest

from controller.drivers.capture.natnet.driver import NatNet, NatNetOptions
from controller.drivers.device import DeviceError
from controller.drivers.registry import capture_device
from controller.errors import ParameterError
from controller.schema.hardware import MotionCapture
from controller.virtual import natnet_server, natnet_wire
from controller.virtual.natnet_server import NatNetServer
from tests.controller.drivers.conftest import frames, named, showing

GROUP = "239.255.42.99"
VERSIONS = ("3.0", "3.1", "4.0", "4.1")
SHOWN = {"tip": [0.1, 0.2, 0.3], "hidden": None, "mid": [0.7, 0.8, 0.9]}


def driver(server, **options):
    return NatNet(NatNetOptions.model_validate(server.options | options))


@pytest.mark.parametrize("group", ["", GROUP], ids=["unicast", "multicast"])
@pytest.mark.parametrize("version", VERSIONS)
def test_points_of_every_version_come_by_unicast_and_multicast(opened, version, group):
    server = NatNetServer(version, ("tip", "hidden", "mid"), group)
    with showing(server):
        device = opened(driver(server))
        found = [sample for sample, _ in frames(device, 5)]
    assert named(found[-1]) == SHOWN
    assert device.version == tuple(map(int, version.split(".")))
    assert [b.number - a.number for a, b in pairwise(found)] == [1] * 4
    assert device.clock == "two-way" and device.rejected == 0
    assert version in device.name and (group or "unicast") in device.name


@pytest.mark.parametrize(
    ("wanted", "shown"),
    [
        ("unlabelled", {"": [0.4, 0.5, 0.6]}),
        ("rigid_bodies", SHOWN),
        ("all", SHOWN | {"": [0.4, 0.5, 0.6]}),
    ],
)
def test_the_rig_file_chooses_which_points_are_taken(opened, wanted, shown):
    server = NatNetServer("4.1", ("tip", "hidden", "mid"))
    with showing(server):
        assert named(frames(opened(driver(server, points=wanted)), 1)[0][0]) == shown


@pytest.mark.parametrize("asked", ["3.0", "3.1", "4.0"])
def test_a_server_from_4_0_on_sends_the_version_that_is_asked_for(opened, asked):
    server = NatNetServer("4.1", ("tip", "hidden", "mid"))
    with showing(server):
        device = opened(driver(server, version=asked))
        assert named(frames(device, 1)[0][0]) == SHOWN
    assert f"{device.version[0]}.{device.version[1]}" == asked


@pytest.mark.parametrize(
    ("server", "options", "text"),
    [
        (NatNetServer("3.1"), {"version": "3.0"}, "Motive sends NatNet 3.1, not 3.0"),
        (NatNetServer("4.1", (), GROUP), {"version": "4.0"}, "Motive sends NatNet 4.1, not 4.0"),
        (NatNetServer("3.0"), {"version": "4.1"}, "Motive sends NatNet 3.0, not 4.1"),
        (NatNetServer("4.1", (), GROUP), {"multicast_address": ""}, f"set multicast_address = {GROUP}"),
        (NatNetServer("4.1"), {"multicast_address": GROUP}, "but Motive sends by unicast"),
    ],
)
def test_what_the_server_does_not_do_is_said(opened, server, options, text):
    server.plug()
    try:
        with pytest.raises(DeviceError, match=text):
            driver(server, **options).open()
    finally:
        server.unplug()


def test_a_server_before_3_0_is_refused():
    class Old(NatNetServer):
        def _answer(self, kind, payload, sender, arrived):
            return natnet_wire.message(1, b"Motive".ljust(256, b"\0") + bytes([1, 10, 0, 0, 2, 10, 0, 0]))

    server = Old()
    server.plug()
    try:
        with pytest.raises(DeviceError, match=r"Motive speaks NatNet 2\.10; needed is 3\.0 or later"):
            driver(server).open()
    finally:
        server.unplug()


@pytest.mark.parametrize("late", [0.0073, 0.05])
def test_the_latency_that_is_computed_is_the_one_that_was_injected(opened, capsys, late):
    server = NatNetServer("4.1", (), frequency=3_312_787, offset=987_654.3, drift=5e-5)
    with showing(server, late, period=0.002):
        device = opened(driver(server, points="unlabelled"))
        latencies = [(arrived - sample.t_ns) * 1e-9 for sample, arrived in frames(device, 150)]
    # A low quantile: what a busy machine adds comes on top of most frames, a wrong clock is in every one.
    error = float(np.quantile(latencies, 0.1)) - late
    with capsys.disabled():
        print(f"\ninjected {late * 1e3:.1f} ms, computed {(late + error) * 1e3:.3f} ms")
    assert device.clock == "two-way"
    assert abs(error) < 5e-3
    offset = (server.ticks(10**15) / server.frequency) - 1e6
    assert device.clock_offset == pytest.approx(-offset, abs=60.0)


def test_a_server_without_echo_is_read_by_the_quickest_frames(opened):
    server = NatNetServer("4.0", ("tip",), echo=False)
    server.plug()
    try:
        device = opened(driver(server))
        rng, apart = random.Random(1), []
        for _ in range(60):
            captured = time.monotonic_ns() - 4_000_000
            time.sleep(rng.uniform(0.0, 0.004))
            server.show(captured, np.array([[0.1, 0.2, 0.3]]), ("tip",))
            apart.append((frames(device, 1)[0][0].t_ns - captured) * 1e-6)
    finally:
        server.unplug()
    assert device.clock == "one-way"
    # The shortest way, 4 ms and what the system adds, cannot be known; what varies is taken out.
    assert 4.0 <= np.median(apart[10:]) < 6.0
    assert np.std(apart[10:]) < 1.0


def test_a_server_that_vanishes_is_lost_within_three_seconds_and_found_when_it_is_back(opened):
    server = NatNetServer("4.1", ("tip", "hidden", "mid"))
    with showing(server):
        device = opened(driver(server))
        frames(device, 3)
    while device.read(0.05) is not None:
        pass
    with pytest.raises(DeviceError, match="nothing came"):
        for _ in range(30):
            device.read(0.1)
    with pytest.raises(DeviceError, match="no NatNet server answers"):
        device.open()
    with showing(server):
        device.open()
        assert named(frames(device, 2)[-1][0]) == SHOWN


def test_a_server_that_begins_again_streams_again_though_it_forgot_us(opened):
    server = NatNetServer("4.1", ("tip", "hidden", "mid"))
    with showing(server):
        device = opened(driver(server, version="4.0"))
        frames(device, 3)
    server.offset += 5000.0
    time.sleep(0.2)
    with showing(server):
        assert named(frames(device, 5)[-1][0]) == SHOWN
    assert device.version == (4, 0)


def test_a_client_that_reads_is_kept_alive(opened, monkeypatch):
    monkeypatch.setattr(natnet_server, "CLIENT_TIMEOUT_S", 0.8)
    server = NatNetServer("3.0", ("tip",))
    with showing(server, period=0.02):
        device = opened(driver(server))
        end = time.monotonic() + 1.5
        while time.monotonic() < end:
            assert device.read(0.3) is not None


def test_new_names_in_motive_are_asked_for(opened):
    server = NatNetServer("4.1", ("old",))
    server.plug()
    try:
        device = opened(driver(server))
        labels = set()
        end = time.monotonic() + 3.0
        while "new" not in labels and time.monotonic() < end:
            server.show(time.monotonic_ns(), np.array([[0.1, 0.2, 0.3]]), ("new",))
            if (sample := device.read(0.05)) is not None:
                labels |= set(sample.labels)
    finally:
        server.unplug()
    assert "new" in labels


def test_only_the_server_is_listened_to_and_rubbish_is_counted(opened):
    server = NatNetServer("4.1", ("tip",))
    server.plug()
    rng = random.Random(3)
    try:
        device = opened(driver(server, local_address=""))
        port = server.clients[0][1]
        frame = natnet_wire.message(7, natnet_wire.frame((4, 1), 1, np.ones((1, 3)), ("tip",), (1, 1), 1, False))
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.bind(("127.0.0.2", 0))
            stranger.sendto(frame, ("127.0.0.1", port))
            assert device.read(0.1) is None
        assert device.rejected == 1
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as server_gone_mad:
            server_gone_mad.bind(("127.0.0.1", 0))
            for _ in range(1000):
                rubbish = rng.choice((rng.randbytes(3), b"\7\0" + rng.randbytes(60), b"\xff\xff\1\0a", frame[:-40]))
                server_gone_mad.sendto(rubbish, ("127.0.0.1", port))
                assert device.read(0.0) is None
            device.read(0.1)
        assert device.rejected == 1001
        server.show(time.monotonic_ns(), np.array([[0.1, 0.2, 0.3]]), ("tip",))
        assert named(frames(device, 1)[0][0]) == {"tip": [0.1, 0.2, 0.3]}
    finally:
        server.unplug()


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "motion_capture.options.server: Field required"),
        ({"server": "a b"}, "motion_capture.options.server = a b: a host name or IPv4 address"),
        ({"server": "x", "command_port": 70000}, "command_port = 70000: Input should be less than or equal to 65535"),
        ({"server": "x", "multicast_address": "10.0.0.1"}, "outside [224.0.0.0, 239.255.255.255]"),
        ({"server": "x", "version": "2.9"}, "version = 2.9"),
        ({"server": "x", "frame_rate": 100}, "frame_rate"),
    ],
)
def test_options_are_refused_by_field_value_and_bound(options, text):
    with pytest.raises(ParameterError) as error:
        capture_device(MotionCapture(driver="natnet", options=options))
    assert text in str(error.value)


def test_nothing_is_read_before_it_is_open_and_closing_twice_does_no_harm():
    device = NatNet(NatNetOptions(server="127.0.0.1"))
    device.close()
    device.close()
    with pytest.raises(DeviceError, match="is not open"):
        device.read(0.0)
    with pytest.raises(DeviceError, match="no such host"):
        NatNet(NatNetOptions(server="nowhere.invalid")).open()
