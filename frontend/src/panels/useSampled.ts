import { useEffect, useRef, useState } from "react";
import { useDashboard } from "./context";

/** A value of the stream, looked at `rate` times a second; renders only when it changed. */
export function useSampled<T extends number | string | boolean>(read: () => T, rate: number): T {
  const { ticker } = useDashboard();
  const [value, setValue] = useState(read);
  const reader = useRef(read);
  useEffect(() => {
    reader.current = read;
  });
  useEffect(
    () =>
      ticker.every(rate, () => {
        setValue(() => reader.current());
      }),
    [ticker, rate],
  );
  return value;
}
