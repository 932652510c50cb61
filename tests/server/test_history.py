"""Plot bins keep every sample's extremes, whatever the pace of the viewer."""

import itertools

import numpy as np

from controller.layout import record_dtype
from controller.messages import Telemetry
from server.channels import CHANNELS
from server.history import History, encode_plot

KEYS = [channel.key for channel in CHANNELS]


def rows(first: int, count: int) -> np.ndarray:
    found = np.zeros(count, record_dtype(Telemetry))
    found["tick"] = np.arange(first, first + count)
    found["t_ns"] = found["tick"] * 1_000_000
    found["p_meas"] = np.nan
    return found


def test_a_spike_of_one_sample_is_in_a_bin_and_nan_is_not() -> None:
    history = History(1000)
    for first in range(0, 3000, 10):
        batch = rows(first, 10)
        if first == 2500:
            batch["error"][3] = (3.0, 4.0)
            batch["p_meas"][3] = (0.1, 0.2)
        history.add(batch)
    bins = history.bins(0, history.count, 16)
    assert len(bins.t) == 63, "1000 rows are kept: 62 whole bins of 16 and a short one"
    assert np.isclose(bins.high[:, KEYS.index("error")].max(), 5.0)
    assert np.count_nonzero(bins.high[:, KEYS.index("error")]) == 1
    assert np.count_nonzero(np.isfinite(bins.low[:, KEYS.index("x_meas")])) == 1
    assert np.all(np.diff(bins.t) > 0)
    assert bins.t[0] >= 2.0
    assert bins.t[-1] < 3.0


def test_every_row_is_in_exactly_one_of_successive_bins() -> None:
    history = History(1000)
    history.add(rows(0, 500))
    ticks = rows(0, 500)
    ticks["energy"] = np.arange(500)
    history = History(1000)
    history.add(ticks)
    edges = [0, 7, 7, 100, 499, 500]
    pieces = [history.bins(a, b, 16) for a, b in itertools.pairwise(edges)]
    energy = KEYS.index("energy")
    low = np.concatenate([piece.low[:, energy] for piece in pieces])
    high = np.concatenate([piece.high[:, energy] for piece in pieces])
    assert low[0] == 0
    assert high[-1] == 499
    assert np.array_equal(low[1:], high[:-1] + 1)


def test_rows_of_an_earlier_life_are_forgotten() -> None:
    history = History(1000)
    history.add(rows(0, 100))
    history.forget()
    assert history.newest is None
    assert len(history.bins(0, 1000, 16).t) == 0
    history.add(rows(0, 32))
    assert len(history.bins(0, 1000, 16).t) == 2
    assert history.newest is not None
    assert history.newest[0]["tick"] == 31


def test_plot_message_has_the_documented_layout() -> None:
    history = History(1000)
    history.add(rows(0, 40))
    message = encode_plot(history.bins(0, 40, 16))
    kind, count = np.frombuffer(message, "<u4", 2)
    assert (kind, count) == (2, 3)
    assert len(message) == 8 + count * (8 + 2 * 4 * len(CHANNELS))
    assert np.allclose(np.frombuffer(message, "<f8", count, 8), [0.007, 0.023, 0.035])
