import { Checkbox, NativeSelect } from "@mantine/core";
import { Facts } from "../ui/Facts";
import { useService } from "../ui/services";
import { Drawing, sketchOf, timesOf, timingNow, useDrawing } from "./drawing";
import { DrawNumber } from "./DrawNumber";
import { DrawPlace } from "./DrawPlace";
import { DrawSaved } from "./DrawSaved";
import { drawingFacts, timingOf, TIMINGS } from "./facts";

/** The drawing in numbers: how it would be followed, where it is kept, where its selected piece lies. */
export function DrawPanel() {
  const plan = useDrawing((state) => state.plan);
  return (
    <>
      <DrawSaved />
      <Facts facts={drawingFacts(plan)} testId="drawing-facts" />
      <Manners />
      <Trouble />
      <DrawPlace />
    </>
  );
}

/** What keeps the drawing from being run, or what is made of it. */
function Trouble() {
  const problem = useDrawing((state) => state.problem || (state.plan?.reason ?? ""));
  const empty = useDrawing((state) => sketchOf(state).pieces.length === 0);
  const idle = empty || problem === "";
  const text = empty
    ? "Draw on the plan with the tools above it, write text, or import a file."
    : problem && `⚠ ${problem}`;
  return (
    <p
      className={idle ? "note draw-trouble" : "out-of-reach draw-trouble"}
      role="status"
      data-testid="drawing-reason"
    >
      {text}
    </p>
  );
}

function Manners() {
  const drawing = useService(Drawing);
  const { smoothing, outside } = useDrawing((state) => state.manner);
  const timing = useDrawing(timingNow);
  const closed = useDrawing((state) => sketchOf(state).closed);
  const timed = useDrawing((state) => timesOf(state) !== null);
  const kinds = TIMINGS.filter(([kind]) => kind !== "given" || timed);
  return (
    <div className="row row-fields draw-manner">
      <NativeSelect
        size="xs"
        w={146}
        label="Timing"
        data-testid="timing"
        value={timing.kind}
        data={kinds.map(([value, label]) => ({ value, label }))}
        onChange={(event) => {
          const kind = TIMINGS.find(([name]) => name === event.currentTarget.value)?.[0];
          if (kind) drawing.follow({ timing: timingOf(kind, drawing.store.get().plan) });
        }}
      />
      <Pace />
      <DrawNumber
        label="Smooth [mm]"
        testId="smoothing"
        width={80}
        value={millimetresOf(smoothing)}
        min={0}
        max={20}
        step={0.5}
        onChange={(value) => drawing.follow({ smoothing: value / 1e3 })}
      />
      <NativeSelect
        size="xs"
        w={84}
        label="Outside"
        data-testid="outside"
        value={outside}
        data={[
          { value: "project", label: "Project" },
          { value: "refuse", label: "Refuse" },
        ]}
        onChange={(event) =>
          drawing.follow({ outside: event.currentTarget.value === "refuse" ? "refuse" : "project" })
        }
      />
      <Checkbox
        size="xs"
        mb={7}
        label="Closed"
        data-testid="closed"
        checked={closed}
        disabled={timing.kind === "given"}
        onChange={(event) => drawing.close(event.currentTarget.checked)}
      />
    </div>
  );
}

/** The number that goes with the timing; its place is kept where there is none. */
function Pace() {
  const drawing = useService(Drawing);
  const timing = useDrawing(timingNow);
  switch (timing.kind) {
    case "speed":
      return (
        <DrawNumber
          label="Speed [mm/s]"
          testId="speed"
          width={84}
          value={millimetresOf(timing.speed)}
          min={1}
          max={1000}
          step={5}
          onChange={(value) => drawing.follow({ timing: { kind: "speed", speed: value / 1e3 } })}
        />
      );
    case "duration":
      return (
        <DrawNumber
          label="Duration [s]"
          testId="duration"
          width={84}
          value={timing.duration}
          min={0.1}
          max={280}
          step={1}
          onChange={(duration) => drawing.follow({ timing: { kind: "duration", duration } })}
        />
      );
    case "fastest":
    case "given":
      return <span className="draw-pace" />;
  }
}

function millimetresOf(metres: number): number {
  return Number((metres * 1e3).toFixed(3));
}
