import { Badge, Tooltip } from "@mantine/core";
import { IconUser } from "@tabler/icons-react";
import { usePage, type Page } from "../../live/page";
import { useService } from "../../ui/services";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import { LeaseMenu } from "./LeaseMenu";

/** Who operates, and the way to ask for it, give it back or pass it on; it is taken by the primary action. */
export function LeaseControl() {
  const operations = useService(Operations);
  const lease = usePage((page) => page.lease);
  const whose = usePage(holderText);
  return (
    <span className="lease" data-testid="lease" data-mine={lease.mine} data-held={lease.held}>
      <Me />
      <span className="lease-holder" title={whose}>
        {whose}
      </span>
      {lease.mine ? (
        <ControlButton
          control="release"
          variant="subtle"
          color="gray"
          testId="lease-release"
          meaning="Give control back; a motion is held"
          onClick={() => void operations.releaseLease()}
        >
          Release
        </ControlButton>
      ) : null}
      {lease.held ? <LeaseMenu /> : null}
    </span>
  );
}

function holderText({ lease, people }: Page): string {
  if (lease.mine) return "you operate";
  if (!lease.held) return "no operator";
  return people.waiting ? `asked ${lease.holder}` : lease.holder;
}

/** My own name and role; a viewer's is always in sight, because so much is off. */
function Me() {
  const me = usePage((page) => page.me);
  const meaning = `You are ${me.name}, signed in with the ${me.role}'s token`;
  return (
    <Tooltip label={meaning}>
      <span className="lease-me" data-testid="me" data-role={me.role} aria-label={meaning} role="img">
        <IconUser size={15} aria-hidden />
        {me.role === "viewer" ? (
          <Badge size="sm" variant="default" tt="none">
            viewer
          </Badge>
        ) : null}
      </span>
    </Tooltip>
  );
}
