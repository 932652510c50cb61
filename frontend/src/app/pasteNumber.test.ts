import { expect, test } from "vitest";
import { pastedNumber } from "./pasteNumber";

test.each([
  ["0,5", "0.5"],
  [" 12.25\n", "12.25"],
  ["-,5", "-.5"],
  ["\u22123", "-3"],
  ["+2e-3", "2e-3"],
])("a pasted %j is the number %s", (text, number) => {
  expect(pastedNumber(text)).toBe(number);
});

test.each(["", "1.234,5", "1,234,567", "0,5 mm", "five", "1 2"])("a pasted %j is not one number", (text) => {
  expect(pastedNumber(text)).toBeNull();
});
