import { usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { useService } from "../ui/services";
import type { Learned as What } from "../api/types";
import { errorText, learnedText } from "./facts";
import { Runs } from "./runs";

/** What was learned of a path by repeating it: the error of each repeat, and the way to forget it. */
export function Learned({ learned }: { readonly learned: What }) {
  return (
    <div className="run-way-line run-learned" data-testid="run-learned">
      <span>{learnedText(learned)}</span>
      <Bars errors={learned.errors} />
      <span className="spacer" />
      <Forget learned={learned} />
    </div>
  );
}

function Forget({ learned }: { readonly learned: What }) {
  const runs = useService(Runs);
  const learning = usePage(({ macro }) => macro?.state === "running" && macro.learning);
  return (
    <ControlButton
      control="settings"
      because={learning ? "It is being learned: stop that first" : null}
      variant="subtle"
      size="compact-xs"
      testId="run-forget"
      meaning="Forget what was learned: the next run follows as planned"
      onClick={() => void runs.forget(learned.key)}
    >
      Forget
    </ControlButton>
  );
}

const WIDTH = 8;
const HEIGHT = 16;

/** RMSE of each repeat [m], from 0 to the largest; one that was broken off is a gap. */
function Bars({ errors }: { readonly errors: What["errors"] }) {
  const most = Math.max(...errors.map((error) => error ?? 0), 1e-9);
  return (
    <svg
      className="learned-bars"
      width={WIDTH * errors.length}
      height={HEIGHT}
      role="img"
      aria-label={`RMSE of ${errors.length} repeats: ${errors.map(errorText).join(", ")}`}
      data-testid="learned-bars"
    >
      <title>{errors.map((error, i) => `Repeat ${i + 1}: ${errorText(error)}`).join("\n")}</title>
      {errors.map((error, i) =>
        error === null ? null : (
          <rect
            key={`${i} ${error}`}
            x={WIDTH * i}
            width={WIDTH - 2}
            y={HEIGHT * (1 - error / most)}
            height={(HEIGHT * error) / most}
          />
        ),
      )}
    </svg>
  );
}
