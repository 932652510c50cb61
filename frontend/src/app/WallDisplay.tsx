import { Button, Progress } from "@mantine/core";
import { Live } from "../live/live";
import { PageStore, silenceOf, usePage } from "../live/page";
import { MODE_WORD, whyText } from "../live/modes";
import { CHAMBERS } from "../live/telemetry";
import { lapText } from "../runs/facts";
import { DASH, percent, plain } from "../ui/format";
import { LiveText } from "../ui/LiveText";
import { useService } from "../ui/services";

interface Shown {
  readonly name: string;
  readonly unit: string;
  readonly read: () => string;
}

/** The rig across a room: its state and a few numbers as large as the screen allows. State and E-STOP stay at the edge. */
export function WallDisplay() {
  const page = useService(PageStore);
  const live = useService(Live);
  const alive = usePage((state) => state.online && state.rigLive);
  const of = usePage((state) => state.errorOf);
  const at = (read: (row: NonNullable<Live["telemetry"]>) => number) =>
    alive && live.telemetry ? read(live.telemetry) : NaN;
  const motion: Shown[] = [
    {
      name: "tip x",
      unit: "mm",
      read: () =>
        plain(
          at((row) => row.at("p_meas", 0) * 1e3),
          1,
        ),
    },
    {
      name: "tip y",
      unit: "mm",
      read: () =>
        plain(
          at((row) => row.at("p_meas", 1) * 1e3),
          1,
        ),
    },
    {
      name: "error",
      unit: of === "none" ? "mm" : `mm, ${of} tip`,
      read: () =>
        plain(of === "none" ? NaN : at((row) => Math.hypot(row.at("error", 0), row.at("error", 1)) * 1e3), 1),
    },
  ];
  const pressures = CHAMBERS.map((chamber, i) => ({
    name: `pressure ${chamber}`,
    unit: "kPa",
    read: () =>
      plain(
        at((row) => row.at("pressure_meas", i) * 1e-3),
        0,
      ),
  }));
  return (
    <main className="wall" data-stale={!alive} data-testid="wall">
      <div className="wall-bar">
        <Button
          size="xs"
          variant="default"
          data-testid="wall-close"
          onClick={() => page.patch({ view: "live" })}
        >
          Back to Live
        </Button>
      </div>
      <State />
      <Numbers label="Tip and error" numbers={motion} />
      <Numbers label="Chambers" numbers={pressures} />
      <Run />
      <p className="wall-foot">
        on time{" "}
        <LiveText
          read={() => percent(alive ? (page.get().health?.on_time ?? NaN) : NaN)}
          testId="wall-on-time"
        />
      </p>
    </main>
  );
}

function State() {
  const mode = usePage((page) => page.mode);
  const why = usePage(whyText);
  const gone = usePage((page) => ({ none: "", server: "NO LINK", rig: "NO RIG" })[silenceOf(page)]);
  return (
    <p className="wall-state" data-testid="wall-state" data-mode={gone === "" ? mode : null}>
      {gone !== "" ? gone : mode === null ? DASH : MODE_WORD[mode]}
      {gone === "" && why !== "" ? <span className="wall-why">{why}</span> : null}
    </p>
  );
}

interface NumbersProps {
  readonly label: string;
  readonly numbers: readonly Shown[];
}

function Numbers({ label, numbers }: NumbersProps) {
  return (
    <section className="wall-numbers" aria-label={label}>
      {numbers.map(({ name, unit, read }) => (
        <div key={name} className="wall-number">
          <span className="wall-name">
            {name} <span className="unit">{unit}</span>
          </span>
          <LiveText read={read} testId={`wall-${name.replace(" ", "-")}`} />
        </div>
      ))}
    </section>
  );
}

/** Its place is kept while nothing runs. */
function Run() {
  const run = usePage((page) => page.run);
  const under = run !== null && ["approach", "running", "paused"].includes(run.state);
  return (
    <section className="wall-run" aria-label="Run" data-testid="wall-run">
      <span>{under ? `${run.name}: ${run.state}, ${lapText(run)}` : "no run"}</span>
      <Progress size="xl" value={under ? 100 * run.progress : 0} aria-label="Progress of the run" />
    </section>
  );
}
