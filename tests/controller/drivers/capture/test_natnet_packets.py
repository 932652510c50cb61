"""The parser of NatNet against bytes written by hand, another parser, and rubbish."""

import random
import time

import numpy as np
import pytest
from natnet.data_descriptions import DataDescriptions
from natnet.data_frame import DataFrame
from natnet.packet_buffer import PacketBuffer
from natnet.version import Version as TheirVersion

from controller.drivers.capture.natnet.definitions import Names, parse_definitions, parse_server_info
from controller.drivers.capture.natnet.packets import VERSIONS, Malformed, message, parse_frame
from controller.drivers.capture.natnet.points import Naming
from controller.drivers.device import POINTS_MAX
from controller.virtual import natnet_wire
from tests.controller.drivers.effort import lines_run
from tests.controller.drivers.natnet_bytes import DEFINITIONS, FRAMES, SERVER

FUZZ = 100_000


@pytest.mark.parametrize("version", VERSIONS)
def test_a_frame_of_each_version_is_read_as_it_was_written(version):
    frame = parse_frame(bytes.fromhex(FRAMES[version]), version)
    assert frame.number == 1000 + VERSIONS.index(version)
    assert frame.timestamp == 12.5
    assert frame.exposed == 0x0102030405
    assert frame.bodies["id"][0] == 2
    assert frame.bodies["at"][0].tolist() == [0.5, 0.25, 1.0]
    assert frame.flags == (2 if version == (3, 0) else 0)


LABELLED = {
    (3, 0): {"platform.1": [-0.5, 0.25, 0.125], "tip": [0.5, 0.25, 0.0], "mid": None},
    (3, 1): {"platform.2": None, "platform.1": [-0.5, 0.25, 0.125], "tip": [0.5, 0.25, 0.0], "mid": None},
    (4, 0): {"platform.c": [2.0, 1.0, 0.5]},
    (4, 1): {"platform.a": [-0.5, 0.25, 0.125], "tip": [0.5, 0.25, 0.0], "mid": None},
}


@pytest.mark.parametrize("version", VERSIONS)
def test_markers_have_the_names_of_the_model_definitions_and_are_nan_where_not_seen(version):
    naming = Naming(parse_definitions(bytes.fromhex(DEFINITIONS[version]), version))
    points, labels, quality = naming.points(parse_frame(bytes.fromhex(FRAMES[version]), version), "labelled")
    found = {label: None if np.isnan(at).all() else at.tolist() for label, at in zip(labels, points, strict=True)}
    assert found == LABELLED[version]
    assert all((q > 0.0) == (found[label] is not None) for label, q in zip(labels, quality, strict=True))


def test_what_motive_placed_by_its_model_counts_half_and_a_lost_body_is_not_seen():
    naming = Naming(parse_definitions(bytes.fromhex(DEFINITIONS[4, 0]), (4, 0)))
    frame = parse_frame(bytes.fromhex(FRAMES[4, 0]), (4, 0))
    assert naming.points(frame, "labelled")[2].tolist() == [0.5]
    bodies, labels, quality = naming.points(frame, "rigid_bodies")
    assert labels == ("platform", "3")
    assert np.isnan(bodies[1]).all() and quality.tolist() == [1.0, 0.0]


def test_unlabelled_markers_come_once_though_motive_sends_them_in_two_lists():
    frame = parse_frame(bytes.fromhex(FRAMES[3, 0]), (3, 0))
    points, labels, _ = Naming(Names()).points(frame, "unlabelled")
    assert labels == ("", "")
    assert points.tolist() == [[1.0, 2.0, 0.5], [1.0, 0.5, 0.125]]
    twice = frame._replace(others=frame.labelled["at"])
    assert len(Naming(Names()).points(twice, "unlabelled")[0]) == 1


