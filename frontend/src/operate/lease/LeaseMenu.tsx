import { ActionIcon, Menu } from "@mantine/core";
import { IconArrowsExchange } from "@tabler/icons-react";
import { useState } from "react";
import type { Person } from "../../api/types";
import { usePage } from "../../live/page";
import { useService } from "../../ui/services";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { TakeOver } from "./TakeOver";

/** How the lease passes on: the holder hands it over; others ask for it, operators may also take it. */
export function LeaseMenu() {
  const mine = usePage((page) => page.lease.mine);
  const [taking, setTaking] = useState<Person | null>(null);
  return (
    <>
      <Menu position="bottom-end" shadow="md" width={260}>
        <Menu.Target>
          <ActionIcon
            variant="default"
            size={30}
            aria-label={mine ? "Hand control over" : "Ask for control, or take it over"}
            data-testid="lease-menu"
          >
            <IconArrowsExchange size={16} aria-hidden />
          </ActionIcon>
        </Menu.Target>
        <Menu.Dropdown>{mine ? <HandOver /> : <Get onTake={setTaking} />}</Menu.Dropdown>
      </Menu>
      <TakeOver
        from={taking}
        onClose={() => {
          setTaking(null);
        }}
      />
    </>
  );
}

function HandOver() {
  const operations = useService(Operations);
  const others = usePage((page) => page.people.others);
  return (
    <>
      <Menu.Label>Hand control over to</Menu.Label>
      {others.length === 0 ? <Menu.Item disabled>No one else has the page open</Menu.Item> : null}
      {others.map(({ tag, name, role }) => (
        <Menu.Item key={tag} data-testid="hand-over" onClick={() => void operations.handOver(tag)}>
          {name}
          {role === "viewer" ? " (viewer)" : ""}
        </Menu.Item>
      ))}
    </>
  );
}

function Get({ onTake }: { readonly onTake: (from: Person) => void }) {
  const operations = useService(Operations);
  const waiting = usePage((page) => page.people.waiting);
  const tag = usePage((page) => page.people.holder);
  const name = usePage((page) => page.lease.holder);
  const ask = useWhyNot("ask");
  const take = useWhyNot("take_over");
  return (
    <>
      <Menu.Item
        disabled={ask !== null}
        title={ask ?? undefined}
        data-testid="lease-ask"
        onClick={() => void operations.askForLease(!waiting)}
      >
        {waiting ? "Ask no longer" : `Ask ${name} for control`}
      </Menu.Item>
      <Menu.Item
        disabled={take !== null}
        title={take ?? undefined}
        data-testid="lease-take-over"
        onClick={() => {
          onTake({ tag, name, role: "operator" });
        }}
      >
        Take over ...
        {take === null ? null : <span className="note profile-meaning">{take}</span>}
      </Menu.Item>
    </>
  );
}
