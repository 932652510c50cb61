"""Plot bins keep every sample's extremes; a viewer gets each bin of its channels once, whatever its pace."""

from operator import attrgetter

import numpy as np
import pytest

from controller.schema.layout import record_dtype
from controller.schema.messages import Telemetry
from controller.schema.modes import Mode
from controller.schema.states import LIVE
from server.plots.feed import CHUNK, Feed, Plots
from server.rig.channels import CHANNELS, column, columns_of, extract
from server.rig.history import BIN_TICKS, History

ALL = list(range(len(CHANNELS)))
ERROR, X_MEAS, ENERGY = columns_of(["error.norm", "p_meas.0", "energy"])


def rows(first: int, count: int, mode: Mode = Mode.HOLD) -> np.ndarray:
    found = np.zeros(count, record_dtype(Telemetry))
    found["tick"] = np.arange(first, first + count)
    found["t_ns"] = found["tick"] * 1_000_000
    found["mode"], found["energy"] = mode, found["tick"]
    found["p_meas"] = np.nan
    return found


def filled(count: int, bins: int = 100) -> History:
    history = History(1000, bins)
    for first in range(0, count, 10):
        history.add(rows(first, min(10, count - first)))
    return history


def plot(message: bytes | None) -> tuple[int, list[int], np.ndarray, np.ndarray, np.ndarray]:
    """First bin, channels, times, low and high of a PLOT message."""
    assert message is not None
    kind, count, width, first = np.frombuffer(message, "<u4", 4).tolist()
    assert kind == 2
    assert len(message) == 16 + 8 * count + 4 * width + 8 * count * width
    t = np.frombuffer(message, "<f8", count, 16)
    channels = np.frombuffer(message, "<u4", width, 16 + 8 * count).tolist()
    low, high = np.frombuffer(message, "<f4", offset=16 + 8 * count + 4 * width).reshape(2, count, width)
    return first, channels, t, low, high


def test_every_number_of_a_row_but_its_time_is_a_channel() -> None:
    assert {channel.field for channel in CHANNELS} == set(Telemetry.model_fields) - {"t_ns"}
    elements = [channel for channel in CHANNELS if channel.index is not None]
    dtype = record_dtype(Telemetry)
    assert len(elements) == sum(int(np.prod(dtype[name].shape)) for name in Telemetry.model_fields) - 1
    assert len({channel.key for channel in CHANNELS}) == len(CHANNELS)
    units = {channel.key: channel.unit for channel in CHANNELS}
    assert (units["p_ref.0"], units["p_ref_dot.norm"], units["integral.1"], units["u.0"]) == ("m", "m/s", "m s", "N m")


def test_a_spike_of_one_sample_is_in_a_bin_and_nan_is_not() -> None:
    history = filled(2500)
    batch = rows(2500, 20)
    batch["error"][3] = (3.0, 4.0)
    batch["p_meas"][3] = (0.1, 0.2)
    history.add(batch)
    bins = history.bins(0, history.bin_stop, ALL)
    assert len(bins.t) == 100, "no more are kept"
    assert bins.stop == 2520 // BIN_TICKS
    assert np.isclose(bins.high[:, ERROR].max(), 5.0)
    assert np.count_nonzero(bins.high[:, ERROR]) == 1
    assert np.count_nonzero(np.isfinite(bins.low[:, X_MEAS])) == 1
    assert np.allclose(np.diff(bins.t), BIN_TICKS * 1e-3)


@pytest.mark.parametrize("mode", Mode)
def test_there_is_an_error_only_where_a_reference_rules(mode: Mode) -> None:
    batch = rows(0, 5, mode)
    batch["error"] = (3.0, 4.0)
    known = mode in LIVE
    for found in (extract(batch)[:, ERROR], column(batch, CHANNELS[ERROR])):
        assert np.array_equal(found, np.full(5, 5.0 if known else np.nan), equal_nan=True)
    assert np.isfinite(extract(batch)[:, ENERGY]).all()


