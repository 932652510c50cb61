"""What the server is made of, put together once; routes and sockets receive it and nothing else."""

import asyncio
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import partial
from typing import ParamSpec, TypeVar

from controller.arrays import Rows
from controller.errors import RigUnreachable, TendrilError
from controller.schema.messages import RigInfo
from controller.schema.parameters import RigParameters, Settings
from controller.system.worker import Worker
from recordings.store.store import Store, default_folder
from recordings.write.writer import Recorder
from server.alarms.messages import AlarmLimits
from server.alarms.store import Alarms
from server.alarms.watch import AlarmWatch
from server.audit import LARGEST, Audit, Deed
from server.auth import Identity, Sessions
from server.automatic import Automatic
from server.drawings.store import Drawings
from server.event_file import EventFile
from server.events import EventLog, to_log
from server.history import History
from server.lease import OperatorLease
from server.live import Hub
from server.loop_health import LoopWatch
from server.loop_watchdog import LoopWatchdog
from server.messages import Event, Health, Session, Status
from server.monitoring.refused import Refused
from server.operator import Operator
from server.people import Company
from server.permit import Permits
from server.plots.feed import Plots
from server.plots.layouts import Layouts
from server.presets.actuator import OutcomeWatch
from server.quota_watch import QuotaWatch
from server.rates import Rates
from server.recorder_watch import RecorderWatch
from server.review import Review
from server.rig import Rig
from server.runs.results import Results
from server.runs.runs import Runs
from server.runs.tracker import Tracker
from server.scene import Scene
from server.settings import ServerSettings
from server.soundness import Soundness
from server.state_file import StateFile
from server.stopper import Stopper
from server.token_watch import TokenWatch
from server.tokens import Secrets, TokenFile
from server.user_files import UserFiles
from server.watch import Watch

P = ParamSpec("P")
T = TypeVar("T")
LOOKERS = 4
"""Threads that may wait for the folder of recordings."""
LOOK_TIMEOUT = 30.0
"""Longest wait for an answer of it [s]: a long recording's quick look takes seconds."""


