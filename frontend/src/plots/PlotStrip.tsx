import { useElementSize } from "@mantine/hooks";
import { useCallback, useEffect, useMemo, useState } from "react";
import "./plots.css";
import { Connection } from "../live/connection";
import { Live } from "../live/live";
import { usePage } from "../live/page";
import { Operations } from "../operate/operations";
import { Painters } from "../ui/painters";
import { useService } from "../ui/services";
import { useStore } from "../ui/store";
import { Ticker } from "../ui/ticker";
import { secondsTicks } from "./chart/axes";
import { ChartBox } from "./chart/ChartBox";
import { chartOf } from "./chart/charts";
import { TimeCursor } from "./chart/readout";
import { gridOf } from "./grid";
import { liveMarks } from "./chart/marks";
import type { ChartPainter } from "./chart/painter";
import { Painting } from "./chart/painting";
import { TimeAxis } from "./chart/TimeAxis";
import { counted, FOLLOWING, paused, visible, type Gesture } from "./chart/view";
import { askForCsv, csvOfBins, csvUrl, download } from "./csv";
import { channelsOf, withoutPlot, withSignals } from "./layout";
import { PlotsBar } from "./PlotsBar";
import { SignalChooser } from "./SignalChooser";
import { useLayout } from "./useLayout";

const FRAMES_PER_SECOND = 60;
/** As often as a number can be read. */
const VALUES_PER_SECOND = 5;
const NO_PLOTS = [] as const;
/** Height of the time under each column of plots. */
const AXIS_PX = 14;

/** The live plots over the last seconds: any signal, stopped, zoomed and saved as the operator likes. */
export function PlotStrip() {
  const connection = useService(Connection);
  const live = useService(Live);
  const operations = useService(Operations);
  const painters = useService(Painters);
  const ticker = useService(Ticker);
  const channels = useStore(live.signals, (signals) => signals.channels);
  const layouts = useLayout();
  const { layout } = layouts;
  const plots = layout?.plots ?? NO_PLOTS;
  const seconds = layout?.seconds ?? 10;
  const origin = usePage((page) => page.recording.origin);
  const bookmarks = usePage((page) => page.recording.bookmarks);
  const marks = useMemo(() => liveMarks({ origin, bookmarks }), [origin, bookmarks]);
  const [view, setView] = useState(FOLLOWING);
  const [editing, setEditing] = useState<number | null>(null);
  const [painting] = useState(() => new Painting(live.ring, painters));
  const [cursor] = useState(() => new TimeCursor());
  const { ref: room, width, height } = useElementSize();
  const { rows, columns, cells } = gridOf(plots.length, { width, height: height - AXIS_PX });
  const range = counted(view, seconds);
  const errorOf = usePage((page) => page.errorOf);
  const charts = useMemo(
    () => plots.map((plot) => chartOf(plot, channels, errorOf)),
    [plots, channels, errorOf],
  );
  useEffect(() => {
    if (layout) connection.plot(channelsOf(layout));
  }, [connection, layout]);
  useEffect(
    () =>
      ticker.every(FRAMES_PER_SECOND, "plots", () => {
        painting.step(view, seconds, marks);
      }),
    [ticker, painting, view, seconds, marks],
  );
  useEffect(
    () =>
      ticker.every(VALUES_PER_SECOND, "values of the plots", () => {
        painting.writeValues();
      }),
    [ticker, painting],
  );
  const onPainter = useCallback((painter: ChartPainter) => painting.add(painter), [painting]);
  const onGesture = useCallback(
    (gesture: Gesture) => {
      setView((old) => painting.after(gesture, old, seconds));
    },
    [painting, seconds],
  );
  const saveCsv = async () => {
    const range = visible(view, painting.now(seconds));
    const keys = charts.flatMap((chart) => chart.lines.map((line) => line.key));
    const places = charts.flatMap((chart) => chart.lines.map((line) => line.channel));
    const found = await askForCsv(csvUrl([...new Set(keys)], range));
    const content = found ?? new Blob([csvOfBins(live.ring, channels, [...new Set(places)], range)]);
    download(`tendril-${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.csv`, content);
  };
  return (
    <section className="plots" aria-label="Plots" data-stopped={view.stoppedAt !== null}>
      <PlotsBar
        layouts={layouts}
        stopped={view.stoppedAt !== null}
        onStop={() => setView(view.stoppedAt === null ? paused(painting.now(seconds)) : FOLLOWING)}
        onAdd={() => setEditing(plots.length)}
        onCsv={() => void operations.attempt("No CSV", saveCsv)}
      />
      <div className="charts-room" ref={room}>
        <div className="charts" style={{ gridTemplateRows: `repeat(${rows}, minmax(0, 1fr)) ${AXIS_PX}px` }}>
          {charts.map((chart, i) => (
            <ChartBox
              key={i}
              {...{ chart, onPainter, onGesture, cursor }}
              style={{
                gridColumn: cells[i].column + 1,
                gridRow: `${cells[i].row + 1} / span ${cells[i].rows}`,
              }}
            >
              <SignalChooser
                title={chart.title}
                opened={editing === i}
                onOpened={(opened) => setEditing(opened ? i : null)}
                channels={channels}
                chosen={plots[i].channels}
                onChosen={(keys) => layouts.change((old) => withSignals(old, i, keys))}
                onRemove={() => {
                  setEditing(null);
                  layouts.change((old) => withoutPlot(old, i));
                }}
              />
            </ChartBox>
          ))}
          {Array.from({ length: columns }, (_, column) => (
            <TimeAxis
              key={column}
              {...{ range, cursor }}
              marked={secondsTicks}
              style={{ gridColumn: column + 1, gridRow: rows + 1 }}
            />
          ))}
          {layout && plots.length === 0 ? (
            <p className="note plots-empty">No plots: add one with the plus sign, or open a layout.</p>
          ) : null}
        </div>
      </div>
    </section>
  );
}
