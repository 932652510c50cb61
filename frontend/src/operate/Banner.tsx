import {
  IconAlertTriangle,
  IconHandStop,
  IconLoader2,
  IconLock,
  IconPlugConnectedX,
} from "@tabler/icons-react";
import { Live } from "../live/live";
import { isOperatorHere, operatorText, silenceOf, usePage, type Page } from "../live/page";
import { clearing, isLatched, MODE, remedy, whyText } from "../live/modes";
import { seconds } from "../ui/format";
import { LiveText } from "../ui/LiveText";
import { useService } from "../ui/services";

/** What the plan lies under: nothing, no link, no place, a rig that is not there or obeys others, a latched state. */
type Trouble =
  | "none"
  | "connecting"
  | "offline"
  | "shutOut"
  | "refused"
  | "noRig"
  | "rigStarts"
  | "rigGone"
  | "fault"
  | "stopped";

const TEXT: Record<Trouble, string> = {
  none: "",
  connecting: "Connecting to the server",
  offline: "No connection to the server; trying again",
  shutOut: "The server does not take this page in",
  refused: "The rig takes no command from this server",
  noRig: "The server waits for a rig",
  rigStarts: "The rig starts with actuator",
  rigGone: "The rig does not answer; waiting for it",
  fault: "FAULT: the rig went to rest by itself",
  stopped: "E-STOP: the chambers were vented",
};

function troubleOf(page: Page): Trouble {
  const { online, shutOut, rig, mode, health } = page;
  const silent = silenceOf(page);
  if (!online && shutOut !== "") return "shutOut";
  if (silent === "server") return rig ? "offline" : "connecting";
  if (health && health.trouble !== "") return "refused";
  if (silent === "rig" && page.starting !== "") return "rigStarts";
  if (silent === "rig") return rig ? "rigGone" : "noRig";
  if (mode === null || !isLatched(mode)) return "none";
  return mode === MODE.E_STOP ? "stopped" : "fault";
}

/** What leads out of a latched state, for everyone who looks. */
function wayOut(page: Page): string {
  const { cause, lease, me, mode } = page;
  if (lease.mine && mode !== null) return `${remedy(cause)}, then press ${clearing(mode)}, and arm again.`;
  if (lease.held) return `${operatorText(page)}${isOperatorHere(page) ? " and can clear it" : ""}.`;
  return me.role === "viewer" ? "An operator can clear it." : "Take control to clear it.";
}

/** Over the plan: what is wrong, since when, and what comes next. */
export function Banner() {
  const trouble = usePage(troubleOf);
  if (trouble === "none") return null;
  if (trouble === "refused" || trouble === "shutOut") return <Refused trouble={trouble} />;
  return trouble === "fault" || trouble === "stopped" ? (
    <Latched trouble={trouble} />
  ) : (
    <Missing trouble={trouble} />
  );
}

/** Where the plan is not in sight: a latched state, its cause, and the way out of it. */
export function LatchedBanner() {
  const trouble = usePage(troubleOf);
  return trouble === "fault" || trouble === "stopped" ? <Latched trouble={trouble} /> : null;
}

function Refused({ trouble }: { readonly trouble: "refused" | "shutOut" }) {
  const reason = usePage(({ health, shutOut }) =>
    trouble === "refused" ? (health?.trouble ?? "") : shutOut,
  );
  return (
    <div className="banner" role="alert" data-testid={trouble}>
      <IconLock size={18} aria-hidden />
      <span>
        {TEXT[trouble]}: {reason}
      </span>
    </div>
  );
}

function Missing({ trouble }: { readonly trouble: Trouble }) {
  const live = useService(Live);
  const actuator = usePage((page) => page.starting);
  const waiting = trouble === "connecting" || trouble === "noRig" || trouble === "rigStarts";
  const Glyph = waiting ? IconLoader2 : IconPlugConnectedX;
  return (
    <div className={waiting ? "banner banner-waiting" : "banner"} role="alert" data-testid="banner">
      <Glyph size={18} aria-hidden />
      <span>
        {TEXT[trouble]}
        {trouble === "rigStarts" ? ` ${actuator}` : null}
        {live.frames > 0 ? (
          <>
            {" · last picture "}
            <LiveText read={() => seconds((performance.now() - live.freshAt) / 1e3)} rate={2} />
            {" old"}
          </>
        ) : null}
      </span>
    </div>
  );
}

function Latched({ trouble }: { readonly trouble: "fault" | "stopped" }) {
  const cause = usePage(whyText);
  const next = usePage(wayOut);
  const Glyph = trouble === "fault" ? IconAlertTriangle : IconHandStop;
  return (
    <div className={`banner banner-${trouble}`} role="alert" data-testid="latched">
      <Glyph size={18} aria-hidden />
      <span>
        {TEXT[trouble]}
        {cause === "" ? "" : ` (${cause})`}. {next}
      </span>
    </div>
  );
}
