import { EmergencyStop } from "../operate/stop/stop";
import { Aim } from "../operate/target/aim";
import { Connection } from "../live/connection";
import { Drawing } from "../drawing/drawing";
import { keepDrawing, type Shelf } from "../drawing/kept";
import { Planner } from "../drawing/planner";
import { SavedDrawings } from "../drawing/saved";
import { Gamepads } from "../operate/target/gamepads";
import { Live } from "../live/live";
import { Operations, type Notify } from "../operate/operations";
import { rest } from "../api/rest";
import { EMPTY_PAGE, type Page } from "../live/page";
import { Painters } from "../ui/painters";
import { keepProfile } from "../recorder/profile";
import { References } from "../drawing/library/references";
import { keepRecord, Runs } from "../runs/runs";
import { Store } from "../ui/store";
import { Ticker } from "../ui/ticker";

/** The parts behind the page, wired once. */
export class Dashboard {
  readonly live = new Live();
  readonly page = new Store<Page>(EMPTY_PAGE);
  readonly painters = new Painters((name, error) => {
    console.error(`${name} is not drawn:`, error);
    this.operations.note(`${name} is not drawn`, error);
  });
  readonly ticker = new Ticker(this.painters);
  readonly operations: Operations;
  readonly stop: EmergencyStop;
  readonly aim: Aim;
  readonly references: References;
  readonly drawing = new Drawing();
  readonly planner: Planner;
  readonly saved: SavedDrawings;
  readonly runs: Runs;
  readonly gamepads: Gamepads;
  readonly connection: Connection;

  constructor(notify: Notify, shelf: Shelf) {
    this.operations = new Operations(this.page, notify);
    this.stop = new EmergencyStop({
      bySocket: (n) => this.connection.send({ type: "e_stop", n }),
      byHttp: rest.stop,
      show: (stop) => {
        this.page.patch({ stop });
      },
      write: (title, error) => {
        this.operations.note(title, error);
      },
      later: (action, delay) => setTimeout(action, delay),
    });
    this.aim = new Aim(this.live, this.page, this.operations, (message) => this.connection.send(message));
    this.gamepads = new Gamepads(this);
    this.references = new References(this.page, rest, (title, error) => {
      this.operations.report(title, error);
    });
    this.planner = new Planner(this.drawing.store, this.page, {
      plan: rest.planDrawing,
      later: (action, delay) => setTimeout(action, delay),
    });
    this.saved = new SavedDrawings(this.drawing, rest, this.operations);
    this.runs = new Runs(this.drawing.store, this.page, rest, this.operations);
    keepRecord(this.runs, shelf);
    keepProfile(this.page, shelf);
    const lost = (why: string) => {
      notify("warning", "A reload will lose the drawing", `${why}: save it on the server, or simplify it`);
    };
    if (keepDrawing(this.drawing, shelf, lost)) this.runs.choose("drawing");
    this.connection = new Connection(this.live, this.page, {
      answered: (id, refusal) => {
        this.aim.answered(id, refusal);
      },
      stopAnswered: (n, refusal) => {
        this.stop.answered(n, refusal);
      },
      disconnected: () => {
        this.aim.disconnected();
      },
      met: () => {
        void this.operations.learnAlarms();
        void this.references.learn();
        void this.saved.learn();
      },
      leaseChanged: (mine, holder) => {
        this.operations.leaseChanged(mine, holder);
      },
      failed: (title, error) => {
        this.operations.report(title, error);
      },
    });
  }
}
