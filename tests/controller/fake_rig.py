"""A rig whose rows we make up, on the real link: so batches can be lost at will."""

import time
from pathlib import Path

import numpy as np

from controller.link import PlannedRows, RigEnd
from controller.link.keys import open_session
from controller.link.seal import Seals
from controller.schema.layout import layout_hash, record_dtype
from controller.schema.messages import Command, CommandReply, RigInfo, Telemetry, TwinFaults, TwinTime
from controller.schema.modes import Cause, Mode
from controller.schema.parameters import RigParameters
from controller.system.keys import KEY_BYTES

KEY = b"k" * KEY_BYTES


class FakeRig:
    """Rows without a loop; `kept` is the first tick that the ring still holds."""

    def __init__(self, endpoint: str, boot: int, layout: str = "", tls: Path | None = None) -> None:
        self.rows = np.zeros(20_000, record_dtype(Telemetry))
        self.rows["tick"] = np.arange(len(self.rows))
        self.kept = self.replays = 0
        self.busy = 0.0
        """Seconds for which the next replay is late."""
        self.layout = layout or layout_hash(Command, Telemetry)
        self.boot = boot
        self.injected = TwinFaults()
        self.session = open_session(key=KEY, listen=endpoint, tls=tls)
        self.end = RigEnd(self.session, "fake", Seals(KEY, boot, "/rig/fake.key"), self)

    def info(self) -> RigInfo:
        return RigInfo(
            rig="fake",
            boot=self.boot,
            version="0",
            layout=self.layout,
            wall_offset_ns=0,
            policy="none",
            twin=True,
            parameters=RigParameters(),
        )

    def stop(self, who: tuple[int, int], boot: int | None = None, by: str = "") -> CommandReply:
        self.stopped, self.stopped_by = who, by
        return CommandReply(n=1, accepted=True, mode=Mode.E_STOP, cause=Cause.OPERATOR, detail="E_STOP")

    def submit(self, command: Command) -> CommandReply:
        self.commanded = command
        return CommandReply(n=command.n, accepted=True, mode=Mode.HOLD, cause=Cause.NONE, detail="HOLD")

    def replay(self, first: int, count: int) -> np.ndarray:
        self.replays += 1
        time.sleep(self.busy)
        self.busy = 0.0
        return self.rows[max(first, self.kept) : max(first + count, self.kept)]

    def plan(self, rows: PlannedRows) -> int:
        self.planned = rows
        return len(rows.points)

    def faults(self, wanted: TwinFaults | None) -> TwinFaults:
        self.injected = wanted or self.injected
        return self.injected

    def time(self, wanted: TwinTime | None) -> TwinTime:
        return wanted or TwinTime()

    def publish(self, first: int, end: int) -> None:
        self.end.publish(self.rows[first:end])

    def close(self) -> None:
        if not self.session.is_closed():
            self.end.close()
            self.session.close()
