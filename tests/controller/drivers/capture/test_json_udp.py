"""The JSON driver against our own source, and against datagrams that no source should send."""

import json
import random
import socket
import time
from itertools import pairwise

import numpy as np
import pytest

from controller.drivers.capture.json_udp import LARGEST, JsonCapture, JsonOptions
from controller.drivers.device import Angles, DeviceError, Sample
from controller.virtual.json_source import JsonSource
from tests.controller.drivers.conftest import LABELS, POINTS, frames, named, showing
from tests.controller.drivers.effort import lines_run

FUZZ = 100_000
HERE = ("127.0.0.1", 4000)


def driver(source, **options):
    return JsonCapture(JsonOptions.model_validate(source.options | options))


def taken(datagram, device=None):
    """What a driver makes of one datagram of its sender."""
    device = device or listening()
    return device.take(datagram if isinstance(datagram, bytes) else json.dumps(datagram).encode(), HERE, 10**12)


def listening():
    device = JsonCapture(JsonOptions(sender="127.0.0.1", port=JsonSource().port))
    device.open()
    device.close()  # knows its sender now
    return device


@pytest.mark.parametrize("dimensions", [2, 3])
def test_points_come_with_labels_and_numbers_and_null_is_not_seen(opened, dimensions):
    source = JsonSource(dimensions=dimensions)
    device = opened(driver(source))
    with showing(source):
        found = [sample for sample, _ in frames(device, 5)]
    assert found[-1].labels == LABELS
    assert np.allclose(found[-1].points, POINTS[:, :dimensions], equal_nan=True)
    assert [b.number - a.number for a, b in pairwise(found)] == [1] * 4
    assert device.rejected == 0


def test_angles_come_as_angles(opened):
    source = JsonSource()
    device = opened(driver(source))
    source.plug()
    try:
        source.bend(time.monotonic_ns(), np.array([0.1, 0.2]), np.array([0.5, np.nan]))
        angles = device.read(1.0)
    finally:
        source.unplug()
    assert isinstance(angles, Angles) and angles.arcs.tolist() == [0.1, 0.2]
    assert angles.angles[0] == 0.5 and np.isnan(angles.angles[1])


@pytest.mark.parametrize("late", [0.0, 0.02])
def test_a_source_that_tells_its_clock_has_its_latency_known(opened, capsys, late):
    source = JsonSource(offset=1.7e9)
    device = opened(driver(source))
    with showing(source, late, period=0.002):
        found = frames(device, 120)[20:]
    # A low quantile: what a busy machine adds comes on top of most frames, a wrong clock is in every one.
    latency = float(np.quantile([arrived - sample.t_ns for sample, arrived in found], 0.1)) * 1e-9
    with capsys.disabled():
        print(f"\ninjected {late * 1e3:.1f} ms, computed {latency * 1e3:.3f} ms")
    assert device.clock == "two-way" and abs(latency - late) < 5e-3


def test_a_source_that_does_not_answer_is_timed_by_its_quickest_datagrams(opened):
    source = JsonSource(answers=False)
    device = opened(driver(source))
    with showing(source, 0.02):
        ages = [arrived - sample.t_ns for sample, arrived in frames(device, 20)]
    assert device.clock == "one-way" and 0 <= min(ages) < 15_000_000


def test_a_frame_without_a_time_has_that_of_its_arrival():
    device = listening()
    sample = taken({"points": [[1, 2]]}, device)
    assert isinstance(sample, Sample) and sample.t_ns == 10**12 and sample.number == -1
    assert device.clock == "arrival"


def test_a_source_may_vanish_and_come_back(opened):
    source = JsonSource()
    device = opened(driver(source))
    with showing(source):
        frames(device, 2)
    while device.read(0.05) is not None:
        pass
    source.offset = -7000.0
    with showing(source):
        found = frames(device, 60)[-20:]
    assert all(named(sample)["tip"] == [0.1, 0.2, 0.3] for sample, _ in found)
    assert 0 <= min(arrived - sample.t_ns for sample, arrived in found) < 50_000_000


def test_datagrams_of_others_are_counted_and_not_read(opened):
    source = JsonSource()
    device = opened(driver(source, local_address=""))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.bind(("127.0.0.2", 0))
        stranger.sendto(b'{"points": [[1, 2, 3]]}', ("127.0.0.1", source.port))
    assert device.read(0.2) is None and device.rejected == 1


