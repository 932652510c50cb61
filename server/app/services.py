"""What the server is made of, put together once. Every route and socket asks for the parts that it needs, by class."""

import logging
from collections.abc import Callable
from pathlib import Path

from controller.system.event_bus import EventBus
from controller.system.keys import read_key
from controller.system.scheduler import Scheduler
from recordings.format.annotations import LogLine
from recordings.live.channel import RecorderSettings
from recordings.store.store import Store, default_folder
from server.access.ended import EndedSessions
from server.access.lease import OperatorLease
from server.access.permit import Permits
from server.access.sessions import Sessions, cookie_name
from server.access.token_watch import IN_FORCE_S, TokenWatch
from server.access.tokens import TokenFile
from server.access.user_files import UserFiles
from server.drawing.store import Drawings
from server.hardware.commissioning.commissioning import Commissioning
from server.hardware.commissioning.step_run import StepContext
from server.hardware.commissioning.store import CommissionedFile, CommissioningStore, commissioning_file, data_folder
from server.hardware.first_mode.measurement import FirstModeMeasurement, Parts
from server.hardware.first_mode.store import FirstModes, modes_file
from server.hardware.outcomes import OUTCOME_S, Change, OutcomeWatch
from server.hardware.places import AllowedPlaces
from server.hardware.rig_file import RigFileKeeper
from server.health.alarms import JUDGED_S, Alarms, AlarmWatch
from server.health.energy_balance import EnergyBalance
from server.health.loop_health import LoopWatch
from server.health.monitor import HEALTH_S, HealthMonitor
from server.health.notices import Notices, Webhook
from server.health.on_time import OnTime
from server.http.answers import RefusedCounts
from server.http.rates import Rates
from server.live.hub import FRAME_APART_S, FRAME_S, NEWS_S, Hub, Viewer
from server.live.status import StatusView
from server.log.audit import LARGEST, Audit, AuditEntry
from server.log.event_file import EventFile
from server.log.events import EventLog, LogEntry, to_log
from server.log.line_writer import FILE_NEWS_S
from server.operate.detector import ChangeDetector
from server.operate.events import BootChanged, LeaseChanged, SettingsChanged, TroubleChanged
from server.operate.gains import GainPresets
from server.operate.operator import Operator
from server.operate.pages import Pages
from server.operate.people import PeopleHere
from server.operate.procedure.motion import Context
from server.operate.procedure.procedure import Procedures
from server.operate.reactions import Reactions
from server.operate.settings import KeptSettings
from server.operate.stopper import Stopper
from server.operate.target_control import TargetContext
from server.plots.feed import Plots
from server.plots.layouts import Layouts
from server.recorder.automatic import Automatic
from server.recorder.by_hand import RecordingByHand
from server.recorder.client import RECORDER_S, RecorderClient, RecorderWatch, launch
from server.recorder.exports import EXPORTS_S, Exports
from server.recorder.folder import Reader, RecordingsFolder
from server.recorder.quota_watch import QUOTA_S, QuotaWatch
from server.recorder.review import Review
from server.rig.client import Rig
from server.rig.history import History, Largest
from server.rig.planner import Planner
from server.runs.learning.plans import Plans
from server.runs.macros.acts import Acts
from server.runs.macros.macros import Macros
from server.runs.macros.store import MacroStore
from server.runs.previews import Previews
from server.runs.results import Results, RunEnded
from server.runs.runs import Runs
from server.runs.tracker import Tracker
from server.scene.scene import Scene
from server.scene.viser_files import ViserFiles
from server.settings import ServerSettings

log = logging.getLogger(__name__)


