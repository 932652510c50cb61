import { Button, Menu } from "@mantine/core";
import { IconDownload } from "@tabler/icons-react";
import { EXPORTS, recordingUrl } from "../api/recordings";
import type { Recording } from "../api/types";

/** The whole recording as a file of another program. */
export function ExportMenu({ recording }: { readonly recording: Recording }) {
  return (
    <Menu position="bottom-end" shadow="md">
      <Menu.Target>
        <Button
          size="compact-sm"
          variant="default"
          leftSection={<IconDownload size={14} />}
          data-testid="export"
        >
          Export
        </Button>
      </Menu.Target>
      <Menu.Dropdown aria-label="Export as">
        {EXPORTS.map(([format, label]) => (
          <Menu.Item
            key={format}
            component="a"
            href={recordingUrl(recording.id, `/export?format=${format}`)}
            download
          >
            {label}
          </Menu.Item>
        ))}
        <Menu.Item component="a" href={recordingUrl(recording.id, ".rrd")} download>
          rerun .rrd
        </Menu.Item>
      </Menu.Dropdown>
    </Menu>
  );
}
