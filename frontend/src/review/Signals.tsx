import { Loader, useComputedColorScheme } from "@mantine/core";
import { useEffect, useState } from "react";
import { viewerUrl } from "../api/rest";

/** The recording in rerun's own viewer. */
export function Signals({ id }: { readonly id: string }) {
  const scheme = useComputedColorScheme("dark");
  const [ready, setReady] = useState(false);
  useEffect(() => {
    const hear = (event: MessageEvent<unknown>) => {
      if (event.origin === window.location.origin && event.data === "READY") setReady(true);
    };
    window.addEventListener("message", hear);
    return () => {
      window.removeEventListener("message", hear);
    };
  }, []);
  const renderer = new URLSearchParams(window.location.search).get("rerun_renderer");
  return (
    <>
      {ready ? null : <Loader size="xs" m="xs" data-testid="viewer-loading" />}
      <iframe
        className="viewer-frame"
        title="Recording in rerun"
        data-testid="viewer"
        data-ready={ready}
        src={viewerUrl(window.location.origin, id, scheme, renderer)}
      />
    </>
  );
}
