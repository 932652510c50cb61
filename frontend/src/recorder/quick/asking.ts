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
