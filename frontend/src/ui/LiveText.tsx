import { useRef } from "react";
import { useTick } from "./ticker";

interface Props {
  /** Gives the text to show now; called at `rate` per second, without React. */
  readonly read: () => string;
  readonly rate?: number;
  readonly testId?: string;
}

/** A number of the stream: written straight into the page, so that the tree does not render. */
export function LiveText({ read, rate = 5, testId }: Props) {
  const element = useRef<HTMLSpanElement>(null);
  useTick(rate, () => {
    const text = read();
    if (element.current && element.current.textContent !== text) element.current.textContent = text;
  });
  return <span ref={element} className="number" data-testid={testId} />;
}
