import { api, told } from "../api/rest";
import type { Page } from "../live/page";
import type { Operations } from "../operate/operations";
import type { Store } from "../ui/store";

/** Starts and stops recordings of the live rig. */
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
}
