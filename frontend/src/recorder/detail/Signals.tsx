import { Loader, useComputedColorScheme } from "@mantine/core";
import { useEffect, useRef, useState } from "react";
import { recordingUrl, viewerUrl } from "../recordings";

interface Props {
  readonly id: string;
  /** It is started hidden before: a viewer takes seconds to start. */
  readonly shown: boolean;
  /** Where its cursor is put first: the run's begin [s]; null while that is not known. */
  readonly start: number | null;
}

/** The recording in rerun's own viewer. */
export function Signals(props: Props) {
  const scheme = useComputedColorScheme("dark", { getInitialValueInEffect: false });
  return <Viewer key={scheme} scheme={scheme} {...props} />;
}

interface ViewerProps extends Props {
  readonly scheme: "dark" | "light";
}

function Viewer({ id, shown, start, scheme }: ViewerProps) {
  const { origin } = window.location;
  const url = origin + recordingUrl(id, `/shown.rrd?theme=${scheme}`);
  const frame = useRef<HTMLIFrameElement>(null);
  const opened = useRef(shown);
  const [ready, setReady] = useState(false);
  const [source] = useState(() => viewerUrl(shown ? url : null, scheme, wishedRenderer()));
  useEffect(() => {
    const hear = ({ source, data }: MessageEvent<unknown>) => {
      if (source === frame.current?.contentWindow && data === "READY") setReady(true);
    };
    window.addEventListener("message", hear);
    return () => {
      window.removeEventListener("message", hear);
    };
  }, []);
  useEffect(() => {
    if (!ready || !shown || opened.current) return;
    opened.current = true;
    frame.current?.contentWindow?.postMessage({ tendril: "open", url }, origin);
  }, [origin, url, ready, shown]);
  useEffect(() => {
    if (ready && shown && start !== null)
      frame.current?.contentWindow?.postMessage({ tendril: "seek", seconds: start }, origin);
  }, [origin, ready, shown, start]);
  return (
    <>
      {ready || !shown ? null : (
        <Loader className="viewer-loading" size="xs" m="xs" data-testid="viewer-loading" />
      )}
      <iframe
        ref={frame}
        className="viewer-frame"
        title="Recording in rerun"
        data-testid="viewer"
        data-ready={ready}
        data-shown={shown}
        inert={!shown}
        src={source}
      />
    </>
  );
}

function wishedRenderer(): string | null {
  return new URLSearchParams(window.location.search).get("rerun_renderer");
}
