import { useEffect, useRef } from "react";
import { useDashboard } from "./context";

interface Props {
  /** Gives the text to show now; called at `rate` per second, without React. */
  readonly read: () => string;
  readonly rate?: number;
  readonly testId?: string;
}

/** A number of the stream: written straight into the page, so that the tree does not render. */
export function LiveText({ read, rate = 5, testId }: Props) {
  const { ticker } = useDashboard();
  const element = useRef<HTMLSpanElement>(null);
  const reader = useRef(read);
  useEffect(() => {
    reader.current = read;
  });
  useEffect(
    () =>
      ticker.every(rate, () => {
        const text = reader.current();
        if (element.current && element.current.textContent !== text) element.current.textContent = text;
      }),
    [ticker, rate],
  );
  return <span ref={element} className="number" data-testid={testId} />;
}
