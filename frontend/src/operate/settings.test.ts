import { describe, expect, it } from "vitest";
import type { RigInfo } from "../api/types";
import { boundsText, limits, PAIRS, type Shown, type PairName } from "./settings";

const named = (name: PairName) => PAIRS.find((shown) => shown.name === name) as Shown<PairName>;

describe("bounds of the observer's gains", () => {
  const rig = { observer_gains_max: [500, 2.1] } as unknown as RigInfo;

  it("are those of the settings, or less where the rig takes less", () => {
    expect(limits(named("B_o"), rig)).toEqual({ min: 0, max: 2.1 });
    expect(limits(named("K_o"), rig)).toEqual({ min: 0, max: 500 });
    expect(boundsText(named("B_o"), rig)).toBe("0 … 2.1 N s/m");
  });

  it("do not touch other settings, and are those of the settings before a rig is known", () => {
    expect(limits(named("K_P"), rig)).toEqual(limits(named("K_P")));
    expect(limits(named("B_o"), null).max).toBe(5);
  });
});
