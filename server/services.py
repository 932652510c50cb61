"""What the server is made of, put together once; routes and sockets receive it and nothing else."""

import asyncio
from dataclasses import dataclass, field
from pathlib import Path

from controller.errors import RigUnreachable
from controller.messages import RigInfo
from controller.parameters import Settings
from controller.whole_file import write_whole
from recordings.messages import Recording
from recordings.store import Store, default_folder
from recordings.writer import Recorder
from server.alarms.messages import AlarmLimits
from server.alarms.store import Alarms
from server.alarms.watch import AlarmWatch
from server.audit import LARGEST, Audit, Deed
from server.auth import Identity, Sessions
from server.automatic import Automatic, cut_off
from server.channels import Rows
from server.drawings.store import Drawings
from server.event_file import EventFile
from server.events import EventLog, to_log
from server.history import History
from server.lease import OperatorLease
from server.live import Hub
from server.loop_health import LoopWatch
from server.messages import Event, Health, Session, Status
from server.monitoring.refused import Refused
from server.operator import Operator
from server.people import Company
from server.plots.feed import Plots
from server.plots.layouts import Layouts
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
from server.token_watch import TokenWatch
from server.tokens import Secrets, TokenFile
from server.user_files import UserFiles
from server.watch import Watch


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
    cut: Recording | None
    """What the server before this one was writing when it was killed."""
    automatic: Automatic = field(init=False)
    quota: QuotaWatch = field(init=False)
    recorder_watch: RecorderWatch = field(init=False)
    hub: Hub = field(init=False)
    plots: Plots = field(init=False)
    company: Company = field(init=False)
    watch: Watch = field(init=False)
    alarm_watch: AlarmWatch = field(init=False)
    runs: Runs = field(init=False)
    refused: Refused = field(default_factory=Refused)
    rates: Rates = field(init=False)
    drawings: Drawings = field(init=False)
    settings_lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    """Changes to the settings are merged one after another."""
    preview_lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    """One preview at a time: each keeps a core busy."""
    export_lock: asyncio.Lock = field(default_factory=asyncio.Lock)
    """One export at a time: each keeps a core busy."""

    def __post_init__(self) -> None:
        self.rates = Rates(self.settings.rate_factor)
        self.drawings = Drawings(self.settings.state / "drawings")
        self.hub = Hub(self.history, self.status, self.status_key, self.sight, self.lease.holds)
        self.hub.seats, self.plots = self.settings.viewers_max, Plots(self.history)
        self.company = Company(self.present, self.lease, self.operator, self.events)
        self.watch = Watch(self.rig, self.history, self.lease, self.operator, self.events)
        self.alarm_watch = AlarmWatch(self.loop.lateness_p99, self.operators_limits, self.events)
        self.automatic = Automatic(self.recorder, self.rig, self.review, self.events, lambda: self.operator.settings)
        self.recorder_watch = RecorderWatch(self.recorder, self.events)
        self.quota = QuotaWatch(self.store, self.settings.recordings_quota, self.events)
        results = Results(self.settings.state / f"runs-{self.settings.rig}.json")
        self.runs = Runs(Tracker(self.rig, self.operator), self.lease, self.automatic, self.events, results)
        self.rig.listen(self.runs.inbox.put)
        if self.settings.log_format == "json":
            self.events.listeners.append(to_log)
        self.events.listeners += [self.hub.tell, lambda event: self.recorder.events(event.text, event.level)]

    def require_info(self) -> RigInfo:
        """Who the rig is; `RigUnreachable` before the first contact."""
        if self.rig.info is None:
            raise RigUnreachable(f"no rig was heard yet at {self.settings.endpoint}")
        return self.rig.info

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
        )

    def beat(self) -> None:
        """What is looked at 60 times a second, with or without viewers."""
        self.tokens.look(self.lease, self.events)
        self.watch()
        self.runs.look()
        self.automatic.look(self.settings.record_faults)
        if self.cut and self.history.newest is not None and self.rig.boot() is not None:
            self.automatic.go_on(self.store.path(self.cut.id), self.cut)
            self.cut = None
        self.recorder_watch()
        self.quota()
        newest = self.history.newest if self.rig.boot() is not None else None
        self.alarm_watch(None if newest is None else newest[0])

    def operators_limits(self) -> AlarmLimits:
        """Whose red the log speaks of: that of whoever operates, else the defaults."""
        holder = self.lease.holder
        return self.alarms.read(holder) if holder else AlarmLimits()

    async def keep_settings(self) -> None:
        """Remember the rig's settings over a restart of this server; they are in force even where that fails."""
        try:
            text = self.operator.settings.model_dump_json()
            await asyncio.to_thread(write_whole, _settings_file(self.settings), text)
        except OSError as error:
            self.events.add(f"the settings will not outlive this server: {error}", "warning")

    def close(self) -> None:
        """End commands and link, then run and recording (which have then seen every row), then the 3D view."""
        self.operator.close()
        self.rig.close()
        self.runs.close()
        self.recorder.close()
        self.scene.close()


def open_services(settings: ServerSettings) -> Services:
    """Connect to the rig and start everything that has a thread of its own."""
    tokens, history = TokenFile(settings), History()
    secrets = tokens.read()
    folder = settings.recordings or default_folder()
    store = Store(folder)
    cut = cut_off(store)  # before the review mends it
    review, loop = Review(store), LoopWatch()
    recorder = Recorder(folder, settings.recording_split, lambda done: review.stopped(done.id))

    def keep(rows: Rows) -> None:
        loop.add(rows)
        recorder.rows(rows)

    rig = Rig(settings, history, keep)
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
        operator=Operator(rig.send, rig.boot, lambda: history.newest, kept_settings(settings)),
        recorder=recorder,
        store=store,
        review=review,
        cut=cut,
        scene=Scene(lambda: history.newest, rig.actuator, settings.light_scene),
        events=events,
        layouts=Layouts(UserFiles(settings.state / "layouts", "the layout")),
        alarms=Alarms(UserFiles(settings.state / "alarms", "the limits")),
    )


def _settings_file(settings: ServerSettings) -> Path:
    return settings.state / f"settings-{settings.rig}.json"


def kept_settings(settings: ServerSettings) -> Settings:
    """The settings of the last run; the defaults when there are none, or none that this version understands."""
    try:
        return Settings.model_validate_json(_settings_file(settings).read_text())
    except (OSError, ValueError):  # ValidationError is a ValueError, and so is a file that is no text
        return Settings()
