import { SegmentedControl } from "@mantine/core";
import { Lacking } from "../hardware/commissioning/CommissioningBar";
import { CommissioningPanel } from "../hardware/commissioning/CommissioningPanel";
import { lackingText } from "../hardware/commissioning/steps";
import { useCommissioningState } from "../hardware/commissioning/useCommissioning";
import { DriversPanel } from "../hardware/DriversPanel";
import { RigFilePanel } from "../hardware/RigFilePanel";
import { PageStore, usePage, type Page } from "../live/page";
import { useService } from "../ui/services";

const SECTIONS: readonly { readonly value: Page["rigSection"]; readonly label: string }[] = [
  { value: "drivers", label: "Drivers" },
  { value: "file", label: "Rig file" },
  { value: "commissioning", label: "Commissioning" },
];

/** A rig of real devices: how they fare, the file that describes it, and its commissioning. */
export function RigPanel() {
  const page = useService(PageStore);
  const section = usePage((state) => state.rigSection);
  const state = useCommissioningState();
  return (
    <div className="panel rig-panel">
      <SegmentedControl
        size="xs"
        aria-label="Part of the rig"
        data-testid="rig-section"
        value={section}
        data={SECTIONS.map(({ value, label }) => ({ value, label }))}
        onChange={(value) => {
          page.patch({ rigSection: value });
        }}
      />
      {section === "drivers" && state !== null ? <Lacking text={lackingText(state)} /> : null}
      {section === "drivers" ? <DriversPanel /> : null}
      {section === "file" ? <RigFilePanel /> : null}
      {section === "commissioning" ? <CommissioningPanel /> : null}
    </div>
  );
}