@pytest.mark.parametrize("version", VERSIONS)
def test_another_parser_reads_the_same_bytes_in_the_same_way(version):
    for payload in (bytes.fromhex(FRAMES[version]), emulated(version)):
        theirs = DataFrame.read_from_buffer(PacketBuffer(payload), TheirVersion(*version))
        ours = parse_frame(payload, version)
        assert theirs.prefix.frame_number == ours.number
        assert [(s.model_name, [*map(list, s.marker_pos_list)]) for s in theirs.marker_sets] == [
            (name, at.tolist()) for name, at in ours.sets
        ]
        assert [list(at) for at in theirs.unlabeled_marker_pos] == ours.others.tolist()
        assert [(b.id_num, list(b.pos), b.tracking_valid) for b in theirs.rigid_bodies] == [
            (b["id"], b["at"].tolist(), bool(b["flags"] & 1)) for b in ours.bodies
        ]
        assert [(m.id_num, list(m.pos), m.param) for m in theirs.labeled_markers] == [
            (m["id"], m["at"].tolist(), m["flags"]) for m in ours.labelled
        ]
        assert theirs.suffix.timestamp == ours.timestamp
        assert theirs.suffix.stamp_camera_mid_exposure == ours.exposed


@pytest.mark.parametrize("version", VERSIONS)
def test_another_parser_finds_the_same_names(version):
    for payload in (bytes.fromhex(DEFINITIONS[version]), natnet_wire.definitions(version, ("tip", "mid"))):
        theirs = DataDescriptions.read_from_buffer(PacketBuffer(payload), TheirVersion(*version))
        ours = parse_definitions(payload, version)
        assert {body.id_num: body.name for body in theirs.rigid_bodies} == ours.bodies
        assert {each.name: each.marker_names for each in theirs.marker_sets} == ours.sets


def test_a_server_says_its_version_clock_and_group():
    info = parse_server_info(bytes.fromhex(SERVER))
    assert (info.application, info.version, info.frequency) == ("Motive", (4, 1), 10_000_000)
    assert (info.data_port, info.multicast) == (1511, "239.255.42.99")


def test_a_marker_is_called_by_its_set_too_where_two_sets_share_its_name():
    names = Names(sets={"left": ("tip", "mid"), "right": ("tip",), "all": ("tip",), "body": ("x",)}, bodies={1: "body"})
    assert names.own_sets() == {"left": ("left.tip", "mid"), "right": ("right.tip",)}


def test_a_frame_of_more_points_than_an_actuator_bears_is_refused():
    many = np.full((POINTS_MAX + 1, 3), 0.1)
    payload = natnet_wire.frame((4, 1), 1, many, (), (1, 1), 1000, False)
    with pytest.raises(Malformed, match="513 points, more than 512"):
        Naming(Names()).points(parse_frame(payload, (4, 1)), "unlabelled")


def test_a_frame_with_an_impossible_coordinate_is_refused_and_nan_is_a_marker_not_seen():
    for bad in (np.inf, 1e30, -2e3):
        payload = bytes.fromhex(FRAMES[4, 1]).replace(np.float32(-0.5).tobytes(), np.float32(bad).tobytes())
        with pytest.raises(Malformed, match="beyond 1000 m"):
            parse_frame(payload, (4, 1))
    payload = bytes.fromhex(FRAMES[4, 1]).replace(np.float32(-0.5).tobytes(), np.float32(np.nan).tobytes())
    points, labels, quality = Naming(Names()).points(parse_frame(payload, (4, 1)), "labelled")
    assert labels == ("2.1",) and np.isnan(points[0, 0]) and quality.tolist() == [0.0]


def test_every_frame_cut_short_anywhere_is_refused():
    for version, text in FRAMES.items():
        payload = bytes.fromhex(text)
        whole = len(payload) - (0 if version == (3, 1) else 4)
        for size in range(whole):
            if version == (4, 1) and size in range(whole - 8, whole - 6):
                continue
            try:
                frame = parse_frame(payload[:size], version)
            except Malformed:
                continue
            assert size >= whole - 8, (version, size)  # flags, then the grandmaster's time taken for them
            assert frame.number >= 1000


