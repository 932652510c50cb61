"""What the server is made of, put together once. Every route and socket asks for the parts that it needs, by class."""

from collections.abc import Callable
from dataclasses import dataclass, fields

from controller.system.event_bus import EventBus
from controller.system.keys import read_key
from controller.system.scheduler import Scheduler
from controller.system.thread import SupervisedThread
from recordings.format.annotations import LogLine
from recordings.live.channel import Order
from recordings.store.store import Store, default_folder
from server.access.lease import OperatorLease
from server.access.permit import Permits
from server.access.sessions import Sessions
from server.access.token_watch import IN_FORCE_S, TokenWatch
from server.access.tokens import Secrets, TokenFile
from server.access.user_files import UserFiles
from server.commissioning.commissioning import Commissioning
from server.commissioning.motion import Through
from server.commissioning.store import CommissionedFile, CommissioningStore, commissioning_file, data_folder
from server.drawing.store import Drawings
from server.hardware.rig_file import RigFileKeeper
from server.health.alarm_watch import JUDGED_S, AlarmWatch
from server.health.alarms import Alarms
from server.health.loop_health import LoopWatch
from server.health.monitor import HEALTH_S, HealthMonitor
from server.http.rates import Rates
from server.http.refused import RefusedCounts
from server.live.hub import FRAME_APART_S, FRAME_S, NEWS_S, Hub, Viewer
from server.live.status import StatusView
from server.log.audit import LARGEST, Audit, AuditEntry
from server.log.event_file import EventFile
from server.log.events import Event, EventLog, to_log
from server.log.line_writer import FILE_NEWS_S
from server.notify.notices import Notices
from server.notify.webhook import Webhook
from server.operate.detector import ChangeDetector
from server.operate.events import BootChanged, LeaseChanged, SettingsChanged, TroubleChanged
from server.operate.hand import Hands
from server.operate.operator import Operator
from server.operate.pages import Pages
from server.operate.people import PeopleHere
from server.operate.reactions import Reactions
from server.operate.settings import KeptSettings
from server.operate.stopper import Stopper
from server.plots.feed import Plots
from server.plots.layouts import Layouts
from server.presets.change import Change
from server.presets.first_mode.measurement import FirstModeMeasurement, Parts
from server.presets.first_mode.store import FirstModes, modes_file
from server.presets.gains import GainPresets
from server.presets.outcomes import OUTCOME_S, OutcomeWatch
from server.procedure.motion import Context
from server.procedure.procedure import Procedures
from server.recorder.automatic import Automatic
from server.recorder.by_hand import RecordingByHand
from server.recorder.client import RecorderClient, launch
from server.recorder.exports import EXPORTS_S, Exports
from server.recorder.folder import Reader, RecordingsFolder
from server.recorder.quota_watch import QUOTA_S, QuotaWatch
from server.recorder.review import Review
from server.recorder.watch import RECORDER_S, RecorderWatch
from server.rig.client import Rig
from server.rig.history import History, Largest
from server.rig.planner import Planner
from server.runs.macros.acts import Acts
from server.runs.macros.macros import Macros
from server.runs.macros.store import MacroStore
from server.runs.previews import Previews
from server.runs.results import Results, RunEnded
from server.runs.runs import Runs
from server.runs.tracker import Tracker
from server.scene.scene import Scene
from server.settings import ServerSettings


@dataclass(frozen=True)
class Services:
    """The parts. `open_services` makes them, `close` ends them."""

    settings: ServerSettings
    secrets: Secrets
    sessions: Sessions
    tokens: TokenWatch
    audit: Audit
    events: EventLog
    rates: Rates
    refused: RefusedCounts
    lease: OperatorLease
    permits: Permits
    history: History
    loop: LoopWatch
    rig: Rig
    planner: Planner
    operator: Operator
    kept: KeptSettings
    hands: Hands
    pages: Pages[Viewer]
    people: PeopleHere
    folder: RecordingsFolder
    exports: Exports
    reader: Reader
    recorder: RecorderClient
    review: Review
    automatic: Automatic
    by_hand: RecordingByHand
    drawings: Drawings
    previews: Previews
    results: Results
    runs: Runs
    procedures: Procedures
    macros: Macros
    macro_store: MacroStore
    plots: Plots
    layouts: Layouts
    alarms: Alarms
    outcomes: OutcomeWatch
    modes: FirstModes
    first_mode: FirstModeMeasurement
    commissioning: Commissioning
    scene: Scene
    scheduler: Scheduler
    monitor: HealthMonitor
    view: StatusView
    hub: Hub
    bus: EventBus
    webhook: Webhook | None

    def by_class(self) -> dict[type, object]:
        """Every part by its class."""
        parts = [getattr(self, field.name) for field in fields(self)]
        return {type(part): part for part in parts}

    def close(self) -> None:
        """End plans, commands and link, then run and recording (which have then seen every row), then the 3D view."""
        self.tokens.stop()
        self.planner.stop()
        self.reader.stop()
        self.operator.close()
        self.rig.close()
        self.procedures.close()
        self.runs.close()
        self.results.close()
        self.recorder.close()
        self.scene.close()
        if self.webhook is not None:
            self.webhook.close()
        for writer in (self.events.writer, self.audit.writer):
            if writer is not None:
                writer.close()
        self.folder.close()
        self.exports.close()


