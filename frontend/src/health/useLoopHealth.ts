import { useEffect, useState } from "react";
import { rest } from "../api/rest";
import type { LoopHealth } from "../api/types";

const PERIOD_MS = 1000;

/** The server's judgement of the loop, asked for once a second while it is shown; null while it does not answer. */
export function useLoopHealth(): LoopHealth | null {
  const [health, setHealth] = useState<LoopHealth | null>(null);
  useEffect(() => {
    let shown = true;
    const ask = async () => {
      const answer = await rest.loopHealth().catch(() => null);
      if (shown) setHealth(answer);
    };
    const timer = setInterval(() => void ask(), PERIOD_MS);
    void ask();
    return () => {
      shown = false;
      clearInterval(timer);
    };
  }, []);
  return health;
}
