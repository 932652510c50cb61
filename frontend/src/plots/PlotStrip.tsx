import { ActionIcon, SegmentedControl, Tooltip } from "@mantine/core";
import { IconPlayerPause, IconPlayerPlay } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import { useDashboard } from "../panels/context";
import { ChartBox } from "./ChartBox";
import { CHARTS } from "./charts";
import type { ChartPainter } from "./painter";

const REDRAWS_PER_SECOND = 20;
const SPANS = ["5", "10", "30", "60"] as const;

/** The live plots: x, y, error and pressures over the last seconds. */
export function PlotStrip() {
  const { live, ticker } = useDashboard();
  const [seconds, setSeconds] = useState(10);
  const [pausedAt, setPausedAt] = useState<number | null>(null);
  const painters = useRef(new Map<string, ChartPainter>());
  const [keepers] = useState(() =>
    CHARTS.map(({ title }) => (painter: ChartPainter | null) => {
      if (painter) painters.current.set(title, painter);
      else painters.current.delete(title);
    }),
  );
  useEffect(() => {
    let shown = NaN;
    return ticker.every(REDRAWS_PER_SECOND, () => {
      const end = pausedAt ?? live.ring.newest;
      if (end === shown || !Number.isFinite(end)) return;
      shown = end;
      for (const painter of painters.current.values()) painter.show(live.ring, live.channels, end, seconds);
    });
  }, [ticker, live, seconds, pausedAt]);
  const paused = pausedAt !== null;
  return (
    <section className="plots" aria-label="Plots">
      <div className="plots-bar">
        <Tooltip label={paused ? "Go on" : "Pause the plots (the rig goes on)"} position="right">
          <ActionIcon
            variant={paused ? "filled" : "default"}
            aria-pressed={paused}
            aria-label={paused ? "Resume plots" : "Pause plots"}
            data-testid="pause"
            onClick={() => {
              setPausedAt(paused ? null : live.ring.newest);
            }}
          >
            {paused ? <IconPlayerPlay size={16} /> : <IconPlayerPause size={16} />}
          </ActionIcon>
        </Tooltip>
        <SegmentedControl
          orientation="vertical"
          size="xs"
          aria-label="Time window in seconds"
          data-testid="window"
          value={String(seconds)}
          onChange={(value) => {
            setSeconds(Number(value));
          }}
          data={SPANS.map((span) => ({ value: span, label: `${span} s` }))}
        />
      </div>
      {CHARTS.map((chart, i) => (
        <ChartBox key={chart.title} chart={chart} onPainter={keepers[i]} />
      ))}
    </section>
  );
}
