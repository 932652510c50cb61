"""Key expressions of one rig and the zenoh session both ends open."""

import json
from dataclasses import dataclass
from typing import Any

import zenoh

ENDLESS = 2**62
"""So many ticks of a reference that repeats are followed until something else is asked for."""
LEASE_MS = 1000
"""Silence after which the other end counts as gone (zenoh's own default is 10 s)."""


@dataclass(frozen=True)
class Keys:
    """Every key of one rig."""

    rig: str

    @property
    def telemetry(self) -> str:
        """Publisher: batches of Telemetry rows as raw bytes; attachment: the boot id, int64."""
        return f"tendril/{self.rig}/telemetry"

    @property
    def command(self) -> str:
        """Queryable: one raw Command record -> CommandReply as JSON, after the loop has looked at it."""
        return f"tendril/{self.rig}/command"

    @property
    def replay(self) -> str:
        """Queryable: int64 (first tick, count) -> the rows of them that the ring still holds, raw bytes."""
        return f"tendril/{self.rig}/replay"

    @property
    def info(self) -> str:
        """Queryable: nothing -> RigInfo as JSON."""
        return f"tendril/{self.rig}/info"

    @property
    def reference(self) -> str:
        """Queryable: a planned reference -> the number of its points, int64.

        int64 (point after the last one, ticks to follow in all), then float64 (n, 2) points [m], one a tick.
        """
        return f"tendril/{self.rig}/reference"

    @property
    def faults(self) -> str:
        """Queryable: TwinFaults as JSON to inject, or nothing -> TwinFaults as JSON, those in force."""
        return f"tendril/{self.rig}/faults"

    def alive(self, boot: str) -> str:
        """Liveliness token of one life of the rig process; "*" for any."""
        return f"tendril/{self.rig}/alive/{boot}"


def open_session(*, listen: str | None = None, connect: str | None = None) -> Any:
    """A zenoh session over explicit endpoints only, e.g. "tcp/127.0.0.1:7557".

    No multicast, no shared memory (for rows of 10 kB it only adds tails); a connecting end keeps trying for ever.
    """
    settings: dict[str, Any] = {
        "mode": "peer",
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "listen/endpoints": [listen] if listen else [],
        "connect/endpoints": [connect] if connect else [],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 200, "period_increase_factor": 2},
    }
    config = zenoh.Config()
    for key, value in settings.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)
