import { Button, Menu } from "@mantine/core";
import { IconChevronDown, IconPlayerRecordFilled, IconPlayerStopFilled } from "@tabler/icons-react";
import { useState } from "react";
import { recordings } from "./recordings";
import type { ProfileInfo } from "../api/types";
import { bytes, clock } from "../ui/format";
import { isProfile } from "./profile";
import { ControlButton } from "../operate/ControlButton";
import { useDashboard, usePage } from "../ui/context";

/** Starts and stops a recording; beside it, how much of every tick it is to keep. */
export function RecordButton() {
  const { operations } = useDashboard();
  const recording = usePage((page) => page.recording.recording);
  const time = usePage((page) => clock(page.recording.seconds));
  const gaps = usePage((page) => page.recording.gaps);
  const profile = usePage((page) => page.recordingProfile);
  return (
    <Button.Group>
      <ControlButton
        control="record"
        variant="default"
        className={recording ? "recording" : ""}
        testId="record"
        meaning={
          recording ? `Stop recording (R); ${gaps} ticks missing` : `Record every tick (R), ${profile}`
        }
        leftSection={
          recording ? (
            <IconPlayerStopFilled size={14} />
          ) : (
            <IconPlayerRecordFilled size={14} color="#e03131" />
          )
        }
        onClick={() => void operations.toggleRecording()}
      >
        <span className="number record-label">
          {recording ? `REC ${time}` : profile === "full" ? "Record full" : "Record"}
        </span>
      </ControlButton>
      {recording ? null : <ProfileMenu />}
    </Button.Group>
  );
}

/** What the next recording keeps, each with its size. */
function ProfileMenu() {
  const { operations, page } = useDashboard();
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
