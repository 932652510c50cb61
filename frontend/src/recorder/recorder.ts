import { api, dataOf } from "../api/rest";
import type { Marked, Page } from "../live/page";
import type { Operations } from "../operate/operations";
import type { Store } from "../ui/store";
import { recordings } from "./recordings";

/** Starts and stops recordings of the live rig, and marks places in them. */
export class Recorder {
  constructor(
    private readonly page: Store<Page>,
    private readonly operations: Operations,
  ) {}

  async toggle(): Promise<void> {
    const reason = this.operations.whyNot("record");
    const { recording, recordingName, recordingProfile } = this.page.get();
    if (reason !== null) this.operations.notify("warning", "Recording", reason);
    else if (recording.recording)
      await this.operations.attempt("Recording not stopped", () => api.DELETE("/api/recordings/current"));
    else
      await this.operations.attempt("Recording not started", async () => {
        const body = { name: recordingName, profile: recordingProfile };
        this.page.patch({ recording: await dataOf(api.POST("/api/recordings", { body })) });
        if (this.page.get().recordingName === recordingName) this.page.patch({ recordingName: "" });
      });
  }

  /** Bookmark the newest row; its label may be typed then. */
  async mark(): Promise<void> {
    const reason = this.operations.whyNot("mark");
    if (reason !== null) this.operations.notify("warning", "No bookmark", reason);
    else
      await this.operations.attempt("No bookmark", async () => {
        const { id } = this.page.get().recording;
        this.page.patch({ marked: { ...(await recordings.mark()), recording: id } });
      });
  }

  /** Give the bookmark that was set just now its label, once; "" leaves it without. */
  async label(marked: Marked, text: string): Promise<void> {
    if (this.page.get().marked !== marked) return;
    this.page.patch({ marked: null });
    if (text.trim() === "") return;
    await this.operations.attempt("Bookmark not named", () =>
      recordings.label(marked.recording, marked.n, text.trim()),
    );
  }
}
