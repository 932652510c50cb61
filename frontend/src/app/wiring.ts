import { LiveSocket, socketUrl } from "../api/socket";
import { Commissioning } from "../hardware/commissioning/commissioning";
import { Drawing } from "../drawing/drawing";
import { keepDrawing } from "../drawing/kept";
import { References } from "../drawing/library/references";
import { Planner } from "../drawing/planner";
import { SavedDrawings } from "../drawing/saved";
import { RigFileEditor } from "../hardware/rigFile";
import { Alarms } from "../health/alarms";
import { Connection } from "../live/connection";
import { Live } from "../live/live";
import { PageStore } from "../live/page";
import { Notices } from "../health/notify/notices";
import { TouchLock } from "../operate/lock/lock";
import { isTouchScreen } from "../operate/lock/LockButton";
import { Operations, type Notify } from "../operate/operations";
import { EmergencyStop, stopByHttp, watchLatch } from "../operate/stop/stop";
import { TargetControl } from "../operate/target/targetControl";
import { TwinTime } from "../operate/time/twinTime";
import { Gamepads } from "../operate/target/gamepads";
import { Layers } from "../plan/layers";
import { keepProfile } from "../recorder/profile";
import { Recorder } from "../recorder/recorder";
import { Macros } from "../runs/macros/macros";
import { keepRecord, Runs } from "../runs/runs";
import { RunTrace } from "../runs/trace";
import { Painters } from "../ui/painters";
import { Services } from "../ui/services";
import type { PageStorage } from "../ui/storage";
import { Ticker } from "../ui/ticker";

/** Everything behind the page, wired once. */
export function wire(notify: Notify, storage: PageStorage): Services {
  const services = new Services();
  const [live, page] = [new Live(), new PageStore()];
  const socket = new LiveSocket(socketUrl(window.location, "/ws/live"));
  const operations = new Operations(page, notify);
  const painters = new Painters((name, error) => {
    console.error(`${name} is not drawn:`, error);
    operations.note(`${name} is not drawn`, error);
  });
  const ticker = new Ticker(painters);
  const stop = new EmergencyStop({
    bySocket: (n) => socket.send({ type: "e_stop", n }),
    byHttp: stopByHttp,
    show: (news) => page.patch({ stop: news }),
    write: operations.note.bind(operations),
    later: (action, delay) => setTimeout(action, delay),
  });
  watchLatch(stop, page);
  const targetControl = new TargetControl(live, page, operations, socket);
  const lock = new TouchLock(page, storage, {
    now: () => Date.now(),
    isTouched: isTouchScreen,
    isHeld: () => targetControl.held,
  });
  const alarms = new Alarms(page, operations);
  const references = new References(page, operations);
  const drawing = new Drawing();
  const saved = new SavedDrawings(drawing, operations);
  const runs = new Runs(drawing.store, page, operations);
  const macros = new Macros(page, operations);
  const trace = new RunTrace(live, page);
  ticker.every(60, "trace of the run", (now) => {
    trace.look(now);
  });
  new Planner(drawing.store, page);
  keepRecord(runs, storage);
  keepProfile(page, storage);
  const lost = (why: string) =>
    notify("warning", "A reload will lose the drawing", `${why}: save it on the server, or simplify it`);
  if (keepDrawing(drawing, storage, lost)) drawing.chooseSource("drawing");
  const connection = new Connection(live, page, socket, {
    answered: targetControl.answered.bind(targetControl),
    stopAnswered: stop.answered.bind(stop),
    disconnected: targetControl.disconnected.bind(targetControl),
    met: () => {
      void alarms.learn();
      void references.learn();
      void saved.learn();
      void macros.learn();
    },
    leaseChanged: operations.leaseChanged.bind(operations),
    failed: operations.report.bind(operations),
  });
  services.add(
    live,
    page,
    operations,
    painters,
    ticker,
    stop,
    targetControl,
    lock,
    alarms,
    references,
    drawing,
    saved,
    runs,
    macros,
    trace,
  );
  services.add(
    connection,
    new Recorder(page, operations),
    new Layers(storage),
    new TwinTime(page, operations),
    new Notices(page, storage),
    new Commissioning(page),
    new RigFileEditor(),
    new Gamepads({ targetControl, live, page, operations, ticker }),
  );
  return services;
}
