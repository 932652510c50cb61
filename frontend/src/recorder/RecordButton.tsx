import { Button, Menu } from "@mantine/core";
import {
  IconAlertTriangle,
  IconChevronDown,
  IconPlayerRecordFilled,
  IconPlayerStopFilled,
} from "@tabler/icons-react";
import { useState } from "react";
import type { ProfileInfo } from "../api/types";
import { PageStore, usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Operations } from "../operate/operations";
import { bytes, clock } from "../ui/format";
import { useService } from "../ui/services";
import { isProfile } from "./profile";
import { Recorder } from "./recorder";
import { MarkButton } from "./MarkButton";
import { recordings } from "./recordings";

/** Starts and stops a recording, with a sign where something is wrong; beside it, how much of every tick it keeps. */
export function RecordButton() {
  const recorder = useService(Recorder);
  const recording = usePage((page) => page.recording.recording);
  const isNaming = usePage((page) => page.marked !== null);
  const time = usePage((page) => clock(page.recording.seconds));
  const gaps = usePage((page) => page.recording.gaps);
  const problem = usePage((page) => page.recording.problem);
  const profile = usePage((page) => page.recordingProfile);
  const does = recording ? `Stop recording (R); ${gaps} ticks missing` : `Record every tick (R), ${profile}`;
  return (
    <Button.Group>
      <ControlButton
        control="record"
        variant="default"
        className={recording ? "recording" : ""}
        testId="record"
        meaning={problem === "" ? does : `${does}; ${problem}`}
        leftSection={
          recording ? (
            <IconPlayerStopFilled size={14} />
          ) : (
            <IconPlayerRecordFilled size={14} color="var(--mantine-color-red-8)" />
          )
        }
        rightSection={
          problem === "" ? null : <IconAlertTriangle size={14} color="var(--mantine-color-orange-8)" />
        }
        onClick={() => void recorder.toggle()}
      >
        <span className="number record-label">
          {recording ? `REC ${time}` : profile === "full" ? "Record full" : "Record"}
        </span>
      </ControlButton>
      {recording || isNaming ? <MarkButton /> : <ProfileMenu />}
    </Button.Group>
  );
}

/** What the next recording keeps, each with its size. */
function ProfileMenu() {
  const operations = useService(Operations);
  const page = useService(PageStore);
  const profile = usePage((state) => state.recordingProfile);
  const [profiles, setProfiles] = useState<readonly ProfileInfo[]>([]);
  const learn = () =>
    operations.attempt("Profiles not known", async () => {
      setProfiles(await recordings.profiles());
    });
  return (
    <Menu position="bottom-end" shadow="md" width={340} onOpen={() => void learn()}>
      <Menu.Target>
        <Button
          size="xs"
          variant="default"
          px={4}
          aria-label={`What a recording keeps: ${profile}`}
          data-testid="record-profile"
        >
          <IconChevronDown size={14} />
        </Button>
      </Menu.Target>
      <Menu.Dropdown aria-label="What a recording keeps">
        <Menu.RadioGroup
          value={profile}
          onChange={(value) => {
            if (isProfile(value)) page.patch({ recordingProfile: value });
          }}
        >
          {profiles.map(({ name, meaning, megabytes_per_hour }) => (
            <Menu.RadioItem key={name} value={name} data-testid={`profile-${name}`}>
              <b>{name}</b> <span className="number">{bytes(megabytes_per_hour * 1e6)}/h</span>
              <span className="note profile-meaning">{meaning}</span>
            </Menu.RadioItem>
          ))}
        </Menu.RadioGroup>
      </Menu.Dropdown>
    </Menu>
  );
}
