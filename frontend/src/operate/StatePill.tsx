import {
  IconAlertTriangle,
  IconArrowsMove,
  IconHandStop,
  IconLock,
  IconPlayerPause,
  IconPlugConnectedX,
  IconRoute,
  IconTrendingDown,
  IconWind,
} from "@tabler/icons-react";
import type { Icon } from "@tabler/icons-react";
import type { Mode } from "../api/types";
import { silenceOf, usePage } from "../live/page";
import { isLatched, isUnasked, MODE_MEANING, MODE_WORD, whyText } from "../live/modes";
import { isPaused } from "./permission";

const APPEARANCE: Record<Mode, { icon: Icon; colour: string }> = {
  0: { icon: IconWind, colour: "grey" },
  1: { icon: IconLock, colour: "blue" },
  2: { icon: IconArrowsMove, colour: "green" },
  3: { icon: IconRoute, colour: "green" },
  4: { icon: IconTrendingDown, colour: "grey" },
  5: { icon: IconAlertTriangle, colour: "amber" },
  6: { icon: IconHandStop, colour: "red" },
};

/** The rig's state as word, icon and colour. */
export function StatePill() {
  const mode = usePage((page) => page.mode);
  const why = usePage(whyText);
  const silent = usePage(silenceOf);
  const starting = usePage((page) => page.starting !== "");
  const paused = usePage(isPaused);
  if (mode === null || silent !== "none")
    return <Unknown mode={mode} word={silent === "server" ? "NO LINK" : starting ? "STARTING" : "NO RIG"} />;
  if (paused) return <Paused mode={mode} />;
  const { icon: Glyph, colour } = APPEARANCE[mode];
  const meaning = why === "" ? MODE_MEANING[mode] : `${MODE_MEANING[mode]} (${why})`;
  return (
    <output
      className={`pill pill-${colour}`}
      title={meaning}
      data-testid="state"
      aria-label={`State: ${MODE_WORD[mode]}`}
    >
      <Glyph size={17} aria-hidden />
      <span>{MODE_WORD[mode]}</span>
    </output>
  );
}

/** The twin's time stands still, in a state that the rig keeps. */
function Paused({ mode }: { readonly mode: Mode }) {
  return (
    <output
      className="pill pill-grey"
      title={`The twin's time stands still, in ${MODE_WORD[mode]}`}
      data-testid="state"
      aria-label={`State: paused in ${MODE_WORD[mode]}`}
    >
      <IconPlayerPause size={17} aria-hidden />
      <span>PAUSED</span>
    </output>
  );
}

interface UnknownProps {
  readonly mode: Mode | null;
  readonly word: string;
}

function Unknown({ mode, word }: UnknownProps) {
  const meaning = mode === null ? "Nothing heard from the rig yet" : `Last heard: ${MODE_WORD[mode]}`;
  return (
    <output
      className="pill pill-unknown"
      title={meaning}
      data-testid="state"
      aria-label={`State unknown: ${word}`}
    >
      <IconPlugConnectedX size={17} aria-hidden />
      <span>{word}</span>
    </output>
  );
}

/** A cause that no one asked for, or that latches. */
export function Cause() {
  const mode = usePage((page) => (silenceOf(page) === "none" ? page.mode : null));
  const cause = usePage((page) => page.cause);
  const why = usePage(whyText);
  if (mode === null) return null;
  if (!isLatched(mode) && !isUnasked(cause)) return null;
  return (
    <span className="cause" data-testid="cause">
      {why}
    </span>
  );
}
