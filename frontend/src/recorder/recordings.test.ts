import { expect, test } from "vitest";
import { recordingUrl, viewerUrl } from "./recordings";

test("rerun's viewer gets an absolute address that ends in .rrd", () => {
  const url = viewerUrl(`http://rig:8000${recordingUrl("2026-01-01 a", ".rrd")}`, "dark", "webgl");
  const query = new URL(url, "http://rig:8000").searchParams;
  expect(query.get("url")).toBe("http://rig:8000/api/recordings/2026-01-01%20a.rrd");
  expect(query.get("renderer")).toBe("webgl");
  expect(viewerUrl("a", "light", null)).not.toContain("renderer");
});