class Services:
    """The parts, each made once from what it needs, in the order of what they need: a room at a time.

    A part that has a thread of its own works from here on; `close` ends them.
    """

    def __init__(
        self,
        settings: ServerSettings,
        deadly: Callable[[], None] | None = None,
        planner: Planner | None = None,
        reader: Reader | None = None,
        launch_recorder: Callable[[RecorderSettings, bool], None] = launch,
    ) -> None:
        """Connect to the rig and start all, for a server at `settings.port`. `deadly` is called where the event loop
        does not turn any more; `planner` and `reader` are used instead of such of its own, and `launch_recorder` starts
        a recorder where there is none.
        """
        self.settings = settings
        self.planner, self.reader = planner or Planner(), reader or Reader()
        self.scheduler = Scheduler(deadly)
        self.bus = EventBus(self.scheduler)
        self._log_and_access()
        self._rig(launch_recorder)
        self._people()
        self._recordings()
        self._runs()
        self._rig_made_known()
        self._health_and_news()
        self._begin()

    def by_class(self) -> dict[type, object]:
        """Every part by its class."""
        return {type(part): part for part in vars(self).values()}

    def close(self) -> None:
        """End plans, commands and link, then run and recording (which have then seen every row), then the 3D view."""
        first = (self.tokens.stop, self.planner.stop, self.reader.stop)
        then = (self.operator, self.rig, self.procedures, self.results, self.recorder, self.review)
        last = (self.scene, self.webhook, self.events.writer, self.audit.writer, self.folder, self.exports)
        ends: list[Callable[[], object]] = [*first, *(part.close for part in (*then, *last) if part is not None)]
        for end in ends:
            try:
                end()
            except Exception:  # one that fails ends the others no less
                log.exception("%s failed", getattr(end, "__qualname__", end))

    def _log_and_access(self) -> None:
        file = TokenFile(self.settings)
        self.secrets, self.rates, self.refused = file.made(), Rates(self.settings.rate_factor), RefusedCounts()
        ended = EndedSessions(self._state(f"sessions-{self.settings.port}"))
        cookie = cookie_name(self.settings.rig, self.settings.port)
        self.sessions = Sessions(self.secrets, cookie, ended, self.rates)
        self.lease = OperatorLease(self.scheduler.watchdog.listened, self.settings.control_lapse)
        self.events = EventLog(EventFile(self._state("events", "jsonl"), LogEntry), in_turn=self.scheduler.in_turn)
        if self.settings.log_format == "json":
            self.events.listen(to_log)
        self.scheduler.tell = lambda text: self.events.add(text, "error")
        self.tokens = TokenWatch(file, self.sessions, self.secrets, self.lease, self.events)
        audited = EventFile(self._state("audit", "jsonl"), AuditEntry, LARGEST)
        self.audit = Audit(audited, lambda problem: self.events.add(problem, "error"))

    def _rig(self, launch_recorder: Callable[[RecorderSettings, bool], None]) -> None:
        settings = self.settings
        self.store = Store(settings.recordings or default_folder())
        self.review, self.loop, self.history = Review(self.store, self.reader), LoopWatch(), History()
        self.on_time, self.energy = OnTime(), EnergyBalance()
        self.history.listen(self.loop.add)
        self.history.listen(self.on_time.add)
        self.history.listen(self.energy.add)
        self.rig = Rig(settings, self.history)
        recording = RecorderSettings(
            settings.rig,
            settings.endpoint,
            self.store.folder,
            settings.recording_split,
            settings.disk_patience,
            settings.link_tls,
            read_key(settings.key),
        )
        ended = self.review.stopped
        self.recorder = RecorderClient(recording, self.rig.seen, lambda done: ended(done.id), launch_recorder)
        self.events.listen(lambda event: self.recorder.annotate(LogLine(event.text, event.level)))
        self.permits = Permits(self.lease, self.sessions, self.rig.operator_timeout)
        self.kept = KeptSettings(self._state("settings"), self.events, lambda: self.rig.info)

    def _people(self) -> None:
        rig, lease, history, events = self.rig, self.lease, self.history, self.events
        stopper = Stopper(rig.stop, lambda: rig.met, rig.send_stop)
        self.operator = Operator(rig.send, rig.boot, lambda: history.newest, self.kept.read(), stopper)
        history.listen(lambda rows: self.operator.acknowledgements.look())
        self.control = TargetContext(lease, self.permits, self.operator, history, events)
        self.pages: Pages[Viewer] = Pages(lease, self.settings.viewers_max)
        events.listen(self.pages.tell)
        self.people = PeopleHere(self.pages.present, lease, self.operator, self.permits, events)

    def _recordings(self) -> None:
        settings, rig, operator, events = self.settings, self.rig, self.operator, self.events
        self.automatic = Automatic(
            self.recorder,
            rig,
            self.review,
            events,
            lambda: operator.settings,
            lambda: settings.record_faults,
            self.scheduler,
        )
        self.folder, self.exports = RecordingsFolder(self.store, self.reader), Exports(self.scheduler)
        self.by_hand = RecordingByHand(self.recorder, self.folder, self.review, rig, operator, events, self.scheduler)

    def _runs(self) -> None:
        rig, operator, events, state = self.rig, self.operator, self.events, self.settings.state
        self.results = Results(self._state("runs"), self.bus.publish)
        self.steps = CommissioningStore(commissioning_file(state, self.settings.rig))
        context = Context(rig, self.history, operator, self.kept, events, self.steps)
        self.procedures = Procedures(context, self.scheduler)
        tracker = Tracker(rig, operator)
        lessons = state / f"learned-{self.settings.rig}"
        self.plans = Plans(self.planner, lessons, events)
        self.runs = Runs(self.procedures, tracker, self.plans, self.automatic, self.results)
        self.history.listen(self.runs.inbox.put)
        self.modes = FirstModes(modes_file(state, self.settings.rig))
        self.previews = Previews(self.planner, self.modes.twin_of, lessons)
        self.drawings = Drawings(state / "drawings")
        gains = GainPresets(state / "gains.json")
        acts = Acts(self.runs, self.by_hand, self.drawings, gains.changes)
        self.macros = Macros(acts, self.procedures)
        self.macro_store = MacroStore(UserFiles(state / "macros", "the macro"))
        self.scene = Scene(lambda: self.history.newest, rig.actuator, self.settings.light_scene)
        self.viser_files = ViserFiles(self.scene.port)
        self.plots, self.layouts = Plots(self.history), Layouts(UserFiles(state / "layouts", "the layout"))

    def _rig_made_known(self) -> None:
        """First mode, another actuator, commissioning."""
        settings, rig, operator = self.settings, self.rig, self.operator
        self.outcomes = OutcomeWatch(settings, self.events)
        self.first_mode = FirstModeMeasurement(Parts(self.procedures, self.planner, self.modes))
        change = Change(rig, self.outcomes, self.recorder, operator, self.events, settings)
        self.allowed_places = AllowedPlaces(settings.allow_reach)
        data = data_folder(settings.state, settings.rig)
        self.commissioning = Commissioning(
            StepContext(self.procedures, self.steps, self.planner, rig.drivers, data, self.modes),
            CommissionedFile(RigFileKeeper(self.planner, change, self.allowed_places)),
        )

    def _health_and_news(self) -> None:
        rig, operator, events = self.rig, self.operator, self.events
        hook = self.settings.webhook
        self.webhook = Webhook(hook.get_secret_value()) if hook else None
        self.detector = ChangeDetector(rig, self.lease, operator, self.bus)
        self.history.listen(self.detector.rows)
        Reactions(rig, operator, self.people, events, self.bus)
        self.alarms = Alarms(UserFiles(self.settings.state / "alarms", "the limits"))
        parts = (rig, operator, operator.stopper, self.recorder, self.review, self.scene, self.tokens)
        maybe = (self.webhook, events.writer, self.audit.writer)
        threads = [part.worker for part in (*parts, *maybe) if part is not None]
        self.monitor = HealthMonitor([self.recorder, *threads], self.scheduler, events)
        doing = (self.recorder, self.runs, self.macros, self.outcomes, self.first_mode)
        about = (self.on_time, self.energy, lambda: self.monitor.trouble)
        self.view = StatusView(rig, self.lease, self.people, self.pages, operator, *doing, *about)
        self.hub = Hub(self.history, self.pages, self.lease, self.view, self.scheduler.guard, self.settings.frame_rate)

    def _begin(self) -> None:
        """What is called again and again, and what is heard."""
        scheduler, events, every = self.scheduler, self.events, self.scheduler.every
        with_rows = {
            "the procedure under way": self.procedures.look,
            "automatic recordings": self.automatic.look,
            "the live sockets": self.hub.frame,  # last: pages are told of what came of these
        }
        for name, call in with_rows.items():
            every(FRAME_S, name, call, FRAME_APART_S)
        self.history.listen(lambda rows: scheduler.soon(lambda: scheduler.hasten(*with_rows)))
        every(NEWS_S, "rig, lease and settings", self.detector.look)
        every(NEWS_S, "the news of the status", self.hub.announce, FRAME_APART_S)
        for kind in (BootChanged, TroubleChanged, LeaseChanged, SettingsChanged, RunEnded):
            told = "the status of what changed"
            self.bus.subscribe(kind, told, lambda event: scheduler.hasten("the news of the status"))
        events.listen(lambda line: scheduler.soon(lambda: scheduler.hasten("the news of the status")))
        every(IN_FORCE_S, "the access tokens", self.tokens.look)
        every(RECORDER_S, "the recorder", RecorderWatch(self.recorder, events).look)
        every(OUTCOME_S, "another actuator", self.outcomes.look)
        every(HEALTH_S, "the server's own health", self.monitor.check)
        every(JUDGED_S, "the alarms", self._alarm_watch().judge)
        every(FILE_NEWS_S, "the event log", events.look)
        every(FILE_NEWS_S, "the audit log", self.audit.look)
        if self.webhook is not None:
            every(FILE_NEWS_S, "the notices", Notices(self.settings.rig, self.webhook, events, self.bus).look)
        every(EXPORTS_S, "exports that are fetched too late", self.exports.look)
        most = self.settings.recordings_quota
        quota = QuotaWatch(self.store, most, self.recorder, self.review, events, scheduler)
        every(QUOTA_S, "the recordings' size", quota.look)
        self.tokens.start()

    def _alarm_watch(self) -> AlarmWatch:
        rig, history = self.rig, self.history
        return AlarmWatch(
            lambda: history.newest[0] if history.newest is not None and rig.boot() is not None else None,
            Largest(history, "server_age").take,
            self.loop.lateness_p99,
            lambda: self.pages.round_trip,
            self.on_time,
            lambda: self.alarms.known(self.lease.holder),
            self.events,
        )

    def _state(self, name: str, suffix: str = "json") -> Path:
        """The file of this rig that keeps `name`."""
        return self.settings.state / f"{name}-{self.settings.rig}.{suffix}"
