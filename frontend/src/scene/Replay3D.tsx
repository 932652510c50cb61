import { ActionIcon, NativeSelect, Slider, Tooltip } from "@mantine/core";
import { IconPlayerPauseFilled, IconPlayerPlayFilled } from "@tabler/icons-react";
import { useEffect, useState } from "react";
import type { Recording } from "../api/types";
import { Operations } from "../operate/operations";
import { plain } from "../ui/format";
import { useService } from "../ui/services";
import { Store, useStore } from "../ui/store";
import { Ticker } from "../ui/ticker";
import { Cameras } from "./Scene3D";
import { SceneFrame } from "./SceneFrame";
import { ViewSession } from "./viewSession";
import { scene, type Playback, type PlaybackBody } from "./scene";

const RATES = ["0.1", "0.25", "0.5", "1", "2", "5"] as const;
const SHOWN_PER_S = 10;

/** A recording in 3D, in this page alone: the live view and everyone else's stay as they are. */
export function Replay3D({ recording }: { readonly recording: Recording }) {
  const operations = useService(Operations);
  const [viewSession] = useState(() => new ViewSession());
  const [replay] = useState(() => new Replay(recording.id, viewSession.id));
  const marks = recording.bookmarks.map(({ t }) => ({ value: t }));
  const steer = (action: () => Promise<void>) => void operations.attempt("Recording not played", action);
  return (
    <>
      <PlayBar replay={replay} steer={steer} viewSession={viewSession} marks={marks} />
      <SceneFrame
        viewSession={viewSession}
        title={`3D view of the recording ${recording.name || recording.id}`}
        onReady={() => steer(() => replay.steer({ playing: true }))}
      />
    </>
  );
}

interface PlayBarProps {
  readonly replay: Replay;
  readonly viewSession: ViewSession;
  /** Bookmarks, in seconds. */
  readonly marks: { value: number }[];
  readonly steer: (action: () => Promise<void>) => void;
}

function PlayBar({ replay, viewSession, marks, steer }: PlayBarProps) {
  const playback = useStore(replay.store, (state) => state.playback);
  const [at, playing] = useClock(replay);
  const [wish, setWish] = useState<number | null>(null);
  const duration = playback?.duration ?? 0;
  return (
    <div className="bar replay" aria-busy={playback === null}>
      <Tooltip label={playing ? "Pause" : "Play"}>
        <ActionIcon
          variant="default"
          aria-label={playing ? "Pause" : "Play"}
          data-testid="replay-toggle"
          disabled={playback === null}
          onClick={() => steer(() => replay.toggle())}
        >
          {playing ? <IconPlayerPauseFilled size={16} /> : <IconPlayerPlayFilled size={16} />}
        </ActionIcon>
      </Tooltip>
      <Slider
        className="replay-time"
        size="sm"
        thumbLabel="Time in the recording"
        label={(value) => `${plain(value, 2)} s`}
        disabled={playback === null}
        min={0}
        max={Math.max(duration, 0.01)}
        step={0.01}
        marks={marks}
        value={wish ?? at}
        onChange={setWish}
        onChangeEnd={(value) => {
          setWish(null);
          steer(() => replay.steer({ at: value }));
        }}
      />
      <span className="number replay-clock" data-testid="replay-at">
        {plain(wish ?? at, 1)} / {plain(duration, 1)} s
      </span>
      <NativeSelect
        size="xs"
        aria-label="Speed of playback"
        value={String(playback?.rate ?? 1)}
        data={RATES.map((rate) => ({ value: rate, label: `${rate} ×` }))}
        onChange={(event) => {
          const rate = Number(event.currentTarget.value);
          steer(() => replay.steer({ rate }));
        }}
      />
      <Cameras viewSession={viewSession} />
    </div>
  );
}

/** Time in the recording [s] and whether it plays, followed at human speed. */
function useClock(replay: Replay): readonly [number, boolean] {
  const ticker = useService(Ticker);
  const [shown, setShown] = useState<readonly [number, boolean]>([0, false]);
  useEffect(
    () =>
      ticker.every(SHOWN_PER_S, "playback", () => {
        const next = [replay.at(), replay.isPlaying()] as const;
        setShown((old) => (old[0] === next[0] && old[1] === next[1] ? old : next));
      }),
    [ticker, replay],
  );
  return shown;
}

/** The recording as the server plays it, and when it said so [ms on the page's clock]. */
interface ReplayState {
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
function timeIn({ at, playing, rate, duration }: Playback, since: number): number {
  return playing ? Math.min(duration, at + since * rate) : at;
}
