import { Button, Modal, MultiSelect, NumberInput, SegmentedControl } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import type { Recording, SignalInfo } from "../../api/types";
import type { TimeWindow } from "../quick/QuickPlot";
import { EXPORTS, exportUrl, recordings as api, type Format } from "../recordings";

interface Props {
  readonly recording: Recording;
  /** What the quick look shows now; null: all. */
  readonly zoomed: TimeWindow | null;
}

/** The recording as a file of another program. */
export function ExportButton(props: Props) {
  const [open, setOpen] = useState(false);
  return (
    <>
      <Button
        size="compact-sm"
        variant="default"
        leftSection={<IconDownload size={14} />}
        data-testid="export"
        onClick={() => {
          setOpen(true);
        }}
      >
        Export
      </Button>
      {open ? <ExportDialog {...props} onClose={() => { setOpen(false); }} /> : null /* prettier-ignore */}
    </>
  );
}

/** Which signals of the recording, from when to when. */
function ExportDialog({ recording, zoomed, onClose }: Props & { readonly onClose: () => void }) {
  const [format, setFormat] = useState<Format>("csv");
  const [signals, setSignals] = useState<string[]>([]);
  const [from, setFrom] = useState<number | string>(zoomed ? round(zoomed.from) : "");
  const [to, setTo] = useState<number | string>(zoomed ? round(zoomed.to) : "");
  const whole = format === "rrd";
  const choice = whole ? { signals: [], from: "", to: "" } : { signals, from, to };
  const problem = whole ? "" : wrongWindow(from, to, recording.seconds);
  return (
    <Modal opened onClose={onClose} title="Export" closeButtonProps={{ "aria-label": "Close" }}>
      <div className="import" data-testid="export-dialog">
        <SegmentedControl
          size="xs"
          aria-label="Format"
          data-testid="export-format"
          value={format}
          onChange={setFormat}
          data={EXPORTS.map(([value, label]) => ({ value, label }))}
        />
        <p className="note">{EXPORTS.find(([value]) => value === format)?.[2]}</p>
        {whole ? null : (
          <>
            <SignalSelect id={recording.id} value={signals} onChange={setSignals} />
            <div className="row">
              <Seconds label="From" value={from} placeholder="0" onChange={setFrom} />
              <Seconds
                label="To"
                value={to}
                placeholder={round(recording.seconds).toString()}
                onChange={setTo}
              />
            </div>
          </>
        )}
        {
          problem === "" ? null : <p className="review-bad import-problem" role="alert">{problem}</p> /* prettier-ignore */
        }
        <Button
          size="xs"
          w="fit-content"
          component="a"
          leftSection={<IconDownload size={14} />}
          {...(problem === ""
            ? { href: exportUrl(recording.id, format, choice) }
            : { "data-disabled": true })}
          download
          data-testid="export-send"
          onClick={() => {
            if (problem === "") onClose();
          }}
        >
          Export
        </Button>
        <p className="note">
          The download begins when the file is ready: up to a minute for ten minutes of all signals.
        </p>
      </div>
    </Modal>
  );
}

interface SelectProps {
  readonly id: string;
  readonly value: string[];
  readonly onChange: (signals: string[]) => void;
}

/** Fields of telemetry, by group; none means all. */
function SignalSelect({ id, value, onChange }: SelectProps) {
  const [offered, setOffered] = useState<readonly SignalInfo[]>([]);
  useEffect(() => {
    let gone = false;
    api.signals(id).then(
      (found) => {
        if (!gone) setOffered(found);
      },
      () => undefined, // without a list all signals can still be had
    );
    return () => {
      gone = true;
    };
  }, [id]);
  return (
    <MultiSelect
      size="xs"
      label="Signals"
      placeholder={value.length === 0 ? "all" : ""}
      searchable
      clearable
      data-testid="export-signals"
      value={value}
      onChange={onChange}
      data={grouped(offered)}
    />
  );
}

function grouped(signals: readonly SignalInfo[]) {
  const groups = [...new Set(signals.map(({ group }) => group))];
  return groups.map((group) => {
    const fields = signals.filter((signal) => signal.group === group);
    const units = new Map(fields.map(({ field, unit }) => [field, unit]));
    const items = [...units].map(([field, unit]) => ({
      value: field,
      label: unit === "1" ? field : `${field} [${unit}]`,
    }));
    return { group, items };
  });
}

interface SecondsProps {
  readonly label: string;
  readonly value: number | string;
  readonly placeholder: string;
  readonly onChange: (value: number | string) => void;
}

function Seconds({ label, value, placeholder, onChange }: SecondsProps) {
  return (
    <NumberInput
      size="xs"
      label={`${label} [s]`}
      placeholder={placeholder}
      decimalScale={3}
      value={value}
      onChange={onChange}
      data-testid={`export-${label.toLowerCase()}`}
    />
  );
}

/** Why this window cannot be had, "" if it can. */
function wrongWindow(from: number | string, to: number | string, seconds: number): string {
  const [start, stop] = [from === "" ? 0 : Number(from), to === "" ? seconds : Number(to)];
  if (start < 0 || start > seconds) return `From = ${start} s is outside [0, ${round(seconds)}] s.`;
  return stop < start ? `To = ${stop} s is before From = ${start} s.` : "";
}

function round(seconds: number): number {
  return Math.round(seconds * 1e3) / 1e3;
}
