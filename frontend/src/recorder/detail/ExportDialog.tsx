import { Button, Checkbox, Modal, MultiSelect, NumberInput, Progress, SegmentedControl } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { useEffect, useRef, useState } from "react";
import type { Recording, SignalInfo } from "../../api/types";
import type { TimeWindow } from "../quick/QuickPlot";
import { textOf } from "../../ui/format";
import { EXPORTS, recordings as api, recordingUrl, type ExportChoice, type Format } from "../recordings";

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
        onClick={() => setOpen(true)}
      >
        Export
      </Button>
      {open ? <ExportDialog {...props} onClose={() => setOpen(false)} /> : null /* prettier-ignore */}
    </>
  );
}

/** Which signals of the recording, from when to when. */
function ExportDialog({ recording, zoomed, onClose }: Props & { readonly onClose: () => void }) {
  const [format, setFormat] = useState<Format>("csv");
  const [signals, setSignals] = useState<string[]>([]);
  const [from, setFrom] = useState<number | string>(zoomed ? round(zoomed.from) : "");
  const [to, setTo] = useState<number | string>(zoomed ? round(zoomed.to) : "");
  const [comments, setComments] = useState(false);
  const made = useExport(recording.id, onClose);
  const whole = format === "rrd";
  const choice = whole ? { signals: [], from: "", to: "", comments: false } : { signals, from, to, comments };
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
        {format === "csv" ? (
          <Checkbox
            size="xs"
            label="Begin with where the numbers come from, as lines with #"
            data-testid="export-comments"
            checked={comments}
            onChange={(event) => setComments(event.currentTarget.checked)}
          />
        ) : null}
        {
          problem === "" ? null : <p className="review-bad import-problem" role="alert">{problem}</p> /* prettier-ignore */
        }
        {
          made.problem === "" ? null : <p className="review-bad import-problem" role="alert" data-testid="export-problem">{made.problem}</p> /* prettier-ignore */
        }
        {made.since === null ? (
          <Button
            size="xs"
            w="fit-content"
            leftSection={<IconDownload size={14} />}
            disabled={problem !== ""}
            data-testid="export-send"
            onClick={() => void made.start(format, choice)}
          >
            Export
          </Button>
        ) : (
          <Making since={made.since} onCancel={made.cancel} />
        )}
      </div>
    </Modal>
  );
}

interface MakingProps {
  /** Page clock [ms]. */
  readonly since: number;
  readonly onCancel: () => void;
}

/** The file is being made: for how long, and the way out. */
function Making({ since, onCancel }: MakingProps) {
  const [now, setNow] = useState(since);
  useEffect(() => {
    const beat = setInterval(() => setNow(performance.now()), 500); // prettier-ignore
    return () => {
      clearInterval(beat);
    };
  }, []);
  return (
    <div className="column export-making" role="status" data-testid="export-making">
      <Progress value={100} animated size="sm" aria-label="The file is being made" />
      <div className="row">
        <span>
          The file is being made, <span className="number">{Math.floor((now - since) / 1e3)} s</span>. The
          download begins when it is ready.
        </span>
        <Button size="compact-sm" variant="default" data-testid="export-cancel" onClick={onCancel}>
          Cancel
        </Button>
      </div>
    </div>
  );
}

/** Has a file made and then fetched by the browser; `onFetched` once that is asked for. Leaving the dialog cancels it. */
function useExport(id: string, onFetched: () => void) {
  const [since, setSince] = useState<number | null>(null);
  const [problem, setProblem] = useState("");
  const asked = useRef<AbortController>(null);
  const cancel = () => {
    asked.current?.abort();
    setSince(null);
  };
  useEffect(
    () => () => {
      asked.current?.abort();
    },
    [],
  );
  const start = async (format: Format, choice: ExportChoice) => {
    const { signal } = (asked.current = new AbortController());
    setSince(performance.now());
    setProblem("");
    try {
      fetchFile(
        format === "rrd" ? recordingUrl(id, ".rrd") : await api.makeExport(id, format, choice, signal),
      );
      onFetched();
    } catch (error) {
      if (!signal.aborted) {
        setSince(null);
        setProblem(textOf(error));
      }
    }
  };
  return { since, problem, start, cancel };
}

function fetchFile(url: string): void {
  const link = document.createElement("a");
  link.href = url;
  link.download = "";
  link.click();
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
    const each = new Map(fields.map((signal) => [signal.field, signal]));
    const items = [...each.values()].map(({ field, title, unit }) => ({
      value: field,
      label: unit === "1" ? `${title} (${field})` : `${title} (${field}) [${unit}]`,
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
