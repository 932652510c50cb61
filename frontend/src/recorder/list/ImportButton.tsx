import { Button, FileButton, Modal, SegmentedControl, TextInput } from "@mantine/core";
import { IconFileImport } from "@tabler/icons-react";
import { useRef, useState } from "react";
import { ControlButton } from "../../operate/ControlButton";
import {
  LENGTH_UNITS,
  recordings as api,
  TIME_UNITS,
  unitsMissing,
  type Units,
  type UnitsMissing,
} from "../recordings";
import type { Recordings } from "../useRecordings";
import { bytes, textOf } from "../../ui/format";
import { readPath } from "../../drawing/readPath";

/** Another lab's CSV file as a recording: choose it, say what its header does not, look at what came of it. */
export function ImportButton({ recordings }: { readonly recordings: Recordings }) {
  const [chosen, setChosen] = useState<Chosen | null>(null);
  const again = useRef<() => void>(null);
  const choose = async (file: File | null) => {
    again.current?.(); // the same file may be chosen once more, mended
    if (file) setChosen({ file, missing: unitsMissing(await readPath(file).catch(() => null)) });
  };
  return (
    <>
      <FileButton
        accept=".csv,.txt,text/csv"
        resetRef={again}
        inputProps={{ "aria-label": "CSV file to import as a recording" }}
        onChange={(file) => void choose(file)}
      >
        {({ onClick }) => (
          <ControlButton
            control="settings"
            size="compact-sm"
            variant="default"
            leftSection={<IconFileImport size={14} />}
            testId="import-recording"
            meaning="A CSV file with columns time, x, y becomes a recording"
            onClick={onClick}
          >
            Import CSV
          </ControlButton>
        )}
      </FileButton>
      {chosen ? (
        <ImportDialog
          key={`${chosen.file.name} ${chosen.file.lastModified}`}
          chosen={chosen}
          recordings={recordings}
          onClose={() => setChosen(null)}
        />
      ) : null}
    </>
  );
}

interface Chosen {
  readonly file: File;
  /** What its header does not say. */
  readonly missing: UnitsMissing;
}

interface Props {
  readonly chosen: Chosen;
  readonly recordings: Recordings;
  readonly onClose: () => void;
}

const NAME_MAX = 80;

/** Name and units of the file that was chosen; what is wrong with it stands here, by line and column. */
function ImportDialog({ chosen: { file, missing }, recordings, onClose }: Props) {
  const [name, setName] = useState(file.name.replace(/\.[^.]*$/, "").slice(0, NAME_MAX));
  const [units, setUnits] = useState<Units>({ time: "s", length: "m" });
  const [busy, setBusy] = useState(false);
  const [problem, setProblem] = useState("");
  const send = async () => {
    setBusy(true);
    try {
      await api.take(file, name.trim(), units);
      onClose();
      recordings.load();
    } catch (error) {
      setBusy(false);
      setProblem(textOf(error));
    }
  };
  return (
    <Modal
      opened
      onClose={onClose}
      title={`Import ${file.name}`}
      closeButtonProps={{ "aria-label": "Close" }}
    >
      <form
        className="import"
        data-testid="import"
        onSubmit={(event) => {
          event.preventDefault();
          void send();
        }}
      >
        <TextInput
          size="xs"
          label="Name of the recording"
          required
          maxLength={NAME_MAX}
          data-autofocus
          data-testid="import-name"
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
        {missing.time || missing.length ? (
          <p className="note">The header names no unit: in what are these numbers?</p>
        ) : (
          <p className="note">Units are those of the header; {bytes(file.size)}.</p>
        )}
        {missing.time ? (
          <Unit label="Time" of={TIME_UNITS} value={units.time} onChange={(time) => setUnits({ ...units, time })} /> // prettier-ignore
        ) : null}
        {missing.length ? (
          <Unit label="x and y" of={LENGTH_UNITS} value={units.length} onChange={(length) => setUnits({ ...units, length })} /> // prettier-ignore
        ) : null}
        {problem === "" ? null : (
          <p className="review-bad import-problem" role="alert" data-testid="import-problem">
            {problem}
          </p>
        )}
        <Button
          type="submit"
          size="xs"
          w="fit-content"
          loading={busy}
          disabled={name.trim() === ""}
          data-testid="import-send"
        >
          Import
        </Button>
      </form>
    </Modal>
  );
}

interface UnitProps<T extends string> {
  readonly label: string;
  readonly of: readonly T[];
  readonly value: T;
  readonly onChange: (unit: T) => void;
}

function Unit<T extends string>({ label, of, value, onChange }: UnitProps<T>) {
  return (
    <div className="row">
      <span className="import-unit">{label}</span>
      <SegmentedControl
        size="xs"
        aria-label={`Unit of ${label}`}
        data-testid={`unit-${label === "Time" ? "time" : "length"}`}
        value={value}
        onChange={onChange}
        data={of.map((unit) => ({ value: unit, label: unit === "us" ? "µs" : unit }))}
      />
    </div>
  );
}
