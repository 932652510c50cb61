import { Button, Loader, Menu, SegmentedControl, useComputedColorScheme } from "@mantine/core";
import { useWindowEvent } from "@mantine/hooks";
import { IconArrowLeft, IconRoute } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import type { Recording } from "../../api/types";
import { useWhyNot } from "../../operate/permission";
import { Replay3D } from "../../scene/Replay3D";
import { clock, localTime } from "../../ui/format";
import { Badges } from "../list/Badges";
import { DeleteButton } from "../list/DeleteButton";
import { Star } from "../list/RecordingRow";
import { QuickLook } from "../quick/QuickLook";
import type { TimeWindow } from "../quick/QuickPlot";
import { useActive, type Recordings } from "../useRecordings";
import { About } from "./About";
import { ExportButton } from "./ExportDialog";
import { Figures } from "./Figures";
import { Drawing } from "../../drawing/drawing";
import { PageStore } from "../../live/page";
import { Operations } from "../../operate/operations";
import { useService } from "../../ui/services";
import { recordings, recordingUrl, viewerUrl } from "../recordings";

/** After the quick look stands: leafing through recordings starts none, and its first cursor does not wait [ms]. */
const CALM_MS = 500;
/** How long a viewer that no one looks at is kept [ms]. */
const KEPT_MS = 120_000;

type Sight = "quick" | "figures" | "plots" | "3d";

interface Props {
  readonly id: string;
  readonly recordings: Recordings;
  readonly onBack: () => void;
}

/** One recording: its facts, the quick look, its signals in rerun, its motion in 3D. */
export function Detail({ id, recordings, onBack }: Props) {
  const [sight, setSight] = useState<Sight>("quick");
  const [zoomed, setZoomed] = useState<TimeWindow | null>(null);
  const [start, setStart] = useState<number | null>(null);
  const running = useActive() === id;
  const reason = useWhyNot("edit");
  const warm = useWarm(start !== null, sight === "plots");
  const recording = recordings.find(id);
  if (!recording) return <Unknown id={id} onBack={onBack} />;
  return (
    <main className="review">
      <div className="bar review-bar">
        <Back onBack={onBack} />
        <Star row={recording} reason={reason} change={recordings.change} />
        <h2 className="bar-title" tabIndex={-1} data-focus-home>
          <span className="review-name cut" title={recording.name}>
            {recording.name || "unnamed"}
          </span>{" "}
          · {localTime(recording.started)} · {clock(recording.seconds)}
        </h2>
        <Badges row={recording} running={running} />
        <span className="spacer" />
        <FollowAgain recording={recording} />
        <ExportButton recording={recording} zoomed={sight === "quick" ? zoomed : null} />
        <DeleteButton
          row={recording}
          running={running}
          reason={reason}
          onDelete={async () => {
            await recordings.remove(recording);
            onBack();
          }}
        />
        <SegmentedControl
          size="xs"
          aria-label="Show the recording as"
          data-testid="sight"
          value={sight}
          onChange={setSight}
          data={[
            { value: "quick", label: "Quick" },
            { value: "figures", label: "Figures" },
            { value: "plots", label: "Signals" },
            { value: "3d", label: "3D" },
          ]}
        />
      </div>
      {sight === "quick" ? <About recording={recording} running={running} recordings={recordings} /> : null}
      <Sighted
        sight={sight}
        recording={recording}
        recordings={recordings}
        running={running}
        onZoom={setZoomed}
        onDrawn={setStart}
      />
      {sight === "plots" || (warm && !running) ? (
        <Signals key={String(running)} id={id} shown={sight === "plots"} start={start} />
      ) : null}
    </main>
  );
}

interface SightedProps {
  readonly sight: Sight;
  readonly recording: Recording;
  readonly recordings: Recordings;
  readonly running: boolean;
  readonly onZoom: (to: TimeWindow | null) => void;
  readonly onDrawn: (start: number) => void;
}

function Sighted({ sight, recording, recordings, running, onZoom, onDrawn }: SightedProps) {
  switch (sight) {
    case "quick":
      return <QuickLook {...{ recording, recordings, running, onZoom, onDrawn }} />;
    case "figures":
      return running ? <p className="panel note">Figures are taken after its end.</p> : <Figures id={recording.id} />; // prettier-ignore
    case "plots":
      return null; // stands beside: it is there before
    case "3d":
      return <Replay3D recording={recording} />;
  }
}

interface BackProps {
  readonly onBack: () => void;
}

export function Back({ onBack }: BackProps) {
  return (
    <Button
      variant="subtle"
      size="xs"
      leftSection={<IconArrowLeft size={16} />}
      onClick={onBack}
      data-testid="back"
    >
      Recordings
    </Button>
  );
}

interface UnknownProps extends BackProps {
  readonly id: string;
}

