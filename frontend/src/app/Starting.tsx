import { Loader } from "@mantine/core";
import { useEffect, useState } from "react";

const SLOW_MS = 1500;

/** Before the server's first answer. */
export function Starting() {
  const [slow, setSlow] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => {
      setSlow(true);
    }, SLOW_MS);
    return () => {
      clearTimeout(timer);
    };
  }, []);
  return (
    <main className="starting" role="status" data-testid="starting">
      <Loader aria-hidden />
      <p>{slow ? "The server does not answer yet. This page goes on trying." : "Connecting"}</p>
    </main>
  );
}
