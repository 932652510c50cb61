import { useEffect, type KeyboardEvent, type PointerEvent } from "react";
import type { components } from "../../api/schema";
import { usePage } from "../../live/page";
import { ControlButton } from "../../operate/ControlButton";
import { useWhyNot } from "../../operate/permission";
import { kilopascals, plain } from "../../ui/format";
import { useService } from "../../ui/services";
import { useStore } from "../../ui/store";
import { Commissioning } from "./commissioning";
import { answered, CHAMBERS, type Chamber, type Jogged } from "./steps";

type JogView = components["schemas"]["JogView"];

/** Full scale of the bars [Pa]: the most that a jogged chamber gets. */
const FULL = 40e3;

/** Four buttons to hold; beside each what its sensor shows, what rose, and which chamber the operator saw fill. */
export function JogStep({ jog }: { readonly jog: JogView | null }) {
  const commissioning = useService(Commissioning);
  const clear = useStore(commissioning.store, (seen) => seen.clear);
  const alive = usePage((page) => page.online && page.rigLive);
  const max = usePage((page) => page.rig?.parameters.hardware?.valves.pressure_max ?? NaN);
  if (!clear)
    return (
      <div className="column jog-clear" role="group" aria-label="Before the first chamber is filled">
        <p>
          No one reaches into the arm, and the supply can be shut by hand. A chamber fills while its button is
          held, to at most {kilopascals(Math.min(FULL, max))}, and empties when it is let go.
        </p>
        <ControlButton
          control="settings"
          testId="jog-clear"
          meaning="Show the four buttons"
          onClick={() => commissioning.confirmClear()}
        >
          That is so
        </ControlButton>
      </div>
    );
  return (
    <div className="column" data-testid="jog">
      <p className="note">
        Hold a button for a second (Space by keys), look at the arm, and say which chamber filled.
      </p>
      {CHAMBERS.map((chamber, i) => (
        <JogRow
          key={chamber}
          chamber={chamber}
          pressure={alive ? (jog?.pressures[i] ?? null) : null}
          jogged={jog?.jogged.find(({ commanded }) => commanded === chamber) ?? null}
        />
      ))}
    </div>
  );
}

interface RowProps {
  readonly chamber: Chamber;
  readonly pressure: number | null;
  readonly jogged: Jogged | null;
}

function JogRow({ chamber, pressure, jogged }: RowProps) {
  const answer = jogged ? answered(jogged) : null;
  const share = Math.min(1, Math.max(0, (pressure ?? 0) / FULL));
  return (
    <div className="jog-row" role="group" aria-label={`Chamber ${chamber}`}>
      <JogButton chamber={chamber} />
      <span className="jog-bar" aria-hidden>
        <span style={{ width: `${100 * share}%` }} />
      </span>
      <span className="number jog-pressure" data-testid={`jog-pressure-${chamber}`}>
        {plain(pressure === null ? null : pressure / 1e3, 1)} kPa
      </span>
      <span
        className="note jog-rose"
        data-grade={answer === null ? undefined : answer.good ? "good" : "bad"}
        data-testid={`jog-rose-${chamber}`}
      >
        {answer?.text ?? "not jogged yet"}
      </span>
      <Filled commanded={chamber} filled={jogged?.filled ?? null} jogged={jogged !== null} />
    </div>
  );
}

interface FilledProps {
  readonly commanded: Chamber;
  readonly filled: Chamber | null;
  readonly jogged: boolean;
}

/** Which chamber the operator saw fill; its place is kept before that can be said. */
function Filled({ commanded, filled, jogged }: FilledProps) {
  const commissioning = useService(Commissioning);
  const forbidden = useWhyNot("settings");
  const reason = forbidden ?? (jogged ? null : `Hold the button of ${commanded} first`);
  return (
    <span className="jog-filled" role="group" aria-label={`Which chamber filled when ${commanded} was held?`}>
      <span className="note">{filled === null ? "Which filled?" : "Filled:"}</span>
      {CHAMBERS.map((chamber) => (
        <button
          key={chamber}
          type="button"
          className="chip"
          aria-pressed={filled === chamber}
          aria-disabled={reason !== null}
          title={reason ?? `When ${commanded} was held, ${chamber} filled`}
          data-testid={`jog-filled-${commanded}-${chamber}`}
          onClick={() => {
            if (reason === null) void commissioning.confirm(commanded, chamber);
          }}
        >
          {chamber}
        </button>
      ))}
    </span>
  );
}

/** A button that fills a chamber while it is held, by pointer, finger or Space; it lets go however the hold ends. */
function JogButton({ chamber }: { readonly chamber: Chamber }) {
  const { jog, store } = useService(Commissioning);
  const held = useStore(store, (seen) => seen.held === chamber);
  const reason = useWhyNot("settings");
  const release = () => jog.release(chamber);
  useEffect(() => {
    if (reason !== null) jog.release(chamber);
    return () => {
      jog.release(chamber);
    };
  }, [jog, chamber, reason]);
  useEffect(() => {
    if (!held) return;
    const letGo = () => jog.release();
    window.addEventListener("blur", letGo);
    window.addEventListener("pagehide", letGo);
    document.addEventListener("visibilitychange", letGo);
    return () => {
      window.removeEventListener("blur", letGo);
      window.removeEventListener("pagehide", letGo);
      document.removeEventListener("visibilitychange", letGo);
    };
  }, [jog, held]);
  const press = () => {
    if (reason === null) jog.press(chamber);
  };
  const down = (event: PointerEvent<HTMLButtonElement>) => {
    if (event.button !== 0 || !event.isPrimary) return;
    // A finger is captured by what it touched first: it would then never be seen to leave
    if (event.currentTarget.hasPointerCapture(event.pointerId))
      event.currentTarget.releasePointerCapture(event.pointerId);
    press();
  };
  const key = (event: KeyboardEvent<HTMLButtonElement>) => {
    if (event.key !== " ") return;
    event.preventDefault();
    if (!event.repeat) press();
  };
  return (
    <button
      type="button"
      className="jog-button"
      aria-label={`Hold to fill ${chamber}`}
      aria-pressed={held}
      aria-disabled={reason !== null}
      title={reason ?? `Fills ${chamber} while it is held`}
      data-testid={`jog-${chamber}`}
      onPointerDown={down}
      onPointerUp={release}
      onPointerCancel={release}
      onPointerLeave={release}
      onKeyDown={key}
      onKeyUp={(event) => {
        if (event.key === " ") release();
      }}
      onBlur={release}
      onContextMenu={(event) => event.preventDefault()}
    >
      {held ? "Filling" : "Fill"} {chamber}
    </button>
  );
}
