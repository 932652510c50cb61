"""A client that sends nonsense, as fast as it is answered."""

import json
import time
from collections import Counter
from itertools import cycle, islice

from controller.schema.modes import Mode
from server.campaign import trace
from server.campaign.person import Person
from server.campaign.scene import Scene
from server.campaign.waiting import Seen, require, wait

EACH = 5000
"""Requests, and messages on the socket."""
BATCH = 50
"""Messages on the socket between two waits for their answers."""

REQUESTS: tuple[tuple[str, str, dict[str, object]], ...] = (
    ("POST", "/api/command", {"request": "dance"}),
    ("POST", "/api/command", {"request": "follow", "target": ["a", None]}),
    ("POST", "/api/command", {"request": "follow", "target": [1e9, 0.0]}),
    ("POST", "/api/lease/../../etc/passwd", {"x": 1}),
    ("PATCH", "/api/settings", {"changes": {"K_P": "much"}}),
    ("PATCH", "/api/settings", {"changes": 7}),
    ("POST", "/api/recordings", {"name": "x" * 5000}),
    ("POST", "/api/run", {"reference": "", "laps": -1}),
    ("POST", "/api/run", {"drawing": {"strokes": "none"}}),
    ("PUT", "/api/twin/faults", {"noise": -1}),
    ("GET", "/api/recordings/%00%ff", {}),
    ("GET", "/api/recordings?limit=-5", {}),
    ("DELETE", "/api/recordings/no-such", {}),
)
MESSAGES: tuple[str | bytes, ...] = (
    "",
    "not json",
    "[]",
    '{"type": "dance"}',
    '{"type": "target", "id": 5, "x": NaN, "y": 0}',
    '{"type": "target", "id": 5, "x": 99, "y": 0}',
    '{"type": "target", "id": -1, "x": 0, "y": 0}',
    '{"type": "presence", "n": "many"}',
    '{"type": "plots", "channels": ["../energy"]}',
    "[" * 3000,
    "x" * 5000,
    b"\x01\x02\xff",
    json.dumps({"type": "plots", "channels": ["energy"] * 1000}),
)


def malformed(scene: Scene) -> Seen:
    """From someone who is signed in; strangers are refused before anything is read."""
    scene.track()
    process, boot = scene.server_process, scene.boot
    abuser, gaps = Person(scene.url), _Gaps(scene)
    try:
        codes = _ask(abuser, gaps)
        refused = _shout(abuser, gaps)
    finally:
        abuser.close()
    wrong = {code: count for code, count in codes.items() if not 400 <= code < 500}
    require(not wrong, f"answered with {wrong}")
    require((scene.server_process, scene.boot) == (process, boot), "server or rig was restarted")
    require(scene.mode == Mode.TRACK, f"the rig went to {trace.told(trace.newest(scene.rig))}")
    scene.acts_again()
    answers = ", ".join(f"{count} x {code}" for code, count in sorted(codes.items()))
    return Seen(f"{answers}; {refused} messages refused; TRACK went on", gaps.longest)


class _Gaps:
    """The loop's longest gap [ms], looked at often enough for the ring."""

    def __init__(self, scene: Scene) -> None:
        self.longest = 0.0
        self._scene, self._start = scene, time.monotonic_ns()

    def look(self) -> None:
        """At what was since the last look."""
        start, self._start = self._start, time.monotonic_ns()
        self.longest = max(self.longest, trace.longest_gap_ms(self._scene.since(start)))


def _ask(abuser: Person, gaps: _Gaps) -> Counter[int]:
    """Status codes of all answers."""
    codes: Counter[int] = Counter()
    for number, (method, path, body) in enumerate(islice(cycle(REQUESTS), EACH), 1):
        codes[abuser.request(method, path, **body).status_code] += 1
        if number % BATCH == 0:
            gaps.look()
    return codes


def _shout(abuser: Person, gaps: _Gaps) -> int:
    """Send all, and count the refusals that came back."""
    first = len(abuser.log)
    for number, message in enumerate(islice(cycle(MESSAGES), EACH), 1):
        abuser.shout(message)
        if number % BATCH == 0:
            wait(lambda number=number: _refusals(abuser, first) >= number, 30.0, "refusals")  # type: ignore[misc]
            gaps.look()
    return _refusals(abuser, first)


def _refusals(abuser: Person, first: int) -> int:
    return sum(line.startswith("refused: ") for line in abuser.log[first:])
