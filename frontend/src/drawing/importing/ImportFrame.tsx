import { Button, Group, SegmentedControl, TextInput } from "@mantine/core";
import { useEffect, useState, type ReactNode } from "react";
import { api, dataOf } from "../../api/rest";
import type { Point } from "../../api/types";
import { usePage } from "../../live/page";
import { Facts } from "../../ui/Facts";
import { millimetres, percent, seconds, textOf, wholeNumber } from "../../ui/format";
import { useService } from "../../ui/services";
import { Drawing, sketchOf, useDrawing } from "../drawing";
import { pieceOf } from "../piece";
import { storedOf, strokeOf } from "../pieces/stored";
import { boxOf, nameOf, sizeOf } from "./proposal";

/** A path that may be imported. */
export interface Found {
  /** As they would be followed, in the plane [m]. */
  readonly strokes: readonly (readonly Point[])[];
  /** Of the points of the only stroke [s]. */
  readonly times: readonly number[] | null;
  /** Why they cannot be kept. */
  readonly timesProblem: string;
  /** How many there are in the file. */
  readonly rows: number | null;
  readonly notes: readonly string[];
}

interface Props {
  readonly file: File;
  readonly found: Found | null;
  /** What must be said first; "" where nothing is. */
  readonly question: string;
  /** What is wrong with the file. */
  readonly problem: string;
  readonly children?: ReactNode;
  readonly onClose: () => void;
}

const SPEED = 0.02;

/** What would be imported: the path to scale, its figures and its times; and Import or Cancel. */
export function ImportFrame({ file, found, question, problem, children, onClose }: Props) {
  const drawing = useService(Drawing);
  const [name, setName] = useState(() => drawing.store.get().name.trim() || nameOf(file.name));
  const [wanted, setWanted] = useState(true);
  const more = useDrawing((state) => sketchOf(state).pieces.length > 0);
  const why = found?.timesProblem || (more ? "other pieces are drawn, and times are kept of one alone" : "");
  const timed = found?.times != null && wanted && why === "";
  const known = question === "" && problem === "" ? found : null;
  const take = () => {
    if (!known) return;
    const times = timed ? known.times : null;
    drawing.choose("drag");
    drawing.add(known.strokes.map((stroke) => pieceOf(stroke, times)));
    drawing.rename(name);
    if (timed) drawing.follow({ timing: { kind: "given" } });
    drawing.chooseSource("drawing");
    onClose();
  };
  return (
    <form
      className="column importing"
      data-testid="import-drawing"
      onSubmit={(event) => {
        event.preventDefault();
        take();
      }}
    >
      {children}
      {problem === "" ? null : (
        <p className="out-of-reach" role="alert" data-testid="import-problem">
          {problem}
        </p>
      )}
      {found ? <PathPicture strokes={found.strokes} /> : null}
      {found ? <Facts facts={factsOf(found, known)} testId="import-facts" /> : null}
      {known?.times ? <Times why={why} timed={timed} onChange={setWanted} /> : null}
      {known ? <Reach found={known} timed={timed} /> : null}
      {found && found.notes.length > 0 ? (
        <ul className="note" data-testid="import-notes">
          {found.notes.map((note) => (
            <li key={note}>{note}</li>
          ))}
        </ul>
      ) : null}
      {problem === "" ? (
        <TextInput
          size="xs"
          label="Name of the drawing"
          maxLength={80}
          data-testid="import-name"
          value={name}
          onChange={(event) => setName(event.currentTarget.value)}
        />
      ) : null}
      <Group justify="flex-end" gap="xs" className="import-end">
        <span className="note import-question" role="status" data-testid="import-question">
          {problem === "" ? question : ""}
        </span>
        <Button size="xs" variant="default" onClick={onClose}>
          Cancel
        </Button>
        <Button size="xs" type="submit" disabled={!known} data-testid="import-take">
          Import
        </Button>
      </Group>
    </form>
  );
}

