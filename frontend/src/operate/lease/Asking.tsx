import { Button } from "@mantine/core";
import { IconHandGrab } from "@tabler/icons-react";
import { usePage, type Page } from "../../live/page";
import { useService } from "../../ui/services";
import { Operations } from "../operations";

const NO_ONE: Page["people"]["asking"] = [];

/** To the operator: who asks for control, the longest waiting first. */
export function Asking() {
  const operations = useService(Operations);
  const asking = usePage((page) => (page.lease.mine ? page.people.asking : NO_ONE));
  const first = asking.at(0);
  if (!first) return null;
  const { tag, name, role } = first;
  return (
    <div key={tag} className="over-page asking" role="alert" data-testid="asking">
      <IconHandGrab size={18} aria-hidden />
      <span>
        {name}
        {role === "viewer" ? " (viewer)" : ""} asks for control
        {asking.length > 1 ? `, and ${asking.length - 1} more` : ""}. A motion is held first.
      </span>
      <Button size="compact-sm" data-testid="ask-accept" onClick={() => void operations.handOver(tag)}>
        Accept
      </Button>
      <Button
        size="compact-sm"
        variant="default"
        data-testid="ask-refuse"
        onClick={() => void operations.refuseRequest(tag)}
      >
        Refuse
      </Button>
    </div>
  );
}
