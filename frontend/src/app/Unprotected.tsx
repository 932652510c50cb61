import { Tooltip } from "@mantine/core";
import { IconLockOpen } from "@tabler/icons-react";
import { usePage } from "../live/page";

const MEANING =
  "Other machines reach this server without TLS: who is in the network can read and change what is said, tokens included";

/** Marks a server that others can reach unencrypted. */
export function Unprotected() {
  const unprotected = usePage((page) => page.me.unprotected);
  if (!unprotected) return null;
  return (
    <Tooltip label={MEANING} multiline maw={320}>
      <span className="unprotected" data-testid="unprotected" role="img" aria-label={MEANING}>
        <IconLockOpen size={15} aria-hidden /> no TLS
      </span>
    </Tooltip>
  );
}