/** Lengths only when their unit is known. */
function factsOf(found: Found, known: Found | null): (readonly [string, string])[] {
  const size = known ? sizeOf(known.strokes) : null;
  const points = found.strokes.reduce((sum, stroke) => sum + stroke.length, 0);
  return [
    found.rows === null ? ["Strokes", wholeNumber(found.strokes.length)] : ["Rows", wholeNumber(found.rows)],
    ["Points", wholeNumber(points)],
    ["Duration", seconds(known?.times?.at(-1), 2)],
    ["Length", millimetres(size?.length, 1)],
    ["Extent", size ? `${millimetres(size.width)} by ${millimetres(size.height)}` : millimetres(null)],
  ];
}

interface TimesProps {
  readonly why: string;
  readonly timed: boolean;
  readonly onChange: (wanted: boolean) => void;
}

/** Whether the path is followed at the file's own times. */
function Times({ why, timed, onChange }: TimesProps) {
  return (
    <div className="row">
      <SegmentedControl
        size="xs"
        aria-label="Times of the file"
        data-testid="import-times"
        disabled={why !== ""}
        value={timed ? "with" : "without"}
        onChange={(value) => onChange(value === "with")}
        data={[
          { value: "with", label: "With its times" },
          { value: "without", label: "Without times" },
        ]}
      />
      {why === "" ? null : <span className="note">Without: {why}.</span>}
    </div>
  );
}

/** How much of it is out of reach, and what is then followed. */
function Reach({ found, timed }: { readonly found: Found; readonly timed: boolean }) {
  const rig = usePage((page) => page.rig !== null);
  const [said, setSaid] = useState<{ readonly of: Found; readonly timed: boolean; readonly text: string }>();
  useEffect(() => {
    let current = true;
    if (rig)
      void reachOf(found, timed).then((text) => {
        if (current) setSaid({ of: found, timed, text });
      });
    return () => {
      current = false;
    };
  }, [found, timed, rig]);
  return (
    <p className="note" role="status" data-testid="import-reach">
      {said?.of === found && said.timed === timed ? said.text : "Reach: –"}
    </p>
  );
}

async function reachOf({ strokes, times }: Found, timed: boolean): Promise<string> {
  const path = timed ? strokeOf(strokes[0]) : storedOf(strokes.map((stroke) => pieceOf(stroke)));
  const body = {
    name: "import",
    ...path,
    times: timed && times ? [...times] : null,
    closed: false,
    smoothing: 0,
    outside: "project" as const,
    timing: timed ? { kind: "given" as const } : { kind: "speed" as const, speed: SPEED },
  };
  try {
    const { outside_share, reason } = await dataOf(api.POST("/api/drawings/plan", { body }));
    const share = outside_share > 0 ? `Reach: ${percent(outside_share, 0)} of the time out of it` : "Reach: all within"; // prettier-ignore
    return reason === "" ? share : `${share}; ${reason}`;
  } catch (error) {
    return `Cannot be followed so: ${textOf(error)}`;
  }
}

interface PictureProps {
  readonly strokes: readonly (readonly Point[])[];
}

/** The strokes to scale, as large as they go; a dot is where the path begins, thin lines are the ways between strokes. */
function PathPicture({ strokes }: PictureProps) {
  const { left, right, bottom, top } = boxOf(strokes);
  const size = Math.max(right - left, top - bottom);
  const margin = size * 0.06;
  const [width, height] = [right - left + 2 * margin, top - bottom + 2 * margin];
  const pixel = ([x, y]: Point) => `${(x - left + margin) / size},${(top - y + margin) / size}`;
  const ways = strokes.slice(1).map((stroke, i) => [strokes[i].at(-1) ?? stroke[0], stroke[0]]);
  const [x, y] = pixel(strokes[0][0]).split(",");
  return (
    <svg
      className="import-picture"
      data-testid="import-picture"
      viewBox={`0 0 ${width / size} ${height / size}`}
      role="img"
      aria-label="The path; the dot is where it begins"
    >
      {ways.map((way, i) => (
        <polyline key={i} className="import-way" points={way.map(pixel).join(" ")} />
      ))}
      {strokes.map((stroke, i) => (
        <polyline key={i} className="import-stroke" points={stroke.map(pixel).join(" ")} />
      ))}
      <circle className="import-start" cx={x} cy={y} r={0.014} />
    </svg>
  );
}
