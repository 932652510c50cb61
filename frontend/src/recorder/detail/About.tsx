import { Pill, TagsInput, Textarea, TextInput } from "@mantine/core";
import type { Recording } from "../../api/types";
import { useWhyNot } from "../../operate/permission";
import { bytes, clock, millimetres, percent, wholeNumber } from "../../ui/format";
import { marksOf } from "../list/listing";
import type { Recordings } from "../useRecordings";
import { useDraft } from "./useDraft";

interface Props {
  readonly recording: Recording;
  readonly running: boolean;
  readonly recordings: Recordings;
}

/** What is known about a recording, and what people write on it; kept when a field is left. */
export function About({ recording, running, recordings }: Props) {
  const reason = useWhyNot("edit");
  const { id, tags } = recording;
  const name = useDraft(recording.name, (text) => void recordings.change(id, { name: text }));
  const notes = useDraft(recording.notes, (text) => void recordings.change(id, { notes: text }));
  const reasons = marksOf(recording, running).filter(({ bad }) => bad);
  return (
    <section className="review-about" aria-label="About the recording">
      {reasons.length === 0 ? null : (
        <ul className="review-reasons" data-testid="reasons">
          {reasons.map(({ text, reason }) => (
            <li key={text}>{reason}</li>
          ))}
        </ul>
      )}
      <dl className="facts">
        {factsOf(recording).map(([term, fact]) => (
          <div key={term}>
            <dt>{term}</dt>
            <dd className="number cut" title={fact}>
              {fact}
            </dd>
          </div>
        ))}
      </dl>
      <div className="row review-fields" title={reason ?? undefined}>
        <TextInput
          size="xs"
          label="Name"
          readOnly={reason !== null}
          maxLength={80}
          title={name.text}
          data-testid="recording-name"
          value={name.text}
          onChange={(event) => name.write(event.currentTarget.value)}
          onBlur={name.leave}
        />
        <TagsInput
          size="xs"
          label="Tags"
          readOnly={reason !== null}
          w={240}
          maxTags={20}
          data-testid="recording-tags"
          value={[...tags]}
          renderPill={({ value, onRemove, disabled = false }) => (
            <Pill title={value} withRemoveButton={!disabled} {...(onRemove ? { onRemove } : {})}>
              {value}
            </Pill>
          )}
          onChange={(next) => void recordings.change(id, { tags: next })}
        />
        <Textarea
          size="xs"
          label="Notes"
          readOnly={reason !== null}
          autosize
          minRows={1}
          maxRows={4}
          maxLength={4000}
          className="review-notes"
          data-testid="recording-notes"
          value={notes.text}
          onChange={(event) => notes.write(event.currentTarget.value)}
          onBlur={notes.leave}
        />
      </div>
    </section>
  );
}

/** Facts and figures; what is not known is left out. */
function factsOf(recording: Recording): [string, string][] {
  const { actuator, twin, operator, reference, seconds, rows, gaps, metrics, imported } = recording;
  const facts: [string, string][] = [
    ["Actuator", actuator === "" ? "" : `${actuator}${twin ? " · twin" : ""}`],
    ["Operator", operator],
    ["Reference", reference],
    ["Duration", clock(seconds)],
    ["Rows", wholeNumber(rows)],
    ["Gaps", wholeNumber(gaps)],
    ["Size", bytes(recording.bytes)],
    ["Kept", imported ? "" : recording.profile],
    ["RMSE", metrics ? millimetres(metrics.rmse, 2) : ""],
    ["Largest error", metrics ? millimetres(metrics.max_error, 2) : ""],
    [
      "Figures",
      reference && metrics ? (metrics.approach === null ? "with the approach" : "after the approach") : "",
    ],
    ["On time", metrics ? percent(metrics.on_time_share) : ""],
  ];
  return facts.filter(([, fact]) => fact !== "");
}
