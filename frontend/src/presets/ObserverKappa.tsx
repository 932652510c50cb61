import { useState } from "react";
import { usePage } from "../live/page";
import { ControlButton } from "../operate/ControlButton";
import { Operations } from "../operate/operations";
import { MODE } from "../rig/modes";
import { plain } from "../ui/format";
import { useService } from "../ui/services";
import { AskActuator } from "./AskActuator";
import { kappaToOffer, type FirstModeInForce } from "./firstMode";
import { presets } from "./presets";

/** Lets the observer's body move as fast as the arm was measured to, or by its table again; asks first. */
export function ObserverKappa({ known }: { readonly known: FirstModeInForce }) {
  const operations = useService(Operations);
  const because = useWhyNot();
  const [asked, setAsked] = useState(false);
  const kappa = kappaToOffer(known);
  if (kappa === null) return null;
  const word = kappa === 1 ? "the table's inertia" : `κ ${plain(kappa, 1)}`;
  return (
    <div className="row">
      <ControlButton
        control="settings"
        because={because}
        variant="default"
        testId="observer-kappa"
        meaning={`Start the rig again with ${word} in its observer`}
        onClick={() => {
          setAsked(true);
        }}
      >
        {kappa === 1 ? "Table's κ in the observer" : "Measured κ in the observer"}
      </ControlButton>
      <AskActuator
        wanted={asked ? `${word} in its observer` : null}
        onClose={() => {
          setAsked(false);
        }}
        onYes={() => {
          setAsked(false);
          void operations.attempt("Observer not changed", () => presets.observerKappa(kappa));
        }}
      />
    </div>
  );
}

/** Why the rig cannot be started again now, null where it can. */
function useWhyNot(): string | null {
  const starting = usePage((page) => page.starting);
  const rigLive = usePage((page) => page.rigLive);
  const vented = usePage((page) => page.mode === MODE.VENTED);
  if (starting !== "") return `The rig starts with ${starting}; it comes back vented`;
  if (!rigLive) return "There is no rig";
  return vented ? null : "Disarm first: the rig starts again";
}
