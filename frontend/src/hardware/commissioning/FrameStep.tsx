import { useState } from "react";
import { namesOf, raw, trouble, type DriverStatus } from "../drivers";
import { useDrivers } from "../useDrivers";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { Commissioning } from "./commissioning";
import { usualPoint, type Captured, type Place } from "./steps";

const REFRESH_HZ = 5;
const NO_LABELS = {};

const PLACES: readonly { readonly place: Place; readonly title: string; readonly how: string }[] = [
  {
    place: "base",
    title: "Base",
    how: "Hold a marker at the clamp, in the middle of the arm, and keep it still.",
  },
  { place: "tip", title: "Tip at rest", how: "Let the arm hang at rest; the tip's own marker is captured." },
  { place: "bent", title: "Bent pose", how: "The same marker; u1+ fills by itself meanwhile. Keep clear." },
];

/** Three captures, with the chosen point's raw coordinates as they come. */
export function FrameStep({ captured }: { readonly captured: readonly Captured[] }) {
  const { drivers, problem } = useDrivers(REFRESH_HZ);
  const labels = usePage((page) => page.rig?.parameters.hardware?.motion_capture.labels ?? NO_LABELS);
  const [chosen, setChosen] = useState<string | null>(null);
  const camera = drivers.find(({ role }) => role === "motion_capture");
  const names = camera ? namesOf(camera.values) : [];
  const point = chosen ?? usualPoint(names, labels);
  return (
    <div className="column" data-testid="frame-step">
      <Points camera={camera} names={names} point={point} choose={setChosen} />
      {problem === "" ? null : (
        <p className="note" role="alert" data-grade="bad">
          {problem}
        </p>
      )}
      <ol className="column captures">
        {PLACES.map(({ place, title, how }) => (
          <Capture
            key={place}
            place={place}
            title={title}
            how={how}
            point={point}
            done={captured.find((one) => one.place === place) ?? null}
          />
        ))}
      </ol>
    </div>
  );
}

interface PointsProps {
  readonly camera: DriverStatus | undefined;
  readonly names: readonly string[];
  readonly point: string | null;
  readonly choose: (name: string) => void;
}

/** What the camera sees, in its own coordinates; one of these is captured next. */
function Points({ camera, names, point, choose }: PointsProps) {
  if (!camera) return <p className="note">Asking the camera.</p>;
  if (names.length === 0) return <p data-grade="bad">{trouble(camera) || "The camera sees no point."}</p>;
  return (
    <fieldset className="points">
      <legend className="note">Point to capture, in the camera's own coordinates</legend>
      {names.map((name) => (
        <label key={name} className="point">
          <input type="radio" name="point" checked={name === point} onChange={() => choose(name)} />
          <span>{name}</span>
          <span className="number">{(camera.values[name] ?? []).map(raw).join(", ")}</span>
        </label>
      ))}
    </fieldset>
  );
}

interface CaptureProps {
  readonly place: Place;
  readonly title: string;
  readonly how: string;
  readonly point: string | null;
  readonly done: Captured | null;
}

function Capture({ place, title, how, point, done }: CaptureProps) {
  const commissioning = useService(Commissioning);
  const asking = useStore(commissioning.store, (seen) => seen.asking);
  const because =
    asking !== "" ? "A point is being captured" : point === null ? "Choose the point first" : null;
  return (
    <li className="capture">
      <span className="capture-title">{title}</span>
      <ControlButton
        control="settings"
        because={because}
        variant={done === null ? "filled" : "default"}
        size="compact-sm"
        loading={asking === `capture ${place}`}
        testId={`capture-${place}`}
        meaning="Takes half a second"
        onClick={() => void commissioning.capture(place, point)}
      >
        {done === null ? "Capture" : "Capture again"}
      </ControlButton>
      <span className="note capture-how">
        {done === null ? (
          how
        ) : (
          <span className="number" data-testid={`captured-${place}`}>
            {done.point}: {done.at.map(raw).join(", ")}, within {raw(done.spread)}
          </span>
        )}
      </span>
    </li>
  );
}
