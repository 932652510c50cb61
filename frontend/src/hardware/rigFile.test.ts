import { expect, test, vi } from "vitest";
import { api } from "../api/rest";
import { RigFileEditor, standing, type RigFileState } from "./rigFile";

const disk: RigFileState = {
  path: "/lab/rig.toml",
  text: "a = 1\n",
  rig: null,
  reason: "",
  in_force: true,
  withdrawn: {},
};

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

test("what is typed while the file is being saved is not lost", async () => {
  let text = disk.text;
  const got = vi
    .spyOn(api, "GET")
    .mockImplementation(((path: string) =>
      Promise.resolve({ data: path === "/api/rig-file" ? { ...disk, text } : { failure: "" } })) as never);
  const editor = new RigFileEditor();
  const put = vi.spyOn(api, "PUT").mockImplementation(((_: string, { body }: { body: { text: string } }) => {
    editor.type("a = 3\n");
    text = body.text;
    return Promise.resolve({});
  }) as never);
  await editor.learn();
  editor.type("a = 2\n");
  await editor.save();
  expect(editor.store.get().draft).toBe("a = 3\n");
  expect(standing(editor.store.get())).not.toMatch(/^In force/);
  for (const spy of [got, put]) spy.mockRestore();
});
