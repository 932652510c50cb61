import { useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef, useState } from "react";
import { usePage } from "../live/page";
import { TargetControl } from "../operate/target/targetControl";
import { useService } from "../ui/services";
import { Ticker } from "../ui/ticker";
import { sceneUrl } from "./scene";
import type { ViewSession } from "./viewSession";

interface Props {
  readonly viewSession: ViewSession;
  readonly title: string;
  readonly onReady?: () => void;
}

/** How often it is looked whether a hand is on the target. */
const REFRESH_HZ = 10;

/** viser in a frame with a viewSession of its own; ground and colours follow the page's scheme. */
export function SceneFrame({ viewSession, title, onReady }: Props) {
  const scheme = useComputedColorScheme("dark");
  const online = usePage((page) => page.online);
  const [loaded, setLoaded] = useState(false);
  const [source] = useState(() => sceneUrl(viewSession.id, "top", scheme));
  useEffect(() => {
    if (loaded && online) viewSession.arrived(scheme);
  }, [viewSession, scheme, loaded, online]);
  const frame = useRef<HTMLIFrameElement>(null);
  const [targetControl, ticker] = [useService(TargetControl), useService(Ticker)];
  useEffect(() => {
    // Drawn in software it takes its time from the plan, where the hand is (server/http/frames.py).
    let told = false;
    return ticker.every(REFRESH_HZ, "3D view", () => {
      if (targetControl.held === told) return;
      told = targetControl.held;
      frame.current?.contentWindow?.postMessage({ tendril: "sparing", on: told }, window.location.origin);
    });
  }, [targetControl, ticker]);
  useEffect(
    () => () => {
      viewSession.close();
    },
    [viewSession],
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
