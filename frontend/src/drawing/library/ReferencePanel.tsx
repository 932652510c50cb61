import { Button, Select } from "@mantine/core";
import { useMemo } from "react";
import { usePage } from "../../live/page";
import { Facts } from "../../ui/Facts";
import { useService } from "../../ui/services";
import { SourceChoice } from "../SourceChoice";
import { chosenInfo, References } from "./references";
import { ReferenceThumbnail } from "./ReferenceThumbnail";
import { factsOf, menuOf } from "./shown";

/** Choose a reference by task or by typing; it is drawn on the plan, and nothing moves. */
export function ReferencePanel() {
  const references = useService(References);
  const known = usePage((page) => page.references);
  const chosen = usePage((page) => page.chosen);
  const menu = useMemo(() => menuOf(known), [known]);
  return (
    <>
      <div className="row run-row">
        <SourceChoice />
        <ReferenceThumbnail />
        <Select
          size="xs"
          w={230}
          aria-label="Reference shown on the plan"
          placeholder={known.length === 0 ? "Waiting for the rig" : "None: choose or type"}
          data-testid="reference"
          data={menu}
          value={chosen}
          searchable
          nothingFoundMessage="No reference of this name"
          maxDropdownHeight={260}
          onChange={(name) => void references.choose(name)}
        />
        <Button
          size="xs"
          variant="default"
          disabled={chosen === null}
          data-testid="reference-clear"
          onClick={() => void references.choose(null)}
        >
          Clear
        </Button>
      </div>
      <Known />
    </>
  );
}

function Known() {
  const info = usePage(chosenInfo);
  if (!info)
    return <p className="note">The paper's shapes, placed for this actuator, and a recorded live path.</p>;
  return (
    <>
      <Facts facts={factsOf(info)} testId="reference-facts" />
      {info.reachable ? null : (
        <p className="out-of-reach" role="status" data-testid="reference-reason">
          ⚠ This actuator cannot follow it: {info.reason}
        </p>
      )}
    </>
  );
}
