import { NativeSelect, Tooltip } from "@mantine/core";
import type { ControllerInfo, Settings } from "../../api/types";
import { MODE } from "../../live/modes";
import { usePage } from "../../live/page";
import { rounded } from "../../ui/format";
import { NumberField } from "../../ui/numbers/NumberField";
import { useService } from "../../ui/services";
import { Operations } from "../operations";
import { useWhyNot } from "../permission";
import { numbersOf } from "./controllers";

const NONE: readonly ControllerInfo[] = [];
const ON_ITS_WAY = "The controller changes in HOLD, not while the tip is on its way: hold first";

/** Which controller is in the rig's slot, what it is, and the numbers of its own that it is tuned by. */
export function ControllerChoice({ settings }: { readonly settings: Settings }) {
  const controllers = usePage((page) => page.rig?.controllers ?? NONE);
  const moving = usePage(({ mode }) => mode === MODE.FOLLOW || mode === MODE.TRACK);
  const forbidden = useWhyNot("settings");
  const choose = useChoose();
  const chosen = controllers.at(settings.controller);
  if (!chosen) return null;
  const reason = forbidden ?? (moving ? ON_ITS_WAY : null);
  return (
    <div className="controller">
      <div className="row">
        <Tooltip label={reason ?? "What turns the error into torques"} openDelay={reason === null ? 500 : 0}>
          <NativeSelect
            size="xs"
            aria-label="Controller"
            data-testid="controller"
            disabled={reason !== null}
            value={chosen.name}
            data={controllers.map(({ name, refused }) => ({
              value: name,
              label: name,
              disabled: refused !== "",
            }))}
            onChange={({ currentTarget }) => void choose(currentTarget.value, {})}
          />
        </Tooltip>
        <span className="note" data-testid="controller-title" title={chosen.citation}>
          {chosen.title}
        </span>
      </div>
      {chosen.tuning.length > 0 ? <Tuning chosen={chosen} settings={settings} choose={choose} /> : null}
    </div>
  );
}

type Choose = (name: string, tuning: Record<string, number>) => Promise<void>;

/** Puts a controller into the slot, or tunes the one that is there. */
function useChoose(): Choose {
  const operations = useService(Operations);
  return (name, tuning) => operations.chooseController(name, tuning);
}

interface TuningProps {
  readonly chosen: ControllerInfo;
  readonly settings: Settings;
  readonly choose: Choose;
}

function Tuning({ chosen, settings, choose }: TuningProps) {
  const reason = useWhyNot("settings");
  const now = numbersOf(chosen, settings.tuning);
  return (
    <div className="gain-table gain-scalars">
      {chosen.tuning.map(({ name, symbol, unit, low, high, about }) => {
        const [base, index] = symbol.split("_");
        return (
          <div className="tuned" key={name}>
            <span className="gain-name" title={about}>
              <span className="symbol">
                {base}
                {index ? <sub>{index}</sub> : null}
              </span>
              <span className="bounds">{`${low} … ${high}${unit === "1" ? "" : ` ${unit}`}`}</span>
            </span>
            <NumberField
              aria-label={`${chosen.name} ${name}`}
              testId={`tuning-${name}`}
              value={rounded(now[name] ?? 0)}
              min={low}
              max={high}
              step={(high - low) / 100}
              hint={about === "" ? `${low} … ${high} ${unit}` : about}
              reason={reason}
              send={(value) => choose(chosen.name, { ...now, [name]: value })}
            />
          </div>
        );
      })}
    </div>
  );
}
