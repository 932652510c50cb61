import { ActionIcon, NativeSelect, Tooltip } from "@mantine/core";
import { IconDownload, IconPlayerPause, IconPlayerPlay, IconPlus } from "@tabler/icons-react";
import type { ReactNode } from "react";
import { PLOTS_MAX, SPANS, withPlot } from "./layout";
import { LayoutMenu } from "./LayoutMenu";
import type { Layouts } from "./useLayout";

interface Props {
  readonly layouts: Layouts;
  readonly stopped: boolean;
  readonly onStop: () => void;
  readonly onAdd: () => void;
  readonly onCsv: () => void;
}

/** Left of the plots: pause, time window, one more plot, the window as a file, layouts. */
export function PlotsBar({ layouts, stopped, onStop, onAdd, onCsv }: Props) {
  const seconds = layouts.layout?.seconds ?? SPANS[1];
  const full = (layouts.layout?.plots.length ?? 0) >= PLOTS_MAX;
  return (
    <div className="plots-bar">
      <BarButton
        label={stopped ? "Go on" : "Pause the plots (the rig goes on)"}
        name={stopped ? "Resume plots" : "Pause plots"}
        pressed={stopped}
        testId="pause"
        onClick={onStop}
      >
        {stopped ? <IconPlayerPlay size={16} /> : <IconPlayerPause size={16} />}
      </BarButton>
      <NativeSelect
        size="xs"
        className="plots-window"
        aria-label="Time window"
        data-testid="window"
        rightSection={<span />}
        rightSectionWidth={0}
        value={String(seconds)}
        data={[...new Set([...SPANS, seconds])].map((span) => ({
          value: String(span),
          label: spanLabel(span),
        }))}
        onChange={(event) => {
          const chosen = Number(event.currentTarget.value);
          layouts.change((layout) => ({ ...layout, seconds: chosen }));
        }}
      />
      <BarButton
        label={full ? `At most ${PLOTS_MAX} plots` : "Add a plot"}
        name="Add a plot"
        testId="add-plot"
        onClick={() => {
          layouts.change(withPlot);
          if (!full) onAdd();
        }}
      >
        <IconPlus size={16} />
      </BarButton>
      <BarButton
        label="Download what is visible: every tick of the last minute, else the extremes of 16 ms"
        name="Download the visible window as CSV"
        testId="csv"
        onClick={onCsv}
      >
        <IconDownload size={16} />
      </BarButton>
      <LayoutMenu layouts={layouts} />
    </div>
  );
}

interface ButtonProps {
  readonly label: string;
  readonly name: string;
  readonly pressed?: boolean;
  readonly testId: string;
  readonly onClick: () => void;
  readonly children: ReactNode;
}

function BarButton({ label, name, pressed, testId, onClick, children }: ButtonProps) {
  return (
    <Tooltip label={label} position="right">
      <ActionIcon
        variant={pressed ? "filled" : "default"}
        aria-pressed={pressed}
        aria-label={name}
        data-testid={testId}
        onClick={onClick}
      >
        {children}
      </ActionIcon>
    </Tooltip>
  );
}

function spanLabel(seconds: number): string {
  return seconds < 60 ? `${seconds} s` : `${seconds / 60} min`;
}
