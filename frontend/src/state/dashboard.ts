import { Aim } from "./aim";
import { Connection } from "./connection";
import { Live } from "./live";
import { Operations, type Notify } from "./operations";
import { rest } from "../api/rest";
import { EMPTY_PAGE, type Page } from "./page";
import { References } from "./references";
import { Store } from "./store";
import { Ticker } from "./ticker";

/** The parts behind the page, wired once. */
export class Dashboard {
  readonly live = new Live();
  readonly page = new Store<Page>(EMPTY_PAGE);
  readonly ticker = new Ticker();
  readonly operations: Operations;
  readonly aim: Aim;
  readonly references: References;
  readonly connection: Connection;

  constructor(notify: Notify) {
    this.operations = new Operations(this.page, notify);
    this.aim = new Aim(this.live, this.page, this.operations, (message) => this.connection.send(message));
    this.references = new References(this.page, rest, (title, error) => {
      this.operations.report(title, error);
    });
    this.connection = new Connection(this.live, this.page, {
      answered: (id, refusal) => {
        this.aim.answered(id, refusal);
      },
      disconnected: () => {
        this.aim.disconnected();
      },
      met: () => {
        void this.references.learn();
      },
      failed: (title, error) => {
        this.operations.report(title, error);
      },
    });
  }
}