def open_services(
    settings: ServerSettings,
    deadly: Callable[[], None] | None = None,
    planner: Planner | None = None,
    reader: Reader | None = None,
    launch_recorder: Callable[[Order, bool], None] = launch,
) -> Services:
    """Connect to the rig and start everything that has a thread of its own. `deadly` is called where the event loop
    does not turn any more; `planner` and `reader` are used instead of such of its own, and `launch_recorder` starts a
    recorder where there is none.
    """
    planner, reader = planner or Planner(), reader or Reader()
    file = TokenFile(settings)
    secrets = file.made()
    scheduler = Scheduler(deadly)
    bus = EventBus(scheduler)
    sessions, lease = Sessions(secrets, settings.rig), OperatorLease(scheduler.watchdog.listened)
    events = EventLog(EventFile(settings.state / f"events-{settings.rig}.jsonl", Event))
    if settings.log_format == "json":
        events.listen(to_log)
    scheduler.tell = lambda text: events.add(text, "error")
    tokens = TokenWatch(file, sessions, secrets, lease, events)
    audited = EventFile(settings.state / f"audit-{settings.rig}.jsonl", AuditEntry, LARGEST)
    audit = Audit(audited, lambda problem: events.add(problem, "error"))

    store = Store(settings.recordings or default_folder())
    review, loop, history = Review(store, reader), LoopWatch(), History()
    history.listen(loop.add)
    rig = Rig(settings, history)
    order = Order(
        settings.rig,
        settings.endpoint,
        store.folder,
        settings.recording_split,
        settings.disk_patience,
        settings.link_tls,
        read_key(settings.key),
    )
    recorder = RecorderClient(order, rig.seen, lambda done: review.stopped(done.id), launch_recorder)
    events.listen(lambda event: recorder.annotate(LogLine(event.text, event.level)))
    permits = Permits(lease, sessions, rig.operator_timeout)
    kept = KeptSettings(settings.state / f"settings-{settings.rig}.json", events, lambda: rig.info)
    stopper = Stopper(rig.stop, lambda: rig.met)
    operator = Operator(rig.send, rig.boot, lambda: history.newest, kept.read(), stopper)
    history.listen(lambda rows: operator.acknowledgements.look())
    hands = Hands(lease, permits, operator, history, events)
    pages: Pages[Viewer] = Pages(lease, settings.viewers_max)
    events.listen(pages.tell)
    people = PeopleHere(pages.present, lease, operator, permits, events)

    automatic = Automatic(
        recorder, rig, review, events, lambda: operator.settings, lambda: settings.record_faults, scheduler
    )
    results = Results(settings.state / f"runs-{settings.rig}.json", bus.publish)
    runs = Runs(Tracker(rig, operator), planner, automatic, events, results)
    history.listen(runs.inbox.put)
    folder, exports, drawings = (
        RecordingsFolder(store, reader),
        Exports(scheduler),
        Drawings(settings.state / "drawings"),
    )
    by_hand = RecordingByHand(recorder, folder, review, rig, operator, events, scheduler)
    gains = GainPresets(settings.state / "gains.json")
    procedures = Procedures(Context(rig, history, operator, kept, events))
    macros = Macros(Acts(rig, operator, kept, runs, by_hand, drawings, gains.changes), rig, operator, events)
    scene = Scene(lambda: history.newest, rig.actuator, settings.light_scene)
    alarms = Alarms(UserFiles(settings.state / "alarms", "the limits"))
    alarm_watch = AlarmWatch(
        lambda: history.newest[0] if history.newest is not None and rig.boot() is not None else None,
        Largest(history, "server_age").take,
        loop.lateness_p99,
        lambda: pages.round_trip,
        lambda: alarms.known(lease.holder),
        events,
    )
    outcomes = OutcomeWatch(settings, events)
    modes = FirstModes(modes_file(settings.state, settings.rig))
    first_mode = FirstModeMeasurement(Parts(procedures, planner, modes))
    change = Change(rig, outcomes, recorder, operator, events, settings)
    rig_file = RigFileKeeper(planner, change)
    commissioning = Commissioning(
        Through(rig, history, operator, kept, planner, rig.drivers, data_folder(settings.state, settings.rig), modes),
        CommissioningStore(commissioning_file(settings.state, settings.rig)),
        CommissionedFile(rig_file),
        events,
    )
    webhook = Webhook(settings.webhook.get_secret_value()) if settings.webhook else None
    detector = ChangeDetector(rig, lease, operator, bus)
    history.listen(detector.rows)
    Reactions(rig, operator, events, bus)

    parts = (rig, operator, stopper, recorder, review, scene, tokens)
    workers: list[SupervisedThread | RecorderClient] = [recorder, *(part.worker for part in parts)]
    workers += [webhook.worker] if webhook else []
    workers += [writer.worker for writer in (events.writer, audit.writer) if writer is not None]
    monitor = HealthMonitor(workers, scheduler, events)
    doing = (recorder, runs, macros, outcomes, first_mode)
    view = StatusView(rig, lease, people, pages, operator, *doing, lambda: monitor.trouble)
    hub = Hub(history, pages, lease, view, scheduler.guard)
    every, listen = scheduler.every, history.listen
    with_rows = {
        "the run": runs.look,
        "the macro": macros.look,
        "procedures": procedures.look,
        "the commissioning": commissioning.look,
        "automatic recordings": automatic.look,
        "the live sockets": hub.frame,  # last: pages are told of what came of these
    }
    for name, call in with_rows.items():
        every(FRAME_S, name, call, FRAME_APART_S)
    listen(lambda rows: scheduler.soon(lambda: scheduler.hasten(*with_rows)))
    every(NEWS_S, "rig, lease and settings", detector.look)
    every(NEWS_S, "the news of the status", hub.announce, FRAME_APART_S)
    for kind in (BootChanged, TroubleChanged, LeaseChanged, SettingsChanged, RunEnded):
        bus.subscribe(kind, "the status of what changed", lambda event: scheduler.hasten("the news of the status"))
    events.listen(lambda line: scheduler.soon(lambda: scheduler.hasten("the news of the status")))
    every(IN_FORCE_S, "the access tokens", tokens.look)
    every(RECORDER_S, "the recorder", RecorderWatch(recorder, events).look)
    every(OUTCOME_S, "another actuator", outcomes.look)
    every(HEALTH_S, "the server's own health", monitor.check)
    every(JUDGED_S, "the alarms", alarm_watch.judge)
    every(FILE_NEWS_S, "the event log", events.look)
    every(FILE_NEWS_S, "the audit log", audit.look)
    if webhook is not None:
        every(FILE_NEWS_S, "the notices", Notices(settings.rig, webhook, events, bus).look)
    every(EXPORTS_S, "exports that are fetched too late", exports.look)
    every(QUOTA_S, "the recordings' size", QuotaWatch(store, settings.recordings_quota, events, scheduler).look)
    tokens.start()
    return Services(
        settings=settings,
        secrets=secrets,
        sessions=sessions,
        tokens=tokens,
        audit=audit,
        events=events,
        rates=Rates(settings.rate_factor),
        refused=RefusedCounts(),
        lease=lease,
        permits=permits,
        history=history,
        loop=loop,
        rig=rig,
        planner=planner,
        operator=operator,
        kept=kept,
        hands=hands,
        pages=pages,
        people=people,
        folder=folder,
        exports=exports,
        reader=reader,
        recorder=recorder,
        review=review,
        automatic=automatic,
        by_hand=by_hand,
        drawings=drawings,
        previews=Previews(planner),
        results=results,
        runs=runs,
        procedures=procedures,
        macros=macros,
        macro_store=MacroStore(UserFiles(settings.state / "macros", "the macro")),
        plots=Plots(history),
        layouts=Layouts(UserFiles(settings.state / "layouts", "the layout")),
        alarms=alarms,
        outcomes=outcomes,
        modes=modes,
        first_mode=first_mode,
        commissioning=commissioning,
        scene=scene,
        scheduler=scheduler,
        monitor=monitor,
        view=view,
        hub=hub,
        bus=bus,
        webhook=webhook,
    )
