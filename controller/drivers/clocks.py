"""From a device's clock to ours: an offset that is estimated all the while, whatever the clocks drift."""

from collections import deque

WINDOW_NS = 30_000_000_000
"""Over which the quickest message counts [ns]; two clocks of 100 ppm drift apart by 3 ms in it at most."""
BUCKET_NS = 500_000_000
"""The quickest of each half second are kept [ns]."""
DRIFT_MAX = 2e-4
"""Ratio by which two sound clocks go apart at most."""
SLEW, SETTLING_NS = 1e-3, 2_000_000_000
"""An offset moves no faster than this ratio, once it has settled [ns]."""


class OneWayClock:
    """Offset by the quickest arrivals: it cannot know the shortest way itself, which stays in every time of capture."""

    def __init__(self) -> None:
        self._least: deque[tuple[int, int]] = deque()
        """(device's time, ours minus the device's) of the quickest of each bucket [ns]."""

    def heard(self, device_ns: int, arrived_ns: int) -> int:
        """Note a message stamped `device_ns` that came at `arrived_ns`; its time on our clock [ns]."""
        apart = arrived_ns - device_ns
        if self._least and abs(apart - self.offset_ns(device_ns)) > 1_000_000_000:
            self._least.clear()  # the device began again, or its clock was set
        if self._least and device_ns - self._least[-1][0] < BUCKET_NS:
            if apart < self._least[-1][1]:
                self._least[-1] = (device_ns, apart)
        else:
            self._least.append((device_ns, apart))
        while device_ns - self._least[0][0] > WINDOW_NS:
            self._least.popleft()
        return min(device_ns + self.offset_ns(device_ns), arrived_ns)

    def offset_ns(self, device_ns: int) -> int:
        """Ours minus the device's at `device_ns`: the least seen, each allowed to have drifted up since [ns]."""
        return min(apart + int(DRIFT_MAX * abs(device_ns - at)) for at, apart in self._least)


class TwoWayClock:
    """Offset by questions and answers, as NTP does it: the quickest of late halves the way there and back.

    A better answer moves the offset slowly: at once it would put a jump into the times of samples, and so into speeds.
    """

    def __init__(self) -> None:
        self._answers: deque[tuple[int, int, int]] = deque()
        """(when, way there and back, offset) of the quickest of each bucket [ns]."""
        self._bucket = self._last = 0
        """When the newest bucket was begun, and the last answer came [ns]."""
        self._first = 0
        self.offset_ns = 0
        """Ours minus the device's [ns]."""

    def answered(self, asked_ns: int, device_ns: int, answered_ns: int) -> None:
        """A question left at `asked_ns`, the device answered at its `device_ns`, and that came at `answered_ns`."""
        way = answered_ns - asked_ns
        offset = asked_ns + way // 2 - device_ns
        if not self._answers or abs(offset - self._answers[-1][2]) > 1_000_000_000:
            self._answers.clear()
            self._first = self._last = answered_ns
        if not self._answers or answered_ns - self._bucket >= BUCKET_NS:
            self._answers.append((answered_ns, way, offset))
            self._bucket = answered_ns
        elif way < self._answers[-1][1]:
            self._answers[-1] = (answered_ns, way, offset)
        while answered_ns - self._answers[0][0] > WINDOW_NS:
            self._answers.popleft()
        since, self._last = answered_ns - self._last, answered_ns
        most = int(SLEW * since)
        change = self._best() - self.offset_ns
        settled = answered_ns - self._first > SETTLING_NS
        self.offset_ns += min(most, max(-most, change)) if settled else change

    @property
    def known(self) -> bool:
        """Whether there was an answer yet."""
        return bool(self._answers)

    def ours(self, device_ns: int) -> int:
        """A time of the device on our clock [ns]."""
        return device_ns + self.offset_ns

    def _best(self) -> int:
        """Offset of the quickest answer, each older one held to be a little slower [ns]."""
        now = self._last
        return min(self._answers, key=lambda one: one[1] + 2 * DRIFT_MAX * (now - one[0]))[2]
