import { useState } from "react";
import { useTick } from "./useTick";

/** A value of the stream, looked at `rate` times a second; renders only when it changed. */
export function useSampled<T extends number | string | boolean>(read: () => T, rate: number): T {
  const [value, setValue] = useState(read);
  useTick(rate, () => {
    setValue(read);
  });
  return value;
}
