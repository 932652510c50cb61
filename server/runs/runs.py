"""The run under way: from what an operator asks for, over the rig's TRACK, to the result that is kept."""

import asyncio
import contextlib
import time
from datetime import UTC, datetime

from controller.errors import CommandRefused, TendrilError
from controller.kernels.inverse import StaticMap
from controller.parameters import RigParameters, Settings
from controller.reference.library import static_map
from server.auth import Identity
from server.automatic import Automatic
from server.drawings.planned import wanted
from server.events import EventLog, Level
from server.lease import OperatorLease
from server.runs.inbox import Inbox
from server.runs.laps import Lap, Leg, first_leg, lap_of, next_leg
from server.runs.messages import RunBody, RunResult, RunState
from server.runs.results import Results
from server.runs.run import About, Run
from server.runs.tracker import PATIENCE, POLL, Tracker

GONE = 5.0
"""A rig that is silent for so long ends its run [s]."""
UPDATES = 8
"""How often pages are told of a run in motion [Hz]."""


class Runs:
    """At most one run at a time. Only the event loop uses it, but for `inbox`, which the link fills."""

    def __init__(
        self, tracker: Tracker, lease: OperatorLease, automatic: Automatic, events: EventLog, results: Results
    ) -> None:
        self.inbox = Inbox()
        self._tracker, self._lease, self._automatic = tracker, lease, automatic
        self._events, self._results = events, results
        self._run: Run | None = None
        self._who: Identity | None = None
        self._life: int | None = None
        self._lock = asyncio.Lock()

    async def start(self, body: RunBody, who: Identity) -> RunState:
        """Plan, approach from where the rig's reference is, and follow.

        Raises CommandRefused where the rig cannot or a run is under way, UnknownReference, and ParameterError for a
        drawing or reference that cannot be followed.
        """
        async with self._lock:
            self._require_free()
            info, settings = self._tracker.require_ready(), self._tracker.settings
            lap = await asyncio.to_thread(_plan, body, info.parameters, settings)
            leg = first_leg(_map(info.parameters), lap, body.laps, await self._tracker.hold())
            if body.record:
                await self._automatic.begin_run(lap.name, who.name)
            try:
                await self._track(leg)
            except TendrilError:
                self._automatic.end_run()
                raise
            number, dt = self._results.next_id(), info.parameters.controller.dt
            run = Run(About(number, lap, body.laps, datetime.now(UTC), dt), leg, self._recording())
            self._run, self._who, self._life = run, who, info.boot
            self._tell(f"started by {who.name}")
            return run.state()

    async def pause(self, who: Identity) -> RunState:
        """Hold, and remember where; raises CommandRefused when no run is in motion."""
        async with self._lock:
            run = self._require_run()
            if not run.moving:
                raise CommandRefused(f"run {run.about.id} is {run.phase}")
            run.ask("paused", f"by {who.name}")
            await self._halt(run)
            if run.phase == "paused":
                self._tell(f"paused by {who.name}")
            return run.state()

    async def resume(self, who: Identity) -> RunState:
        """Go on where it was paused; raises CommandRefused when no run is paused, or the rig cannot."""
        async with self._lock:
            run = self._require_run()
            if run.phase != "paused":
                raise CommandRefused(f"run {run.about.id} is not paused")
            smap, about = _map(self._tracker.require_ready().parameters), run.about
            leg = next_leg(smap, about.lap, about.laps, await self._tracker.hold(), run.left)
            await self._track(leg)
            run.begin(leg)
            self._who = who
            self._tell(f"resumed by {who.name}")
            return run.state()

    async def stop(self, who: Identity) -> RunState:
        """Hold, and end the run; raises CommandRefused when there is none."""
        async with self._lock:
            run, reason = self._require_run(), f"by {who.name}"
            if run.moving:
                run.ask("stopped", reason)
                await self._halt(run)
            else:
                await self._tracker.hold()
                run.end("stopped", reason)
                self._look()
            return run.state()

    def state(self) -> RunState | None:
        """The run under way, or how the last one ended; None before the first."""
        return self._run.state() if self._run else None

    def results(self) -> list[RunResult]:
        """What came of the last runs, newest first."""
        return self._results.all()

    def last(self) -> RunResult | None:
        """What came of the last one; None before the first."""
        return self._results.newest

    def key(self) -> object:
        """Differs whenever pages should be told at once."""
        if self._run is None:
            return None
        state = self._run.state()
        return state.id, state.state, state.reason, int(state.elapsed * UPDATES)

    def look(self) -> None:
        """Called at every beat: read the rig's rows. What is being asked of the rig reads them itself."""
        if not self._lock.locked():
            self._look()

    def close(self) -> None:
        """The server ends, and the rig will hold: keep what came of the run so far."""
        if self._run is not None and not self._run.ended:
            self._run.end("broken off", "the server ended")
            self.inbox.close()
            with contextlib.suppress(OSError):
                self._results.add(self._run.result())

    def _look(self) -> None:
        run = self._run
        if run is None or run.ended:
            return
        batches = list(self.inbox.batches())  # before the life: a new one is known before its rows come
        self._look_around(run)
        before = run.approach
        for rows in batches:
            run.take(rows)
        if run.approach and run.approach != before:
            self._automatic.approach(*run.approach)
        run.recording = run.recording or self._recording()
        if run.ended:
            self._finish(run)

    def _look_around(self, run: Run) -> None:
        """What ends a run though no row says so."""
        if self._tracker.life() != self._life:
            run.end("broken off", "the rig restarted")
        elif self._tracker.age() > GONE:
            run.end("broken off", "the rig is gone")
        elif self._who is not None and not self._lease.holds(self._who):
            reason = f"{self._who.name} no longer operates"
            # The rig is asked to hold by whoever watches over the lease.
            run.ask("broken off", reason) if run.moving else run.end("broken off", reason)

    def _finish(self, run: Run) -> None:
        self.inbox.close()
        self._automatic.end_run()
        result = run.result()
        why = f": {result.reason}" if result.reason else ""
        error = "" if result.rmse is None else f", RMSE {1e3 * result.rmse:.2f} mm"
        self._tell(f"{result.state}{why}{error}", "warning" if result.state == "broken off" else "info")
        try:
            self._results.add(result)
        except OSError as problem:
            self._events.add(f"the result of run {result.id} will not outlive this server: {problem}", "warning")

    async def _track(self, leg: Leg) -> None:
        self.inbox.open()
        await self._tracker.track(leg.p, leg.again, leg.ticks)

    async def _halt(self, run: Run) -> None:
        """Let the rig hold, and wait until the rows have said so."""
        try:
            await self._tracker.hold()
        except TendrilError:
            run.unask()
            raise
        end = time.monotonic() + PATIENCE
        while run.moving and time.monotonic() < end:
            self._look()
            await asyncio.sleep(POLL)

    def _require_free(self) -> None:
        run = self._run
        if run is not None and not run.ended:
            raise CommandRefused(f"run {run.about.id} ({run.about.lap.name}) is {run.phase}; stop it first")

    def _require_run(self) -> Run:
        self._look()
        if self._run is None or self._run.ended:
            raise CommandRefused("no run is under way")
        return self._run

    def _recording(self) -> str | None:
        return self._automatic.recording()

    def _tell(self, text: str, level: Level = "info") -> None:
        assert self._run is not None
        self._events.add(f"run {self._run.about.id} ({self._run.about.lap.name}) {text}", level)


def _plan(body: RunBody, rig: RigParameters, settings: Settings) -> Lap:
    return lap_of(wanted(body, rig, settings), rig, body.laps)


def _map(rig: RigParameters) -> StaticMap:
    return static_map(rig.actuator, rig.controller)
