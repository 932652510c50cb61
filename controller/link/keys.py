"""Key expressions of one rig and the zenoh session both ends open."""

import json
from pathlib import Path
from typing import Any

import zenoh

from controller.errors import ParameterError, RigUnreachable
from controller.link.guard import guarded

ENDLESS = 2**62
"""Ticks for which a reference that repeats is followed: until something else is asked for."""
REPLAY_MAX = 2000
"""Most rows of one replay: about 2 MB, a sixteenth of what the ring holds."""
NAME_MAX_BYTES = 200
"""Of the name of who pressed an E-STOP, as UTF-8."""
MESSAGE_MAX = 13 * 1024 * 1024
"""Longest message that either end receives [bytes]; zenoh drops a longer one while it arrives."""
LEASE_MS = 1000
"""Silence after which the other end counts as gone (zenoh's own default is 10 s)."""
ACCEPT_MS, ACCEPT_PENDING = 2000, 4000
"""For how long, and how many at once, connections may be open that have not proven to have the key (zenoh: 10 s, 100).

Beyond that number even a server would be turned away: connections that say nothing must not add up to it."""


class Keys:
    """Every key of one rig."""

    def __init__(self, rig: str) -> None:
        self.rig = rig
        self.telemetry = f"tendril/{rig}/telemetry"
        """Publisher: batches of Telemetry rows as raw bytes; attachment: their proof (proof.py)."""
        self.command = f"tendril/{rig}/command"
        """Sealed queryable: one raw Command record -> CommandReply as JSON, after the loop has looked at it."""
        self.stop = f"tendril/{rig}/stop"
        """Sealed queryable: int64, a number that its server gives to one E-STOP -> CommandReply as JSON.

        From any server with the key. It waits for no command, and a repetition with the same number acts once.
        """
        self.replay = f"tendril/{rig}/replay"
        """Queryable: int64 (first tick, count <= REPLAY_MAX) -> the rows of them that the ring still holds, raw."""
        self.info = f"tendril/{rig}/info"
        """Queryable: nothing -> RigInfo as JSON."""
        self.drivers = f"tendril/{rig}/drivers"
        """Queryable: nothing -> Drivers as JSON, how the rig's devices fare."""
        self.reference = f"tendril/{rig}/reference"
        """Sealed queryable: a planned reference -> the number of its points, int64.

        As `controller.link.planned` writes it: points [m] and the torques [N m] that hold them, one a tick.
        """
        self.faults = f"tendril/{rig}/faults"
        """Queryable: TwinFaults as JSON to inject (sealed), or nothing -> TwinFaults as JSON, those in force."""
        self.time = f"tendril/{rig}/time"
        """Queryable: TwinTime as JSON to put in force (sealed), or nothing -> TwinTime as JSON, as it is now."""
        self.session = f"tendril/{rig}/session"
        """Queryable: nothing -> int64 (boot id, next session); sealed with that session, an Introduction -> nothing."""
        self.leave = f"tendril/{rig}/leave"
        """Sealed queryable: nothing -> nothing; another server may command the rig at once."""

    def alive(self, boot: str) -> str:
        """Liveliness token of one boot of the rig process; "*" for any."""
        return f"tendril/{self.rig}/alive/{boot}"


def open_session(*, key: bytes, listen: str | None = None, connect: str | None = None, tls: Path | None = None) -> Any:
    """A zenoh session over explicit endpoints only, e.g. "tcp/127.0.0.1:7557", between ends that have `key` (guard.py).

    No multicast, no shared memory (for rows of 10 kB it only adds tails); a connecting end keeps trying for ever.
    For endpoints tls/... the folder `tls` holds ca.pem, cert.pem and key.pem: each end proves itself to the other.
    """
    if (listen or connect or "").startswith("tls/") and tls is None:
        raise ParameterError(f"endpoint {listen or connect} needs certificates: name their folder with --link-tls")
    settings: dict[str, Any] = {
        "mode": "peer",
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "transport/shared_memory/enabled": False,
        "transport/link/tx/lease": LEASE_MS,
        "transport/link/rx/max_message_size": MESSAGE_MAX,
        "transport/unicast/accept_timeout": ACCEPT_MS,
        "transport/unicast/accept_pending": ACCEPT_PENDING,
        "listen/endpoints": [listen] if listen else [],
        "connect/endpoints": [connect] if connect else [],
        "connect/timeout_ms": -1,
        "connect/exit_on_failure": False,
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 200, "period_increase_factor": 2},
    }
    with guarded(key, listens=listen is not None) as guard:
        config = zenoh.Config()
        for name, value in (settings | guard | (_certificates(tls) if tls else {})).items():
            config.insert_json5(name, json.dumps(value))
        try:
            return zenoh.open(config)
        except zenoh.ZError as error:
            raise RigUnreachable(f"no link at {listen or connect}: {error}") from error


def _certificates(folder: Path) -> dict[str, Any]:
    """Settings for mutual TLS; raises ParameterError naming a file that is not there."""
    authority, own, key = (folder.absolute() / name for name in ("ca.pem", "cert.pem", "key.pem"))
    for path in (authority, own, key):
        if not path.is_file():
            raise ParameterError(f"{path} does not exist: --link-tls needs ca.pem, cert.pem and key.pem in one folder")
    return {
        "transport/link/tls/root_ca_certificate": str(authority),
        "transport/link/tls/listen_certificate": str(own),
        "transport/link/tls/listen_private_key": str(key),
        "transport/link/tls/connect_certificate": str(own),
        "transport/link/tls/connect_private_key": str(key),
        "transport/link/tls/enable_mtls": True,
    }
