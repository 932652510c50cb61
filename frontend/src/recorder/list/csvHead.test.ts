import { expect, test } from "vitest";
import { unitsMissing } from "./csvHead";

test("units are asked for where the header of a file names none", () => {
  expect(unitsMissing("t_ms, x [mm], y (mm)\n0,1,2\n")).toEqual({ time: false, length: false });
  expect(unitsMissing("# from lab B\n\ntime;x;y\n0;1,5;2\n")).toEqual({ time: true, length: true });
  expect(unitsMissing("time [s]\tx\ty_mm\n")).toEqual({ time: false, length: true });
  expect(unitsMissing("0 1 2\n1 2 3\n")).toEqual({ time: true, length: true });
  expect(unitsMissing("﻿t (us),x (m),y (m),force [N]\r\n")).toEqual({ time: false, length: false });
  expect(unitsMissing("")).toEqual({ time: true, length: true });
});
