import { VisuallyHidden } from "@mantine/core";
import { usePage } from "../live/page";
import { useSampled } from "../ui/ticker";
import { GAUGES, GRADE_MARK, GRADE_WORD, gradeOf, type Grade, type Measure } from "./health";

interface ReadingProps {
  readonly measure: Measure;
  /** The number that is graded; nan while there is none. */
  readonly read: () => number;
  /** The number that is shown, where it is another one. */
  readonly shown?: (() => number) | undefined;
  readonly rate?: number;
  readonly testId?: string;
}

/** A number of the health strip with its grade as colour, mark and (to a screen reader) word. */
export function HealthReading(reading: ReadingProps) {
  // Another measure is another reading: the number last seen of the one before is none of it.
  return <Sampled key={reading.measure} {...reading} />;
}

function Sampled({ measure, read, shown, rate = 2, testId }: ReadingProps) {
  const value = useSampled(read, rate);
  const other = useSampled(shown ?? (() => NaN), rate);
  const alarms = usePage((page) => page.alarms);
  const grade = gradeOf(measure, value, alarms);
  return (
    <span className="graded" data-grade={grade}>
      <span className="grade-mark" aria-hidden>
        {GRADE_MARK[grade]}
      </span>
      <span className="number" data-testid={testId}>
        {GAUGES[measure].show(shown ? other : value)}
      </span>
      <VisuallyHidden>{GRADE_WORD[grade]}</VisuallyHidden>
    </span>
  );
}

/** A grade as colour, mark and word. */
export function GradeWord({ grade }: { readonly grade: Grade }) {
  return (
    <span className="grade" data-grade={grade}>
      <span aria-hidden>{GRADE_MARK[grade]}</span> {GRADE_WORD[grade]}
    </span>
  );
}
