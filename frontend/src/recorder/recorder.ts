import { api, told } from "../api/rest";
import type { Page } from "../live/page";
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
        this.page.patch({ recording: await told(api.POST("/api/recordings", { body })) });
        if (this.page.get().recordingName === recordingName) this.page.patch({ recordingName: "" });
      });
  }

  /** Bookmark the newest row; its label may be typed then. */
  async mark(): Promise<void> {
    const reason = this.operations.whyNot("mark");
    if (reason !== null) this.operations.notify("warning", "No bookmark", reason);
    else
      await this.operations.attempt("No bookmark", async () => {
        this.page.patch({ marked: await recordings.mark() });
      });
  }

  /** Give the bookmark that was set just now its label; "" leaves it without. */
  async label(text: string): Promise<void> {
    const { marked, recording } = this.page.get();
    this.page.patch({ marked: null });
    if (marked === null || text.trim() === "") return;
    await this.operations.attempt("Bookmark not named", () =>
      recordings.label(recording.id, marked.n, text.trim()),
    );
  }
}
