import { useComputedColorScheme } from "@mantine/core";
import { useEffect, useState } from "react";
import { usePage } from "../live/page";
import { sceneUrl } from "./scene";
import type { Seat } from "./seat";

interface Props {
  readonly seat: Seat;
  readonly title: string;
  readonly onReady?: () => void;
}

/** viser in a frame with a seat of its own; ground and colours follow the page's scheme. */
export function SceneFrame({ seat, title, onReady }: Props) {
  const scheme = useComputedColorScheme("dark");
  const online = usePage((page) => page.online);
  const [loaded, setLoaded] = useState(false);
  const [source] = useState(() => sceneUrl(seat.id, "top", scheme));
  useEffect(() => {
    if (loaded && online) seat.arrived(scheme);
  }, [seat, scheme, loaded, online]);
  useEffect(
    () => () => {
      seat.close();
    },
    [seat],
  );
  return (
    <iframe
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
