import { Button, Select } from "@mantine/core";
import { useMemo } from "react";
import { usePage } from "../../live/page";
import { Facts } from "../../ui/Facts";
import { useService } from "../../ui/services";
import { SourceChoice } from "../SourceChoice";
import { chosenInfo, References } from "./references";
import { factsOf, menuOf, drawnShape, thumbnailPath } from "./shown";

const [WIDTH, HEIGHT] = [44, 28];
/** Room for the line's own width. */
const MARGIN = 3;

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
        <Thumbnail />
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

/** A small picture of the chosen reference; its place is kept while there is none. */
function Thumbnail() {
  const info = usePage(chosenInfo);
  const reference = usePage((page) => page.reference);
  const path = useMemo(() => {
    const shape = reference ? drawnShape(reference, info?.frequency ?? null) : [];
    return thumbnailPath(shape, WIDTH - 2 * MARGIN, HEIGHT - 2 * MARGIN);
  }, [reference, info]);
  const named =
    path === "" || !info ? { "aria-hidden": true } : { role: "img", "aria-label": `Shape of ${info.title}` };
  return (
    <svg className="thumbnail" width={WIDTH} height={HEIGHT} data-testid="thumbnail" {...named}>
      <path d={path} transform={`translate(${MARGIN} ${MARGIN})`} />
    </svg>
  );
}
