"""The one place that sees what changes about rig, lease and settings: every row is read, and nothing is told twice."""

import threading
from collections.abc import Iterator
from typing import Any

import numpy as np

from controller.arrays import Rows
from controller.schema.modes import Cause, Mode
from controller.system.event_bus import EventBus
from server.access.lease import OperatorLease
from server.http.who import Identity
from server.operate.events import (
    BootChanged,
    LeaseChanged,
    ModeChanged,
    ObserverReseated,
    SettingsChanged,
    TroubleChanged,
)
from server.operate.operator import Operator
from server.rig.client import Rig


class ChangeDetector:
    """`rows` is called by the link's thread with all that comes, `look` every now and then in the event loop."""

    def __init__(self, rig: Rig, lease: OperatorLease, operator: Operator, bus: EventBus) -> None:
        self._rig, self._lease, self._operator, self._bus = rig, lease, operator, bus
        self._lock = threading.Lock()
        self._boot: int | None = None
        self._met: int | None = None
        self._read: int | None = None
        """The boot whose rows were read last."""
        self._last: Rows | None = None
        self._trouble = ""
        self._settings = operator.settings
        lease.listen(self._lease_changed)

    def rows(self, rows: Rows) -> None:
        """Take telemetry rows (n,), oldest first, all of one boot: of a mode that lasts one tick, too, is told."""
        self._look_at_boot()
        if (met := self._rig.met) != self._read:
            self._read, self._last = met, None
        before, self._last = self._last, rows[-1:].copy()
        for row, earlier in _steps(rows, before):
            mode, cause = Mode(int(row["mode"])), Cause(int(row["cause"]))
            if earlier is None or (earlier["mode"], earlier["cause"]) != (row["mode"], row["cause"]):
                was = None if earlier is None else Mode(int(earlier["mode"]))
                self._bus.publish(ModeChanged(int(row["tick"]), mode, cause, was))
            if earlier is not None and row["reseats"] > earlier["reseats"]:
                self._bus.publish(ObserverReseated(int(row["tick"])))

    def look(self) -> None:
        """See what no row says: that the rig is silent, that the lease has lapsed, that settings are in force."""
        self._look_at_boot()
        if (trouble := self._rig.trouble) != self._trouble:
            self._trouble = trouble
            self._bus.publish(TroubleChanged(trouble))
        _ = self._lease.holder  # which tells us where it has lapsed
        before, self._settings = self._settings, self._operator.settings
        if self._settings is not before and self._settings != before:
            self._bus.publish(SettingsChanged(self._settings))

    def _look_at_boot(self) -> None:
        with self._lock:
            if (boot := self._rig.boot()) != self._boot:
                self._bus.publish(BootChanged(boot, self._met))
                self._boot, self._met = boot, boot or self._met

    def _lease_changed(self, before: Identity | None, holder: Identity | None) -> None:
        self._bus.publish(LeaseChanged(before, holder, self._lease.lost(before) if before else ""))


def _steps(rows: Rows, before: Rows | None) -> Iterator[tuple[Any, Any]]:
    """Each of the rows that differs from the one before it in what is told of, and that one, None ahead of all."""
    differs = np.zeros(len(rows), bool)
    differs[0] = before is None
    for name in ("mode", "cause", "reseats"):
        values = rows[name]
        differs[1:] |= values[1:] != values[:-1]
        differs[0] |= before is not None and values[0] != before[name][0]
    for i in np.flatnonzero(differs):
        yield rows[i], rows[i - 1] if i else None if before is None else before[0]
