import { Tooltip } from "@mantine/core";
import { usePage } from "../live/page";
import { Painters } from "../ui/painters";
import { useService } from "../ui/services";
import { useStore } from "../ui/store";

/** What the plan cannot show by itself: a command at its limit, a target out of reach, a part that is not drawn. */
export function Flags() {
  const saturated = usePage((page) => page.rigLive && page.saturated);
  const unreachable = usePage((page) => page.rigLive && !page.reachable);
  return (
    <span className="flags">
      <NotDrawn />
      <Tooltip label="The command is at its limit; the integral is held">
        <span className={saturated ? "flag flag-on" : "flag"} aria-hidden={!saturated}>
          saturated
        </span>
      </Tooltip>
      <Tooltip label="The target is out of reach: the reference is the nearest point that can be reached">
        <span
          className={unreachable ? "flag flag-on" : "flag"}
          aria-hidden={!unreachable}
          data-testid="unreachable"
        >
          out of reach
        </span>
      </Tooltip>
    </span>
  );
}

/** What failed to draw: the rest goes on, and it is tried again. */
function NotDrawn() {
  const painters = useService(Painters);
  const names = useStore(painters.failed, (failed) => failed.names);
  if (names.length === 0) return null;
  return (
    <Tooltip label={`Not drawn, and tried again: ${names.join(", ")}. The log says why.`} multiline maw={340}>
      <span className="flag flag-on flag-bad" role="alert" data-testid="not-drawn">
        not drawn: {names[0]}
        {names.length > 1 ? ` and ${names.length - 1} more` : ""}
      </span>
    </Tooltip>
  );
}
