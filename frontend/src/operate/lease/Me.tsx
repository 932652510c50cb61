import { Badge, Button, Group, Menu, Modal, UnstyledButton } from "@mantine/core";
import { IconUser } from "@tabler/icons-react";
import { useState } from "react";
import type { Role } from "../../api/types";
import { Connection } from "../../live/connection";
import { usePage } from "../../live/page";
import { useService } from "../../ui/services";
import { Operations } from "../operations";

const ROLES: readonly Role[] = ["viewer", "operator"];

/** My own name and role, and the way out; a viewer's role is always in sight, because so much is off. */
export function Me() {
  const me = usePage((page) => page.me);
  const [ending, setEnding] = useState<Role | null>(null);
  const meaning = `You are ${me.name}, signed in with the ${me.role}'s token`;
  return (
    <>
      <Menu position="bottom-end" shadow="md" width={260}>
        <Menu.Target>
          <UnstyledButton
            className="lease-me"
            data-testid="me"
            data-role={me.role}
            aria-label={meaning}
            title={meaning}
          >
            <IconUser size={15} aria-hidden />
            {me.role === "viewer" ? (
              <Badge size="sm" variant="default" tt="none">
                viewer
              </Badge>
            ) : null}
          </UnstyledButton>
        </Menu.Target>
        <Menu.Dropdown>
          <Menu.Label>{meaning}</Menu.Label>
          <SignOut />
          {me.role === "operator" ? <SignOthersOut onChoose={setEnding} /> : null}
        </Menu.Dropdown>
      </Menu>
      <SignAllOut role={ending} onClose={() => setEnding(null)} />
    </>
  );
}

function SignOut() {
  const connection = useService(Connection);
  const operations = useService(Operations);
  const mine = usePage((page) => page.lease.mine);
  return (
    <Menu.Item
      data-testid="sign-out"
      onClick={() => void operations.attempt("Not signed out", () => connection.logout())}
    >
      {mine ? "Sign out, and give control back" : "Sign out"}
    </Menu.Item>
  );
}

function SignOthersOut({ onChoose }: { readonly onChoose: (role: Role) => void }) {
  return (
    <>
      <Menu.Divider />
      <Menu.Label>Sign out all who came with</Menu.Label>
      {ROLES.map((role) => (
        <Menu.Item key={role} data-testid={`sign-out-${role}`} onClick={() => onChoose(role)}>
          the {role}'s token ...
        </Menu.Item>
      ))}
    </>
  );
}

interface SignAllOutProps {
  /** Whose token opened the sessions that are to end; null: no one's. */
  readonly role: Role | null;
  readonly onClose: () => void;
}

/** Asks before others are signed out; the page stays in sight, as the rig goes on. */
function SignAllOut({ role, onClose }: SignAllOutProps) {
  const connection = useService(Connection);
  const operations = useService(Operations);
  return (
    <Modal
      opened={role !== null}
      onClose={onClose}
      title={`Sign out all who came with the ${role ?? ""}'s token?`}
      size="sm"
      centered
      withOverlay={false}
      lockScroll={false}
      closeButtonProps={{ "aria-label": "Sign out no one" }}
    >
      <p className="note">
        {role === "operator" ? "You too. Who operates gives control back, and a motion is held. " : ""}
        The token stays good: `tendril token new` makes another.
      </p>
      <Group justify="flex-end" mt="md">
        <Button size="xs" variant="default" onClick={onClose}>
          Cancel
        </Button>
        <Button
          size="xs"
          color="red"
          data-testid="sign-out-confirm"
          onClick={() => {
            if (role) void operations.attempt("No one signed out", () => connection.logoutAll(role));
            onClose();
          }}
        >
          Sign out
        </Button>
      </Group>
    </Modal>
  );
}
