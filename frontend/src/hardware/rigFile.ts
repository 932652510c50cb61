import { api, dataOf } from "../api/rest";
import type { components } from "../api/schema";
import { keep } from "../live/page";
import { textOf } from "../ui/format";
import { Store } from "../ui/store";
import { problemOf, type Problem } from "./problem";

export type RigFileState = components["schemas"]["RigFileState"];

interface Editing {
  /** As it is on the server's disk; null before it was read. */
  readonly disk: RigFileState | null;
  /** What the disk had when the editing began; null while nothing is changed. */
  readonly base: string | null;
  readonly draft: string;
  readonly problem: Problem | null;
  readonly saving: boolean;
  /** How the last start with another file failed, "" if it did not. */
  readonly failure: string;
}

/** The rig file and what is being changed in it; a draft outlives the panel. */
export class RigFileEditor {
  readonly store = new Store<Editing>({
    disk: null,
    base: null,
    draft: "",
    problem: null,
    saving: false,
    failure: "",
  });

  /** Read what lies on the disk, and what came of the last start with it; a draft stays. */
  async learn(): Promise<void> {
    const [disk, { failure }] = await Promise.all([
      dataOf(api.GET("/api/rig-file")),
      dataOf(api.GET("/api/rig/actuator")),
    ]);
    const before = this.store.get();
    this.store.patch({ disk: keep(before.disk, disk), failure });
    if (before.base === null || before.draft === disk.text)
      this.store.patch({ base: null, draft: disk.text });
  }

  type(draft: string): void {
    const { base, disk } = this.store.get();
    const kept = disk?.text ?? "";
    this.store.patch({ draft, base: draft === kept ? null : (base ?? kept), problem: null });
  }

  /** What lies on the disk again. */
  revert(): void {
    this.store.patch({ draft: this.store.get().disk?.text ?? "", base: null, problem: null });
  }

  /** Have the server check and write it, and start the rig with it; what is wrong with it is shown beside it. */
  async save(): Promise<void> {
    const { draft } = this.store.get();
    this.store.patch({ saving: true, problem: null });
    try {
      await api.PUT("/api/rig-file", { body: { text: draft } });
      if (this.store.get().draft === draft) this.store.patch({ base: null }); // else someone typed on meanwhile
      await this.learn();
    } catch (error) {
      this.store.patch({ problem: problemOf(textOf(error), draft) });
    } finally {
      this.store.patch({ saving: false });
    }
  }
}

/** How the file stands to what runs, in a few words. */
export function standing({ disk, base, draft }: Pick<Editing, "disk" | "base" | "draft">): string {
  if (disk === null) return "";
  if (base !== null && base !== disk.text) return "Changed here, and meanwhile on the disk, too";
  if (draft !== disk.text) return "Changed here, not saved";
  return disk.in_force ? "In force: the rig runs with it" : "Differs from what the rig runs with";
}
