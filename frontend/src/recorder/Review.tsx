import { Button, Loader } from "@mantine/core";
import { useState } from "react";
import { PageStore, usePage } from "../live/page";
import { useService } from "../ui/services";
import { Compare } from "./compare/Compare";
import { Detail } from "./detail/Detail";
import { NEWEST } from "./list/listing";
import { RecordingList, SHELF } from "./list/RecordingList";
import { useRecordings, type Search } from "./useRecordings";

/** The recordings: as a list, one, or up to four side by side. */
export default function Review() {
  const page = useService(PageStore);
  const reviewed = usePage((state) => state.reviewed);
  const compared = usePage((state) => state.compared);
  const [search, setSearch] = useState<Search>({ query: "", order: NEWEST, limit: SHELF });
  const [ticked, setTicked] = useState<readonly string[]>([]);
  const opened = compared.length > 0 ? compared : reviewed === null ? [] : [reviewed];
  const recordings = useRecordings(search, opened);
  const back = () => {
    page.patch({ reviewed: null, compared: [] });
  };
  const known = opened.map(recordings.find);
  const waits = opened.length > 0 ? known.includes(undefined) : recordings.listed === null;
  if (waits) return recordings.problem === "" ? <Loader m="xl" /> : <Unread {...recordings} />;
  if (compared.length > 0) return <Compare ids={compared} recordings={recordings} onBack={back} />;
  if (reviewed !== null) return <Detail key={reviewed} id={reviewed} recordings={recordings} onBack={back} />;
  return (
    <RecordingList
      recordings={recordings}
      search={search}
      onSearch={(change) => {
        setSearch({ ...search, ...change });
      }}
      ticked={ticked.filter((id) => recordings.find(id) !== null)}
      onTick={setTicked}
    />
  );
}

interface UnreadProps {
  readonly problem: string;
  readonly load: () => Promise<void>;
}

function Unread({ problem, load }: UnreadProps) {
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
