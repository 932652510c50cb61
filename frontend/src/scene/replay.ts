import { Store } from "../ui/store";
import { scene, type Playback, type PlaybackBody } from "./scene";

/** The recording as the server plays it, and when it said so [ms on the page's clock]. */
export interface ReplayState {
  readonly playback: Playback | null;
  readonly saidAt: number;
}

/** Steers the playback of one recording on one seat; the server's clock runs it. */
export class Replay {
  readonly store = new Store<ReplayState>({ playback: null, saidAt: 0 });
  private asked = 0;

  constructor(
    private readonly recording: string,
    private readonly seat: string,
    private readonly port: Pick<typeof scene, "play"> = scene,
    private readonly now = () => performance.now(),
  ) {}

  /** Time in the recording [s]. */
  at(): number {
    const { playback, saidAt } = this.store.get();
    return playback ? timeIn(playback, (this.now() - saidAt) / 1e3) : 0;
  }

  /** Play, from the start again once the end is reached; or stand. */
  async toggle(): Promise<void> {
    const { playback } = this.store.get();
    const ended = playback !== null && this.at() >= playback.duration;
    await this.steer({ at: ended ? 0 : this.at(), playing: ended || !this.isPlaying() });
  }

  isPlaying(): boolean {
    const { playback } = this.store.get();
    return playback !== null && playback.playing && this.at() < playback.duration;
  }

  /** Change some of time, playing and rate; what is not given stays. An answer to an older wish is dropped. */
  async steer(change: Partial<Omit<PlaybackBody, "recording">>): Promise<void> {
    const rate = this.store.get().playback?.rate ?? 1;
    const body = { recording: this.recording, at: this.at(), playing: this.isPlaying(), rate, ...change };
    const number = ++this.asked;
    const playback = await this.port.play(this.seat, body);
    if (number === this.asked) this.store.patch({ playback, saidAt: this.now() });
  }
}

/** Time in the recording [s], `since` seconds after the server said `playback`. */
export function timeIn({ at, playing, rate, duration }: Playback, since: number): number {
  return playing ? Math.min(duration, at + since * rate) : at;
}