@dataclass
class Services:
    """The parts. `open_services` makes them, `close` ends them."""

    settings: ServerSettings
    secrets: Secrets
    sessions: Sessions
    tokens: TokenWatch
    audit: Audit
    lease: OperatorLease
    history: History
    loop: LoopWatch
    rig: Rig
    operator: Operator
    recorder: Recorder
    store: Store
    review: Review
    scene: Scene
    events: EventLog
    layouts: Layouts
    alarms: Alarms
    permits: Permits = field(init=False)
    automatic: Automatic = field(init=False)
    quota: QuotaWatch = field(init=False)
    recorder_watch: RecorderWatch = field(init=False)
    hub: Hub = field(init=False)
    plots: Plots = field(init=False)
    company: Company = field(init=False)
    watch: Watch = field(init=False)
    outcomes: OutcomeWatch = field(init=False)
    alarm_watch: AlarmWatch = field(init=False)
    results: Results = field(init=False)
    runs: Runs = field(init=False)
    turning: LoopWatchdog = field(default_factory=LoopWatchdog)
    soundness: Soundness = field(init=False)
    refused: Refused = field(default_factory=Refused)
    rates: Rates = field(init=False)
    drawings: Drawings = field(init=False)
    lookers: ThreadPoolExecutor = field(default_factory=lambda: ThreadPoolExecutor(LOOKERS, "recordings-folder"))
    settings_lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    """Changes to the settings are merged one after another."""
    preview_lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    """One preview at a time: each keeps a core busy."""
    export_lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    """One export at a time: each keeps a core busy."""

    def __post_init__(self) -> None:
        self.rates = Rates(self.settings.rate_factor)
        self.permits = Permits(self.lease, self.sessions, self._operator_timeout)
        self.drawings = Drawings(self.settings.state / "drawings")
        self.hub = Hub(self.history, self.status, self.status_key, self.sight, self.lease.holds)
        self.hub.seats, self.plots = self.settings.viewers_max, Plots(self.history)
        self.company = Company(self.present, self.lease, self.operator, self.permits, self.events)
        self.watch = Watch(self.rig, self.history, self.lease, self.operator, self.events)
        self.outcomes = OutcomeWatch(self.settings.orders, self.events)
        self.alarm_watch = AlarmWatch(self.loop.lateness_p99, self.operators_limits, self.events)
        self.automatic = Automatic(self.recorder, self.rig, self.review, self.events, lambda: self.operator.settings)
        self.recorder_watch = RecorderWatch(self.recorder, self.events)
        self.quota = QuotaWatch(self.store, self.settings.recordings_quota, self.events)
        self.results = Results(self.settings.state / f"runs-{self.settings.rig}.json")
        self.runs = Runs(Tracker(self.rig, self.operator), self.automatic, self.events, self.results)
        self.rig.listen(self.runs.inbox.put)
        self.tokens.start()
        self.soundness = Soundness(self._workers(), self.hub.looks, self.turning, self.events)
        if self.settings.log_format == "json":
            self.events.listeners.append(to_log)
        self.events.listeners += [self.hub.tell, lambda event: self.recorder.events(event.text, event.level)]

    def require_info(self) -> RigInfo:
        """Who the rig is; `RigUnreachable` before the first contact."""
        if self.rig.info is None:
            raise RigUnreachable(f"no rig was heard yet at {self.settings.endpoint}")
        return self.rig.info

    def _operator_timeout(self) -> float:
        """For how long the rig takes a sign of the operator's page [s]."""
        return (self.rig.info.parameters if self.rig.info else RigParameters()).limits.operator_timeout

    async def look(self, work: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
        """`work` on the folder of recordings, in one of a few threads that only wait for it; TendrilError when it does
        not answer: a network folder that hangs must not hold up what else is done in threads, commands above all.
        """
        found = asyncio.get_running_loop().run_in_executor(self.lookers, partial(work, *arguments, **named))
        try:
            return await asyncio.wait_for(found, LOOK_TIMEOUT)
        except TimeoutError:
            raise TendrilError(f"the folder of recordings does not answer within {LOOK_TIMEOUT:g} s") from None

    def present(self) -> list[Identity]:
        """The session of every open page."""
        return [viewer.who for viewer in self.hub.viewers]

    def session(self, who: Identity) -> Session:
        """What a page should know about its own session."""
        unprotected, lease = self.settings.unprotected, self.lease.view(who)
        return Session(name=who.name, role=who.role, unprotected=unprotected, lease=lease)

    def health(self) -> Health:
        """What is not in a telemetry row."""
        return Health(
            rig_connected=self.rig.boot() is not None,
            rig_age=self.rig.age,
            link_rtt=self.rig.round_trip,
            viewers=len(self.hub.viewers),
            trouble=self.rig.trouble,
            server=self.soundness.trouble,
        )

    def status(self, who: Identity) -> Status:
        """Everything slow that the page shows, as `who` sees it."""
        return Status(
            lease=self.lease.view(who),
            people=self.company.view(who),
            settings=self.operator.settings,
            recording=self.recorder.state(),
            health=self.health(),
            rig=self.rig.info,
            run=self.runs.state(),
            result=self.runs.last(),
        )

    def sight(self, who: Identity) -> str:
        """What of the status is not the same for all."""
        return self.lease.view(who).model_dump_json() + self.company.view(who).model_dump_json()

    def status_key(self) -> object:
        """Differs whenever viewers should be told at once."""
        recording = self.recorder.state()
        rig = (self.rig.boot(), self.rig.info.boot if self.rig.info else None, self.rig.trouble)
        lease, viewers = self.lease.clutch, len(self.hub.viewers)
        return (
            lease,
            self.company.key(),
            self.operator.settings,
            recording.recording,
            recording.id,
            rig,
            viewers,
            self.runs.key(),
            self.soundness.trouble,
        )

    def beat(self) -> None:
        """What is looked at 60 times a second, with or without viewers: each for itself."""
        looks: dict[str, Callable[[], None]] = {
            "the access tokens": lambda: self.tokens.look(self.lease, self.events),
            "rig, lease and mode": self.watch,
            "another actuator": self.outcomes,
            "the run": self.runs.look,
            "automatic recordings": lambda: self.automatic.look(self.settings.record_faults),
            "the recording of a killed server": self._look_at_cut,
            "the recorder": self.recorder_watch,
            "the recordings' size": self.quota,
            "the alarms": self._look_at_alarms,
            "the event log": self.events.look,
            "the audit log": self.audit.look,
            "the server's own soundness": self.soundness,
        }
        for name, look in looks.items():
            self.hub.looks.do(name, look)

    def _look_at_cut(self) -> None:
        if self.review.cut and self.history.newest is not None and self.rig.boot() is not None:
            cut, self.review.cut = self.review.cut, None  # first: it may have been deleted meanwhile
            self.automatic.go_on(self.store.path(cut.id), cut)

    def _look_at_alarms(self) -> None:
        newest = self.history.newest if self.rig.boot() is not None else None
        self.alarm_watch(None if newest is None else newest[0])

    def _workers(self) -> list[Worker]:
        """Every thread of this server that works by itself."""
        writers = [writer.worker for writer in (self.events.writer, self.audit.writer) if writer is not None]
        parts = (self.rig, self.operator, self.operator.stopper, self.recorder, self.review, self.scene, self.tokens)
        return [*(part.worker for part in parts), *writers]

    def operators_limits(self) -> AlarmLimits:
        """Whose red the log speaks of: that of whoever operates, else the defaults."""
        holder = self.lease.holder
        return self.alarms.known(holder) if holder else AlarmLimits()

    async def keep_settings(self) -> None:
        """Remember the rig's settings over a restart of this server; they are in force even where that fails."""
        try:
            text = self.operator.settings.model_dump_json()
            await asyncio.to_thread(_settings_file(self.settings).write, text)
        except OSError as error:
            self.events.add(f"the settings will not outlive this server: {error}", "warning")

    def close(self) -> None:
        """End commands and link, then run and recording (which have then seen every row), then the 3D view."""
        self.tokens.stop()
        self.operator.close()
        self.rig.close()
        self.runs.close()
        self.results.close()
        self.recorder.close()
        self.scene.close()
        for writer in (self.events.writer, self.audit.writer):
            if writer is not None:
                writer.close()
        self.lookers.shutdown(wait=False, cancel_futures=True)


def open_services(settings: ServerSettings) -> Services:
    """Connect to the rig and start everything that has a thread of its own."""
    tokens, history = TokenFile(settings), History()
    secrets = tokens.made()
    folder = settings.recordings or default_folder()
    store = Store(folder)
    review, loop = Review(store), LoopWatch()
    recorder = Recorder(folder, settings.recording_split, lambda done: review.stopped(done.id), settings.disk_patience)

    def keep(rows: Rows) -> None:
        loop.add(rows)
        recorder.rows(rows)

    rig = Rig(settings, history, keep)
    stopper = Stopper(rig.stop, lambda: rig.met)
    events = EventLog(EventFile(settings.state / f"events-{settings.rig}.jsonl", Event))
    audited = EventFile(settings.state / f"audit-{settings.rig}.jsonl", Deed, LARGEST)
    sessions = Sessions(secrets, settings.rig)
    return Services(
        settings=settings,
        secrets=secrets,
        sessions=sessions,
        tokens=TokenWatch(tokens, sessions, secrets),
        audit=Audit(audited, lambda problem: events.add(problem, "error")),
        lease=OperatorLease(),
        history=history,
        loop=loop,
        rig=rig,
        operator=Operator(rig.send, rig.boot, lambda: history.newest, kept_settings(settings), stopper),
        recorder=recorder,
        store=store,
        review=review,
        scene=Scene(lambda: history.newest, rig.actuator, settings.light_scene),
        events=events,
        layouts=Layouts(UserFiles(settings.state / "layouts", "the layout")),
        alarms=Alarms(UserFiles(settings.state / "alarms", "the limits")),
    )


def _settings_file(settings: ServerSettings) -> StateFile[Settings]:
    path = settings.state / f"settings-{settings.rig}.json"
    return StateFile(path, Settings.model_validate_json, "the rig begins with the default settings")


def kept_settings(settings: ServerSettings) -> Settings:
    """The settings of the last run; the defaults when there are none, or none that this version understands."""
    return _settings_file(settings).read() or Settings()
