import { useState } from "react";
import { ControlButton } from "../ControlButton";
import { Operations } from "../operations";
import { plain } from "../../ui/format";
import { useService } from "../../ui/services";
import { AskActuator } from "./AskActuator";
import { kappaToOffer, type FirstModeInForce } from "./firstMode";
import { presets } from "./presets";
import { useWhyNoRestart } from "./useWhyNoRestart";

/** Lets the observer's body move as fast as the arm was measured to, or by its table again; asks first. */
export function ObserverKappa({ known }: { readonly known: FirstModeInForce }) {
  const operations = useService(Operations);
  const because = useWhyNoRestart();
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