@pytest.mark.parametrize(
    "datagram",
    [
        b"",
        b"\xff\xfe",
        b"[" * 60_000,
        b"[]",
        b"12",
        b'{"points": [[NaN, 1, 2]]}',
        b'{"points": [[1e999, 1, 2]]}',
        b'{"t": ' + b"9" * 5000 + b', "points": [[1, 2]]}',
        b'{"t": 1e300, "points": [[1, 2]]}',
        b'{"n": 1.5, "points": [[1, 2]]}',
        b'{"n": 99999999999999999999, "points": [[1, 2]]}',
        b'{"points": [[1, 2], [1, 2, 3]]}',
        b'{"points": [[1]]}',
        b'{"points": [[true, false]]}',
        b'{"points": [["1", "2"]]}',
        b'{"points": [[1001, 0, 0]]}',
        b'{"points": {"tip": [1, 2, 3]}}',
        b'{"points": [[1, 2]], "labels": ["a", "b"]}',
        b'{"points": [[1, 2]], "labels": [7]}',
        b'{"points": [[1, 2]], "quality": [2]}',
        b'{"points": [[1, 2]], "quality": 1}',
        b'{"arcs": [0.2, 0.1], "angles": [0, 0]}',
        b'{"arcs": [0.1], "angles": [0, 0]}',
        b'{"arcs": [-0.1], "angles": [0]}',
        b'{"arcs": [null], "angles": [0]}',
        b'{"ask": 1, "t": 0}',
        b'{"ask": [], "t": 0}',
        json.dumps({"points": [[0, 0]] * 513}).encode(),
        json.dumps({"points": [[0, 0]], "labels": ["a" * 65]}).encode(),
    ],
    ids=lambda datagram: repr(datagram[:40]),
)
def test_what_is_no_frame_is_counted_and_gives_nothing(datagram):
    device = listening()
    assert taken(datagram, device) is None
    assert device.rejected == 1


@pytest.mark.keyed()
def test_a_hundred_thousand_random_and_mutated_datagrams_are_read_or_counted(capsys):
    rng, device = random.Random(7), listening()
    seeds = [
        b'{"t": 12.5, "n": 3, "points": [[0.1, 0.2, 0.3], null], "labels": ["tip", ""], "quality": [1, 0.5]}',
        b'{"t": -1.5, "points": [[0.1, null]]}',
        b'{"t": 1, "n": 4, "arcs": [0.1, 0.2], "angles": [0.5, null]}',
        b'{"ask": 3, "t": 4.5}',
    ]
    letters = b'0123456789eE+-.,:[]{}"\\ntulfaseNI \x00\xff'
    read = 0
    for index in range(FUZZ):
        hostile = bytearray(rng.choice(seeds))
        for _ in range(rng.randrange(1, 3)):
            at = rng.randrange(len(hostile))
            hostile[at : at + rng.randrange(3)] = bytes(rng.choice(letters) for _ in range(rng.randrange(3))) or b" "
        if index % 10 == 0:
            hostile = bytearray(rng.randbytes(rng.randrange(200)))
        frame = device.take(bytes(hostile), HERE, 10**12 + index)
        read += frame is not None
        assert frame is None or frame.t_ns <= 10**12 + index
    assert read + device.rejected == FUZZ
    with capsys.disabled():
        print(f"\n{FUZZ} datagrams: {read} read, {device.rejected} refused")


def test_the_largest_datagram_costs_no_more_than_a_small_one():
    device = listening()
    for inner in (b"1,", b"[0,0],", b"null,", b'"a",'):
        datagram = b'{"points": [' + inner * ((LARGEST - 20) // len(inner)) + b"0]}"
        assert lines_run(lambda datagram=datagram: taken(datagram, device)) < 200, "refused before its rows are read"
    assert device.rejected == 4


def test_nothing_is_read_before_it_is_open_and_a_taken_port_is_an_error(opened):
    source = JsonSource()
    device = driver(source)
    with pytest.raises(DeviceError, match="is not open"):
        device.read(0.0)
    opened(device)
    with pytest.raises(OSError):
        driver(source).open()
    device.close()
    device.close()
