import { expect, test } from "vitest";
import type { ControllerInfo } from "../../api/types";
import { numbersOf } from "./controllers";

const about = { symbol: "K", unit: "1", low: 0, high: 2, about: "" };
const PREVIEW: ControllerInfo = {
  name: "preview",
  title: "",
  citation: "",
  plans: true,
  own_gains: true,
  tuning: [
    { name: "K_P", usual: 0.3, ...about },
    { name: "lag", usual: 0.1, ...about },
  ],
  signals: [],
  refused: "",
};

test("a controller's numbers are found by the place that its definition gives them", () => {
  expect(numbersOf(PREVIEW, [0.5, 0.2, 0, 0])).toEqual({ K_P: 0.5, lag: 0.2 });
  expect(numbersOf(PREVIEW, [])).toEqual({ K_P: 0.3, lag: 0.1 });
});