@pytest.mark.keyed()
def test_a_hundred_thousand_random_and_mutated_messages_are_read_or_refused_and_nothing_else(capsys):
    rng = random.Random(20)
    seeds = [(version, 0, bytes.fromhex(text)) for version, text in FRAMES.items()]
    seeds += [(version, 1, bytes.fromhex(text)) for version, text in DEFINITIONS.items()]
    seeds += [((4, 1), 2, bytes.fromhex(SERVER)), *((version, 0, emulated(version)) for version in VERSIONS)]
    read = refused = 0
    began = time.process_time()
    for _ in range(FUZZ):
        version, kind, payload = rng.choice(seeds)
        if rng.random() < 0.2:
            version = rng.choice(VERSIONS)
        hostile = mutated(rng, payload)
        try:
            one(kind, hostile, version)
            read += 1
        except Malformed:
            refused += 1
    took = time.process_time() - began
    assert read + refused == FUZZ
    assert refused > FUZZ // 4 < read * 4
    with capsys.disabled():
        print(f"\n{FUZZ} frames: {read} read, {refused} refused, {took / FUZZ * 1e6:.0f} us each")


def one(kind, payload, version):
    """Read a message of `kind` as the driver does."""
    if kind == 0:
        Naming(Names()).points(parse_frame(payload, version), "all")
    elif kind == 1:
        parse_definitions(payload, version)
    else:
        parse_server_info(payload)


def mutated(rng, payload):
    """Random bytes, or `payload` with bytes changed, cut out, doubled, or counts made huge."""
    way = rng.randrange(6)
    if way == 0:
        return rng.randbytes(rng.randrange(400))
    changed = bytearray(payload)
    if way == 1:
        for _ in range(rng.randrange(1, 9)):
            changed[rng.randrange(len(changed))] = rng.randrange(256)
    elif way == 2:
        del changed[rng.randrange(len(changed)) :]
    elif way == 3:
        at = rng.randrange(len(changed))
        changed[at:at] = changed[: rng.randrange(len(changed))]
    elif way == 4:
        at = rng.randrange(max(1, len(changed) - 4))
        changed[at : at + 4] = rng.choice((0xFFFFFFFF, 0x7FFFFFFF, 0x80000000, 0x10000, 5000)).to_bytes(4, "little")
    else:
        at = rng.randrange(len(changed))
        del changed[at : at + rng.randrange(1, 16)]
    return bytes(changed)


def emulated(version):
    points = np.array([[0.1, 0.2, 0.3], [np.nan] * 3, [0.4, 0.5, 0.6]])
    return natnet_wire.frame(version, 7, points, ("tip", "mid", ""), (1000, 1200), 1000, False)


def test_the_largest_datagrams_cost_a_few_lines_a_byte():
    head, end = bytes(4), bytes(4 * 6) + bytes(40 + 2)
    channels = bytes(4 * 6) + (1).to_bytes(4, "little") * 2 + (16_000).to_bytes(4, "little") + bytes(64_000) + end
    sets = (512).to_bytes(4, "little") + (b"s\0" + (10).to_bytes(4, "little") + bytes(120)) * 512 + bytes(4 * 6) + end
    names = (1).to_bytes(4, "little") + bytes(4) + b"s\0" + (60_000).to_bytes(4, "little") + bytes(60_000)
    with pytest.raises(Malformed):
        parse_frame(head + bytes([0, 8]) + sets[2:], (4, 0))
    frame, named = parse_frame(head + sets, (4, 0)), parse_definitions(names, (4, 0))
    for read in (
        lambda: parse_frame(head + channels, (4, 0)),
        lambda: parse_frame(head + sets, (4, 0)),
        lambda: parse_definitions(names, (4, 0)),
        lambda: Naming(named).points(frame, "all"),
    ):
        assert lines_run(read) < 6 * 65_000, "lines for each byte"


def test_a_header_must_not_announce_more_than_came():
    assert message(natnet_wire.message(7, b"abc")) == (7, b"abc")
    for short in (b"", b"\7\0\4", b"\7\0\4\0abc"):
        with pytest.raises(Malformed):
            message(short)