export function Unknown({ id, onBack }: UnknownProps) {
  return (
    <main className="review">
      <div className="bar">
        <Back onBack={onBack} />
      </div>
      <p className="panel advice" role="alert" data-testid="unknown-recording">
        There is no recording “{id}”: it was deleted, or the link is wrong.
      </p>
    </main>
  );
}

/** Whether a viewer is to be there: while it is `shown`, and hidden for a while before, once the quick look is `drawn`, and after. */
function useWarm(drawn: boolean, shown: boolean): boolean {
  const [warm, setWarm] = useState(false);
  useEffect(() => {
    if (!drawn && !shown) return;
    const start = setTimeout(setWarm, shown ? 0 : CALM_MS, true);
    const end = shown ? undefined : setTimeout(setWarm, KEPT_MS, false);
    return () => {
      clearTimeout(start);
      clearTimeout(end);
    };
  }, [drawn, shown]);
  return warm || shown;
}

const PATHS = [
  ["p_ref", "The reference", "What the tip was asked to do"],
  ["p_meas", "The measured tip", "What it did, with the camera's noise"],
] as const;
type What = (typeof PATHS)[number][0];
/** Takes the camera's noise out of a measured path [m]. */
const SMOOTHING = { p_ref: 0, p_meas: 0.001 };

/** Puts a recorded path into the Run tab as a drawing, with its own timing. */
function FollowAgain({ recording }: { readonly recording: Recording }) {
  const drawing = useService(Drawing);
  const operations = useService(Operations);
  const page = useService(PageStore);
  const [busy, setBusy] = useState(false);
  const follow = async (what: What) => {
    setBusy(true);
    await operations.attempt("Path not taken", async () => {
      const { name, points, times } = await recordings.path(recording.id, what);
      drawing.load({
        name,
        points,
        times,
        pieces: null,
        closed: false,
        smoothing: SMOOTHING[what],
        timing: { kind: "given" },
        outside: "project",
      });
      drawing.chooseSource("drawing");
      page.patch({ view: "live" });
    });
    setBusy(false);
  };
  return (
    <Menu position="bottom-end" shadow="md">
      <Menu.Target>
        <Button
          size="compact-sm"
          variant="default"
          loading={busy}
          leftSection={<IconRoute size={14} />}
          title="Take a recorded path into the Run tab"
          data-testid="follow-again"
        >
          Follow again
        </Button>
      </Menu.Target>
      <Menu.Dropdown aria-label="Follow again">
        {PATHS.map(([what, label, meaning]) => (
          <Menu.Item
            key={what}
            disabled={recording.imported && what === "p_ref"}
            data-testid={`follow-${what}`}
            onClick={() => void follow(what)}
          >
            {label}
            <span className="note profile-meaning">{meaning}</span>
          </Menu.Item>
        ))}
      </Menu.Dropdown>
    </Menu>
  );
}

interface SignalsProps {
  readonly id: string;
  /** It is started hidden before: a viewer takes seconds to start. */
  readonly shown: boolean;
  /** Where its cursor is put first: the run's begin [s]; null while that is not known. */
  readonly start: number | null;
}

/** The recording in rerun's own viewer. */
function Signals(props: SignalsProps) {
  const scheme = useComputedColorScheme("dark", { getInitialValueInEffect: false });
  return <Viewer key={scheme} scheme={scheme} {...props} />;
}

interface ViewerProps extends SignalsProps {
  readonly scheme: "dark" | "light";
}

function Viewer({ id, shown, start, scheme }: ViewerProps) {
  const { origin } = window.location;
  const url = origin + recordingUrl(id, `/shown.rrd?theme=${scheme}`);
  const frame = useRef<HTMLIFrameElement>(null);
  const opened = useRef(shown);
  const [ready, setReady] = useState(false);
  const [source] = useState(() => viewerUrl(shown ? url : null, scheme, wishedRenderer()));
  useWindowEvent("message", ({ source, data }: MessageEvent<unknown>) => {
    if (source === frame.current?.contentWindow && data === "READY") setReady(true);
  });
  useEffect(() => {
    if (!ready || !shown || opened.current) return;
    opened.current = true;
    frame.current?.contentWindow?.postMessage({ tendril: "open", url }, origin);
  }, [origin, url, ready, shown]);
  useEffect(() => {
    if (ready && shown && start !== null)
      frame.current?.contentWindow?.postMessage({ tendril: "seek", seconds: start }, origin);
  }, [origin, ready, shown, start]);
  return (
    <>
      {ready || !shown ? null : (
        <Loader className="viewer-loading" size="xs" m="xs" data-testid="viewer-loading" />
      )}
      <iframe
        ref={frame}
        className="viewer-frame"
        title="Recording in rerun"
        data-testid="viewer"
        data-ready={ready}
        data-shown={shown}
        inert={!shown}
        src={source}
      />
    </>
  );
}

function wishedRenderer(): string | null {
  return new URLSearchParams(window.location.search).get("rerun_renderer");
}
