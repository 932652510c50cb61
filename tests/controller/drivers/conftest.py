"""A camera that never stops: frames from any capture peer, in a thread."""

import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import pytest

POINTS = np.array([[0.1, 0.2, 0.3], [np.nan] * 3, [0.7, 0.8, 0.9], [0.4, 0.5, 0.6]])
LABELS = ("tip", "hidden", "mid", "")


@contextmanager
def showing(peer, late=0.0, points=POINTS, labels=LABELS, period=0.005) -> Iterator[None]:
    """Plug `peer` in and show the same points, captured `late` seconds before they are sent."""
    done = threading.Event()

    def show():
        while not done.wait(period):
            peer.show(time.monotonic_ns() - round(late * 1e9), points, labels)

    thread = threading.Thread(target=show)
    peer.plug()
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
        peer.unplug()


def frames(device, count, timeout=20.0):
    """The next `count` samples with the times at which they were read [ns]."""
    found = []
    deadline = time.monotonic() + timeout
    while len(found) < count and time.monotonic() < deadline:
        if (sample := device.read(0.1)) is not None:
            found.append((sample, time.monotonic_ns()))
    assert len(found) == count, f"{len(found)} frames of {count} within {timeout} s"
    return found


def named(sample):
    """Label to position, None where it is nan."""
    return {
        label: None if np.isnan(at).any() else [round(x, 4) for x in at.tolist()]
        for label, at in zip(sample.labels, sample.points, strict=True)
    }


@pytest.fixture
def opened():
    """Opens devices, and closes them at the end."""
    devices = []

    def open_(device):
        devices.append(device)
        device.open()
        return device

    yield open_
    for device in devices:
        device.close()
