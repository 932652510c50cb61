import { expect, test } from "vitest";
import { refusalText } from "./rest";

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
