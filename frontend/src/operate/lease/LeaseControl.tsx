import { ActionIcon, Button, Group, Menu, Modal } from "@mantine/core";
import { IconArrowsExchange, IconHandOff } from "@tabler/icons-react";
import { useState } from "react";
import { isOperatorHere, operatorText, usePage, type Page } from "../../live/page";
import { useService } from "../../ui/services";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import type { Person } from "../../api/types";
import { useWhyNot } from "../permission";
import { Me } from "./Me";

/** Who operates, and the way to ask for it, give it back or pass it on; it is taken by the primary action. */
export function LeaseControl() {
  const operations = useService(Operations);
  const lease = usePage((page) => page.lease);
  const whose = usePage(holderText);
  const meaning = usePage((page) =>
    page.lease.held && !page.lease.mine ? operatorText(page) : holderText(page),
  );
  return (
    <span className="lease" data-testid="lease" data-mine={lease.mine} data-held={lease.held}>
      <Me />
      <span className="lease-holder" title={meaning}>
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
          <IconHandOff className="icon-for-word" size={16} aria-hidden />
          <span className="word-or-icon">Release</span>
        </ControlButton>
      ) : null}
      {lease.held ? <LeaseMenu /> : null}
    </span>
  );
}

function holderText({ lease, people }: Page): string {
  if (lease.mine) return "you operate";
  if (!lease.held) return "no operator";
  if (!isOperatorHere({ lease, people })) return `${lease.holder}: page closed`;
  return people.waiting ? `asked ${lease.holder}` : lease.holder;
}

/** How the lease passes on: the holder hands it over; others ask for it, operators may also take it. */
function LeaseMenu() {
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
      <TakeOver from={taking} onClose={() => setTaking(null)} />
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
        onClick={() => onTake({ tag, name, role: "operator" })}
      >
        Take over ...
        {take === null ? null : <span className="note profile-meaning">{take}</span>}
      </Menu.Item>
    </>
  );
}

interface TakeOverProps {
  /** Whose control is to be taken; null: no one's. */
  readonly from: Person | null;
  readonly onClose: () => void;
}

/** Asks before control is taken from someone; the page stays in sight, as the rig goes on. */
function TakeOver({ from, onClose }: TakeOverProps) {
  const operations = useService(Operations);
  return (
    <Modal
      opened={from !== null}
      onClose={onClose}
      title={`Take control from ${from?.name ?? ""}?`}
      size="sm"
      centered
      withOverlay={false}
      lockScroll={false}
      closeButtonProps={{ "aria-label": "Leave control where it is" }}
    >
      <p className="note">
        The motion is held first. {from?.name} is told that you operate now, and it stands in the log.
      </p>
      <Group justify="flex-end" mt="md">
        <Button size="xs" variant="default" onClick={onClose}>
          Cancel
        </Button>
        <Button
          size="xs"
          color="red"
          data-testid="take-over-confirm"
          onClick={() => {
            if (from) void operations.takeOver(from.tag);
            onClose();
          }}
        >
          Take over
        </Button>
      </Group>
    </Modal>
  );
}
