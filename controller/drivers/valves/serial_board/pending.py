"""Commands that wait for their answer: matched however late it comes, judged by the timeout, counted."""

from collections import deque
from typing import NamedTuple

import numpy as np

from controller.drivers.valves.serial_board.frames import State

KEPT = 256
"""Commands whose answer may still come."""
WINDOW = 8
"""Commands on their way at most: on a line that is too slow for them each further one would only come later."""
SILENCE_NS = 100_000_000
"""After so long without an answer and without a command the next one leaves all the same [ns]."""
RECENT = 100
"""Answers by which it is judged whether they come late."""
LATE_MIN, LATE_SHARE_MIN = 5, 0.1
"""So many of them, and that share, are a line that answers late; fewer are a machine that was busy once."""


class Match(NamedTuple):
    """The command that an answer belongs to."""

    asked_ns: int
    """When it was sent, on our monotonic clock."""
    lost: int
    """Commands before it that will have no answer any more: the line keeps the order."""


class Pending:
    """What was sent and not answered yet, by sequence and host's clock as an answer repeats them."""

    def __init__(self, timeout: float) -> None:
        """`timeout` after which an answer is late [s]."""
        self._timeout = timeout
        self._asked: dict[tuple[int, int], int] = {}
        self._empty_ns = self._active_ns = 0
        self._delays: deque[float] = deque(maxlen=RECENT)
        """Of the latest answers [s]; 0 for one that was in time."""
        self.late = 0
        """Answers that came after the timeout."""

    def forget(self) -> None:
        """None of these will be answered: the board was greeted anew."""
        self._asked.clear()
        self._delays.clear()

    def full(self, now_ns: int) -> bool:
        """Whether as much is on its way as may be, and the line is alive."""
        return len(self._asked) >= WINDOW and now_ns - self._active_ns < SILENCE_NS

    def sent(self, sequence: int, host_us: int, asked_ns: int) -> None:
        """Note a command that leaves at `asked_ns`."""
        self._asked[sequence, host_us] = self._active_ns = asked_ns
        if len(self._asked) > KEPT:
            del self._asked[next(iter(self._asked))]

    def line_was_empty(self, at_ns: int) -> None:
        """Nothing had come by `at_ns` that is not read: so a program that paused calls no answer late."""
        self._empty_ns = at_ns

    def answered(self, state: State, answered_ns: int) -> Match | None:
        """The command that `state` answers; None where none waits for it."""
        key, lost = (state.sequence, state.host_us), 0
        if key not in self._asked:
            return None
        while (first := next(iter(self._asked))) != key:
            del self._asked[first]
            lost += 1
        asked_ns, self._active_ns = self._asked.pop(key), answered_ns
        late = self._empty_ns - asked_ns >= self._timeout * 1e9
        self.late += late
        self._delays.append(1e-9 * (answered_ns - asked_ns) if late else 0.0)
        return Match(asked_ns, lost)

    @property
    def notice(self) -> str:
        """As "answers come after 15 ms, timeout is 10 ms"; "" where they come in time."""
        delays = list(self._delays)
        late = [delay for delay in delays if delay > 0.0]
        if len(late) < max(LATE_MIN, LATE_SHARE_MIN * len(delays)):
            return ""
        return f"answers come after {1e3 * np.median(late):.0f} ms, timeout is {1e3 * self._timeout:g} ms"
