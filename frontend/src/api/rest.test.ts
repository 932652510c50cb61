import { expect, test } from "vitest";
import { refusalText, viewerUrl } from "./rest";

test("a refusal reads as the server's own sentence, whatever its shape", () => {
  expect(refusalText({ detail: "ivy operates now" }, "Conflict")).toBe("ivy operates now");
  const reply = { n: 4, accepted: false, mode: 0, cause: 13, detail: "HOLD is not possible in VENTED" };
  expect(refusalText(reply, "Conflict")).toBe("HOLD is not possible in VENTED");
  expect(refusalText(null, "Bad Gateway")).toBe("Bad Gateway");
});

test("a malformed body reads as field, reason and value", () => {
  const detail = [
    { loc: ["body", "changes", "K_P", 0], msg: "Input should be less than or equal to 5", input: 12 },
  ];
  expect(refusalText({ detail }, "")).toBe("K_P.0: Input should be less than or equal to 5 (got 12)");
});

test("rerun's viewer gets an absolute address that ends in .rrd", () => {
  const url = viewerUrl("http://rig:8000", "2026-01-01 a", "dark", "webgl");
  const query = new URL(url, "http://rig:8000").searchParams;
  expect(query.get("url")).toBe("http://rig:8000/api/recordings/2026-01-01%20a.rrd");
  expect(query.get("renderer")).toBe("webgl");
  expect(viewerUrl("http://rig", "a", "light", null)).not.toContain("renderer");
});
