import { Button, Loader } from "@mantine/core";
import { useState } from "react";
import { useDashboard, usePage } from "../panels/context";
import { Compare } from "./Compare";
import { Detail } from "./Detail";
import { NEWEST } from "./listing";
import { RecordingList } from "./RecordingList";
import { useRecordings } from "./useRecordings";

/** The recordings: all of them, one, or up to four side by side. */
export default function Review() {
  const { page } = useDashboard();
  const reviewed = usePage((state) => state.reviewed);
  const compared = usePage((state) => state.compared);
  const recordings = useRecordings();
  const [search, setSearch] = useState({ query: "", order: NEWEST, shelf: 1 });
  const [ticked, setTicked] = useState<readonly string[]>([]);
  const back = () => {
    page.patch({ reviewed: null, compared: [] });
  };
  if (recordings.rows === null)
    return recordings.problem === "" ? <Loader m="xl" /> : <Unlisted {...recordings} />;
  if (compared.length > 0) return <Compare ids={compared} rows={recordings.rows} onBack={back} />;
  if (reviewed !== null) return <Detail key={reviewed} id={reviewed} recordings={recordings} onBack={back} />;
  return (
    <RecordingList
      recordings={recordings}
      rows={recordings.rows}
      search={search}
      onSearch={(change) => {
        setSearch({ ...search, ...change });
      }}
      ticked={ticked}
      onTick={setTicked}
    />
  );
}

interface UnlistedProps {
  readonly problem: string;
  readonly load: () => Promise<void>;
}

function Unlisted({ problem, load }: UnlistedProps) {
  return (
    <main className="review">
      <div className="panel" role="alert">
        <p className="advice">The recordings cannot be listed: {problem}</p>
        <Button size="xs" variant="default" w="fit-content" onClick={() => void load()}>
          Try again
        </Button>
      </div>
    </main>
  );
}
