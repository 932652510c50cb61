import { expect, test } from "vitest";
import { standing, type RigFileState } from "./rigFile";

const disk: RigFileState = { path: "/lab/rig.toml", text: "a = 1\n", rig: null, reason: "", in_force: true };

test("it is said whether the file is in force, differs from what runs, or is changed here", () => {
  expect(standing({ disk, base: null, draft: disk.text })).toMatch(/^In force/);
  expect(standing({ disk: { ...disk, in_force: false }, base: null, draft: disk.text })).toMatch(/^Differs/);
  expect(standing({ disk, base: disk.text, draft: "a = 2\n" })).toBe("Changed here, not saved");
});

test("a file that changed on the disk under a draft is told of", () => {
  expect(standing({ disk: { ...disk, text: "a = 3\n" }, base: disk.text, draft: "a = 2\n" })).toMatch(
    /meanwhile/,
  );
});
