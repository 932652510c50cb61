import { expect, test } from "vitest";
import { recordingUrl, unitsMissing, viewerUrl } from "./recordings";

test("rerun's viewer gets an absolute address that ends in .rrd", () => {
  const url = viewerUrl(`http://rig:8000${recordingUrl("2026-01-01 a", ".rrd")}`, "dark", "webgl");
  const query = new URL(url, "http://rig:8000").searchParams;
  expect(query.get("url")).toBe("http://rig:8000/api/recordings/2026-01-01%20a.rrd");
  expect(query.get("renderer")).toBe("webgl");
  expect(viewerUrl("a", "light", null)).not.toContain("renderer");
});

test("units are asked for where the server had to assume them, all of them where it could not read the file", () => {
  const column = (name: "t" | "x" | "y", stated: boolean) => ({ name, title: name, unit: "m", stated });
  const columns = [column("t", true), column("x", true), column("y", false)];
  expect(unitsMissing({ columns })).toEqual({ time: false, length: true });
  expect(unitsMissing({ columns: columns.slice(0, 2) })).toEqual({ time: false, length: false });
  expect(unitsMissing({ columns: [column("t", false)] })).toEqual({ time: true, length: false });
  expect(unitsMissing(null)).toEqual({ time: true, length: true });
});
