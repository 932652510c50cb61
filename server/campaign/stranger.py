"""`python -m server.campaign.stranger FILE`: strangers at the rig's port, in a process of their own, until stdin ends.

FILE holds an `AttackPlan`. Each stranger is a session of zenoh in a thread; at the end stdout says how many rounds of
the attack they made.
"""

import contextlib
import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import zenoh
from pydantic import Base64Bytes

from controller.link.guard import USER
from controller.link.keys import Keys
from controller.schema.layout import Model
from controller.system.thread import SupervisedThread

PAUSE = 0.02
"""Between two rounds of an attack [s]."""
TRIED_MS = 1000
"""For how long a client tries to get in before it tries again [ms]."""
FLOOD = 20
"""Messages of each round of a flood, of each kind."""


class Way(Model):
    """How a stranger comes."""

    mode: str
    password: str = ""
    """Of the session, for one who got past it somehow; what is signed must hold alone then."""


class Message(Model):
    """Recorded."""

    key: str
    payload: Base64Bytes
    seal: Base64Bytes


class AttackPlan(Model):
    """What the strangers do, and all that they may know."""

    attack: str
    ways: list[Way]
    endpoint: str
    tls: Path | None
    """Certificates that the rig trusts, as a machine of the same laboratory may have them."""
    rig: str
    boot: int
    rows: Base64Bytes
    """Forged telemetry."""
    recorded: tuple[Message, ...] = ()


Attack = Callable[[Any, AttackPlan, int], None]


def forge(session: Any, plan: AttackPlan, turn: int) -> None:
    """With the real boot id, and everything that a proof may be made of."""
    key, boot = Keys(plan.rig).telemetry, plan.boot.to_bytes(8, "little")
    number = (2**40 + turn).to_bytes(8, "little")
    for attachment in (boot, None, boot + number + bytes(32), b"x" * 5000):
        session.put(key, plan.rows, attachment=attachment)
    session.put(key, plan.rows[:-1], attachment=boot)
    session.delete(key)


def answer(session: Any, plan: AttackPlan, turn: int) -> None:
    """On the rig's keys, that everything is refused."""

    def refuse(query: Any) -> None:
        with query:
            query.reply_err("refused by a stranger")

    if turn == 0:
        _declare(session, plan, refuse)


def keep_silent(session: Any, plan: AttackPlan, turn: int) -> None:
    """Take every question to the rig and never answer."""
    if turn == 0:
        kept: list[Any] = []
        _declare(session, plan, kept.append)


def flood(session: Any, plan: AttackPlan, turn: int) -> None:
    """Of puts, deletes and questions, on every key."""
    keys = Keys(plan.rig)
    for _ in range(FLOOD):
        for key in (keys.telemetry, keys.command, keys.alive("1")):
            session.put(key, plan.rows)
        session.delete(keys.telemetry)
        session.get(keys.command, lambda reply: None, payload=b"x", timeout=0.1)


def repeat(session: Any, plan: AttackPlan, turn: int) -> None:
    """What was recorded, as it was."""
    for one in plan.recorded:
        session.get(one.key, lambda reply: None, payload=one.payload, attachment=one.seal, timeout=0.5)


ATTACKS: dict[str, Attack] = {attack.__name__: attack for attack in (forge, answer, keep_silent, flood, repeat)}


def _declare(session: Any, plan: AttackPlan, on_query: Callable[[Any], None]) -> None:
    keys = Keys(plan.rig)
    for key in (keys.command, keys.session, keys.replay, keys.info, f"tendril/{plan.rig}/**"):
        session.declare_queryable(key, on_query, complete=True)
    for boot in (plan.boot, 1):
        session.liveliness().declare_token(keys.alive(str(boot)))


class Stranger:
    """Comes again and again until it is told to leave."""

    def __init__(self, way: Way, plan: AttackPlan) -> None:
        self.rounds = 0
        self._plan, self._settings = plan, _settings(way, plan)
        self._thread = SupervisedThread("stranger", self._run)
        self._thread.start()

    def join(self) -> int:
        """How many rounds it made."""
        self._thread.stop()
        return self.rounds

    def _run(self) -> None:
        while not self._thread.stopping:
            with contextlib.suppress(zenoh.ZError):  # a client that is not let in
                self._visit()
            self.rounds += 1

    def _visit(self) -> None:
        config = zenoh.Config()
        for name, value in self._settings.items():
            config.insert_json5(name, json.dumps(value))
        with zenoh.open(config) as session:
            turn = 0
            while not self._thread.wait(PAUSE):
                ATTACKS[self._plan.attack](session, self._plan, turn)
                turn += 1
                self.rounds += 1


def _settings(way: Way, plan: AttackPlan) -> dict[str, Any]:
    settings: dict[str, Any] = {
        "mode": way.mode,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": way.mode == "router",
        "listen/endpoints": [],
        "connect/endpoints": [plan.endpoint],
        "connect/timeout_ms": TRIED_MS if way.mode == "client" else -1,
        "connect/exit_on_failure": way.mode == "client",
        "connect/retry": {"period_init_ms": 100, "period_max_ms": 200, "period_increase_factor": 2},
    }
    if way.password:
        settings["transport/auth/usrpwd"] = {"user": USER, "password": way.password}
    if plan.tls:
        settings["transport/link/tls"] = {
            "root_ca_certificate": str(plan.tls / "ca.pem"),
            "connect_certificate": str(plan.tls / "cert.pem"),
            "connect_private_key": str(plan.tls / "key.pem"),
            "enable_mtls": True,
        }
    return settings


if __name__ == "__main__":
    plan = AttackPlan.model_validate_json(Path(sys.argv[1]).read_bytes())
    strangers = [Stranger(way, plan) for way in plan.ways]
    print("begun", flush=True)
    sys.stdin.read()
    print(min(one.join() for one in strangers), sum(one.rounds for one in strangers))