def test_every_row_is_in_exactly_one_bin_however_rows_arrive() -> None:
    history, first = History(1000, 100), 0
    for count in (1, 15, 40, 3, 900, 41):
        history.add(rows(first, count))
        first += count
    bins = history.bins(0, history.bin_stop, [ENERGY])
    assert np.array_equal(bins.low[:, 0], BIN_TICKS * np.arange(len(bins.t)))
    assert np.array_equal(bins.high, bins.low + BIN_TICKS - 1)


def test_a_batch_longer_than_the_ring_leaves_its_end() -> None:
    history = History(1000, 100)
    history.add(rows(0, 5000))
    bins = history.bins(0, history.bin_stop, [ENERGY])
    assert bins.low[0, 0] == 4000
    assert history.newest is not None
    assert history.newest[0]["tick"] == 4999


def test_rows_of_an_earlier_life_are_forgotten() -> None:
    history = filled(100)
    before = history.bin_stop
    history.forget()
    assert history.newest is None
    assert len(history.bins(0, 1000, ALL).t) == 0
    history.add(rows(0, 32))
    bins = history.bins(0, 1000, ALL)
    assert (bins.first, len(bins.t)) == (before, 2), "numbers go on, the half bin of the old boot is in none"
    assert np.allclose(bins.t, [0.008, 0.024])


def test_to_claim_its_memory_changes_nothing_that_is_in_it() -> None:
    history, same = filled(1500), filled(1500)
    history.claim()
    for ring in ("_rows.memory", "_t", "_low", "_high"):
        assert attrgetter(ring)(history).tobytes() == attrgetter(ring)(same).tobytes(), ring


def test_the_history_is_ten_minutes_within_its_bound() -> None:
    history = History()
    assert history.nbytes < 120e6
    assert history._t.size * BIN_TICKS == 600_000


def test_a_feed_sends_the_past_in_pieces_and_then_each_bin_once() -> None:
    history = History(1000, 3 * CHUNK)
    for first in range(0, 40_000, 500):
        history.add(rows(first, 500))
    feed = Feed(Plots(history))
    assert feed.next() is None, "nothing was chosen"
    feed.choose([ERROR, ENERGY], None)
    pieces = []
    while (message := feed.next()) is not None:
        first, channels, t, _, high = plot(message)
        assert channels == [ERROR, ENERGY]
        assert len(t) <= CHUNK
        assert np.array_equal(high[:, 1], BIN_TICKS * (first + np.arange(len(t))) + BIN_TICKS - 1)
        pieces.insert(0, first + np.arange(len(t)))
    assert np.array_equal(np.concatenate(pieces), np.arange(2500)), "the newest piece came first, none twice"
    assert not feed.behind
    history.add(rows(40_000, 20))
    assert plot(feed.next())[0] == 2500
    assert feed.next() is None


def test_of_a_new_channel_the_past_comes_and_no_other_twice() -> None:
    history = filled(800)
    feed = Feed(Plots(history))
    feed.choose([ENERGY], None)
    assert len(plot(feed.next())[2]) == 50
    assert feed.next() is None
    history.add(rows(800, 32))
    feed.choose([ENERGY, ERROR], None)
    new, past = plot(feed.next()), plot(feed.next())
    assert (past[0], past[1], len(past[2])) == (0, [ERROR], 50)
    assert (new[0], new[1], len(new[2])) == (50, [ENERGY, ERROR], 2)
    feed.choose([ERROR], None)
    assert feed.next() is None


def test_a_page_that_comes_back_gets_what_it_missed() -> None:
    history = filled(800)
    feed = Feed(Plots(history))
    feed.choose([ENERGY], since=0.7)
    first, _, t, _, _ = plot(feed.next())
    assert first == 44
    assert t[0] >= 0.7
    assert feed.next() is None


def test_a_feed_survives_a_rig_that_restarts() -> None:
    history = filled(800)
    feed = Feed(Plots(history))
    feed.choose([ENERGY], None)
    history.forget()
    history.add(rows(0, 48))
    first, _, t, _, _ = plot(feed.next())
    assert (first, len(t)) == (50, 3)
    assert feed.next() is None
