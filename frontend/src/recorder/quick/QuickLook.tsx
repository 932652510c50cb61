import { Loader, SegmentedControl } from "@mantine/core";
import { useCallback, useEffect, useImperativeHandle, useMemo, useRef, useState, type ReactNode, type Ref } from "react"; // prettier-ignore
import type { Quick, Recording } from "../../api/types";
import { plainTicks } from "../../plots/chart/axes";
import { TimeCursor } from "../../plots/chart/readout";
import { liveMarks, NO_MARKS, type PlotMark } from "../../plots/chart/marks";
import { TimeAxis } from "../../plots/chart/TimeAxis";
import { plain } from "../../ui/format";
import type { Recordings } from "../useRecordings";
import { Bookmarks } from "./Bookmarks";
import { beginOf, runWindow, STRETCH_WORD } from "./course";
import { PathCanvas, type DrawnPath, type PathMark } from "./PathCanvas";
import { pathsOf } from "./paths";
import { quickCharts, type QuickChart } from "./quickCharts";
import { QuickPlot, Sample, type CursorPlace, type Seek, type TimeWindow, type Zoomed } from "./QuickPlot";
import { useQuick } from "./useQuick";

interface Props {
  readonly recording: Recording;
  readonly recordings: Recordings;
  readonly running: boolean;
  readonly onZoom: Zoomed;
  /** Its plots stand, of what begins at `start` [s]. */
  readonly onDrawn: (start: number) => void;
}

/** The main signals and the tip's path of a recording, without rerun, and what was marked in it. */
export function QuickLook({ recording, recordings, running, onZoom, onDrawn }: Props) {
  const { looks, problem } = useQuick([recording.id], running);
  const [seek, setSeek] = useState<Seek | null>(null);
  const { bookmarks } = recording;
  const marks = useMemo(() => liveMarks({ origin: 0, bookmarks }), [bookmarks]);
  const onSeek = useCallback((at: number) => {
    setSeek({ at });
  }, []);
  const quick = looks?.at(0);
  return (
    <>
      <Bookmarks recording={recording} recordings={recordings} onSeek={onSeek} />
      {problem !== "" ? (
        <p className="panel advice" role="alert">
          No quick look: {problem}
        </p>
      ) : !quick ? (
        <Loader m="xl" data-testid="quick-loading" />
      ) : quick.rows === 0 ? (
        <p className="panel note">Nothing is recorded in it.</p>
      ) : (
        <Shown {...{ quick, marks, seek, onSeek, onZoom, onDrawn }} />
      )}
    </>
  );
}

interface Marking {
  readonly marks?: readonly PlotMark[];
  readonly seek?: Seek | null;
  /** Told the place of a mark that was clicked. */
  readonly onSeek?: (at: number) => void;
}

interface ShownProps extends Marking, Pick<Props, "onZoom" | "onDrawn"> {
  readonly quick: Quick;
}

function Shown({ quick, onDrawn, ...rest }: ShownProps) {
  const start = beginOf(quick.stretches);
  useEffect(() => {
    onDrawn(start);
  }, [onDrawn, start]);
  const [extent, setExtent] = useState<Extent>("run");
  const charts = useMemo(() => quickCharts(quick), [quick]);
  const paths = useMemo(() => pathsOf(quick), [quick]);
  const run = useMemo(() => runWindow(quick.stretches), [quick]);
  const shaded = [...new Set(quick.stretches.map(({ kind }) => kind))].filter((kind) => kind !== "run");
  return (
    <PlotsAndPath
      {...rest}
      charts={charts}
      paths={paths}
      group="quick"
      unitX="s"
      window={extent === "run" ? run : null}
    >
      {run === null ? null : (
        <div className="quick-extent">
          <SegmentedControl
            size="xs"
            aria-label="Shown time"
            data-testid="quick-extent"
            value={extent}
            onChange={setExtent}
            data={[
              { value: "run", label: "Run" },
              { value: "all", label: "All" },
            ]}
          />
          <span className="note">shaded: {shaded.map((kind) => STRETCH_WORD[kind]).join(", ")}</span>
        </div>
      )}
    </PlotsAndPath>
  );
}

type Extent = "run" | "all";

interface PlotsProps extends Marking {
  readonly charts: readonly QuickChart[];
  readonly paths: readonly DrawnPath[];
  readonly group: string;
  readonly unitX: string;
  readonly onZoom?: Zoomed | undefined;
  /** What the plots show at first, null for all. */
  readonly window?: TimeWindow | null;
  /** Above the paths. */
  readonly children?: ReactNode;
}

/** Plots beside the paths; where the cursor is on time, each path is marked. */
export function PlotsAndPath({
  charts,
  paths,
  group,
  unitX,
  onZoom,
  window = null,
  children = null,
  ...marking
}: PlotsProps) {
  const { marks = NO_MARKS, seek = null, onSeek } = marking;
  const mark = useRef<PathMark>(null);
  const axes = useRef<SharedAxes>(null);
  const [cursor] = useState(() => new TimeCursor());
  const onRange = useCallback((range: TimeWindow) => {
    axes.current?.show(range);
  }, []);
  const follow = useCallback(
    (place: CursorPlace | null) => {
      if (unitX === "s") mark.current?.show(place?.x ?? null);
      if (place) cursor.show(place.share, `${plain(place.x, 2)} ${unitX}`);
      else cursor.hide();
    },
    [cursor, unitX],
  );
  return (
    <div className="quick" data-testid="quick">
      <div className="quick-plots">
        <div className="quick-grid">
          {charts.map((chart, i) => (
            <QuickPlot
              key={chart.title}
              chart={chart}
              group={group}
              unitX={unitX}
              onCursor={i === 0 ? follow : undefined}
              onRange={i === 0 ? onRange : undefined}
              onZoom={i === 0 ? onZoom : undefined}
              marks={marks}
              seek={seek}
              onSeek={onSeek}
              window={window}
            />
          ))}
        </div>
        <QuickAxes {...{ unitX, cursor }} ref={axes} columns={Math.min(COLUMNS, charts.length)} />
      </div>
      <figure className="quick-side">
        {children}
        <figcaption>
          {paths.map(({ label, colour, dash }) => (
            <span key={label} className="quick-line">
              <Sample line={{ label, colour, dash, look: "solid" }} /> {label}
            </span>
          ))}
        </figcaption>
        <PathCanvas paths={paths} mark={mark} />
      </figure>
    </div>
  );
}

/** Columns of plots where the page is wide; in one column only the first axis is seen. */
const COLUMNS = 2;

/** Lets the plots say what they show, without drawing them and the path again. */
interface SharedAxes {
  readonly show: (range: TimeWindow) => void;
}

interface AxesProps {
  readonly unitX: string;
  readonly cursor: TimeCursor;
  readonly columns: number;
  readonly ref: Ref<SharedAxes>;
}

/** What all plots count on x, once under each column. */
function QuickAxes({ unitX, cursor, columns, ref }: AxesProps) {
  const [range, setRange] = useState<TimeWindow | null>(null);
  const marked = useMemo(() => plainTicks(unitX), [unitX]);
  useImperativeHandle(ref, () => ({ show: setRange }), []);
  return (
    <div className="quick-axes">
      {range === null
        ? null
        : Array.from({ length: columns }, (_, i) => <TimeAxis key={i} {...{ range, marked, cursor }} />)}
    </div>
  );
}
