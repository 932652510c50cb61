import { useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef, useState } from "react";
import { usePage } from "../live/page";
import { Aim } from "../operate/target/target";
import { useService } from "../ui/services";
import { Ticker } from "../ui/ticker";
import { sceneUrl } from "./scene";
import type { Seat } from "./seat";

interface Props {
  readonly seat: Seat;
  readonly title: string;
  readonly onReady?: () => void;
}

/** How often it is looked whether a hand is on the target. */
const LOOKS_PER_S = 10;

/** viser in a frame with a seat of its own; ground and colours follow the page's scheme. */
export function SceneFrame({ seat, title, onReady }: Props) {
  const scheme = useComputedColorScheme("dark");
  const online = usePage((page) => page.online);
  const [loaded, setLoaded] = useState(false);
  const [source] = useState(() => sceneUrl(seat.id, "top", scheme));
  useEffect(() => {
    if (loaded && online) seat.arrived(scheme);
  }, [seat, scheme, loaded, online]);
  const frame = useRef<HTMLIFrameElement>(null);
  const [aim, ticker] = [useService(Aim), useService(Ticker)];
  useEffect(() => {
    // Drawn in software it takes its time from the plan, where the hand is (server/http/frames.py).
    let told = false;
    return ticker.every(LOOKS_PER_S, "3D view", () => {
      if (aim.held === told) return;
      told = aim.held;
      frame.current?.contentWindow?.postMessage({ tendril: "sparing", on: told }, window.location.origin);
    });
  }, [aim, ticker]);
  useEffect(
    () => () => {
      seat.close();
    },
    [seat],
  );
  return (
    <iframe
      ref={frame}
      className="scene-frame"
      title={title}
      src={source}
      onLoad={() => {
        setLoaded(true);
        onReady?.();
      }}
    />
  );
}
