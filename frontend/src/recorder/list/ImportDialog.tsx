import { Button, Modal, SegmentedControl, TextInput } from "@mantine/core";
import { useState } from "react";
import { bytes, textOf } from "../../ui/format";
import { LENGTH_UNITS, recordings as api, TIME_UNITS, type Units, type UnitsMissing } from "../recordings";
import type { Recordings } from "../useRecordings";

export interface Chosen {
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
export function ImportDialog({ chosen: { file, missing }, recordings, onClose }: Props) {
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
          onChange={(event) => {
            setName(event.currentTarget.value);
          }}
        />
        {missing.time || missing.length ? (
          <p className="note">The header names no unit: in what are these numbers?</p>
        ) : (
          <p className="note">Units are those of the header; {bytes(file.size)}.</p>
        )}
        {missing.time ? (
          <Unit label="Time" of={TIME_UNITS} value={units.time} onChange={(time) => { setUnits({ ...units, time }); }} /> // prettier-ignore
        ) : null}
        {missing.length ? (
          <Unit label="x and y" of={LENGTH_UNITS} value={units.length} onChange={(length) => { setUnits({ ...units, length }); }} /> // prettier-ignore
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
