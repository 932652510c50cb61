import { useEffect, useState } from "react";
import type { Quick } from "../../api/types";
import { textOf } from "../../ui/format";
import { recordings } from "../recordings";
import { DRAWN } from "./quickCharts";

const POINTS = 2000;
/** A recording that is being written is read again so long after the last answer [ms]. */
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
    const end = askAgain(read, running ? REFRESH_MS : undefined);
    return () => {
      gone = true;
      end();
    };
  }, [wanted, running]);
  return state;
}

/** Asks at once, and again `period` [ms] after each answer, so that slow ones never pile up; not without a period.
 *
 * What is given back ends it. `ask` never fails.
 */
export function askAgain(ask: () => Promise<void>, period?: number): () => void {
  let [ended, timer]: [boolean, ReturnType<typeof setTimeout> | undefined] = [false, undefined];
  const go = async () => {
    await ask();
    if (!ended && period !== undefined) timer = setTimeout(() => void go(), period);
  };
  void go();
  return () => {
    ended = true;
    clearTimeout(timer);
  };
}
