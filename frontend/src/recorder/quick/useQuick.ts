import { useEffect, useState } from "react";
import type { Quick } from "../../api/types";
import { textOf } from "../../ui/format";
import { recordings } from "../recordings";
import { DRAWN } from "./quickCharts";

const POINTS = 2000;
/** How often a recording that is being written is read again [ms]. */
const REFRESH_MS = 2000;

export interface QuickState {
  /** In the order of the ids; null while they are read. */
  readonly looks: readonly Quick[] | null;
  readonly problem: string;
}

/** The quick looks at recordings; `running` ones are read again and again. */
export function useQuick(ids: readonly string[], running: boolean): QuickState {
  const [state, setState] = useState<QuickState>({ looks: null, problem: "" });
  const wanted = ids.join(",");
  useEffect(() => {
    let gone = false;
    const read = async () => {
      try {
        const looks = await Promise.all(wanted.split(",").map((id) => recordings.quick(id, POINTS, DRAWN)));
        if (!gone) setState({ looks, problem: "" });
      } catch (error) {
        if (!gone) setState({ looks: null, problem: textOf(error) });
      }
    };
    void read();
    const again = running ? setInterval(() => void read(), REFRESH_MS) : undefined;
    return () => {
      gone = true;
      clearInterval(again);
    };
  }, [wanted, running]);
  return state;
}
