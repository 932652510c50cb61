import { usePage } from "../live/page";
import { Facts } from "../ui/Facts";
import {
  driverFacts,
  GRADE,
  MARK,
  namesOf,
  raw,
  ROLE_WORD,
  trouble,
  troubleGrade,
  type DriverStatus,
} from "./drivers";
import { useDrivers } from "./useDrivers";

/** A card for each of the rig's devices, looked at twice a second. */
export function DriversPanel() {
  const { drivers, problem } = useDrivers();
  const alive = usePage((page) => page.online && page.rigLive) && problem === "";
  return (
    <div className="column drivers" data-testid="drivers" data-old={!alive}>
      {problem === "" ? null : (
        <p className="note" role="alert" data-grade="bad">
          {problem}
        </p>
      )}
      {alive || drivers.length === 0 ? null : (
        <p className="note" role="status">
          The rig is not heard: this is how its devices were before.
        </p>
      )}
      {drivers.length === 0 && problem === "" ? <p className="note">Asking the rig.</p> : null}
      <div className="row driver-states" aria-hidden>
        {drivers.map((driver) => (
          <span key={driver.role}>
            {ROLE_WORD[driver.role]} <State state={driver.state} />
          </span>
        ))}
      </div>
      {drivers.map((driver) => (
        <DriverCard key={driver.role} driver={driver} />
      ))}
    </div>
  );
}

/** In a coloured word, with a mark. */
function State({ state }: Pick<DriverStatus, "state">) {
  return (
    <span className="grade" data-grade={GRADE[state]}>
      <span aria-hidden>{MARK[state]}</span> {state}
    </span>
  );
}

function DriverCard({ driver }: { readonly driver: DriverStatus }) {
  const { role, state, device, capabilities } = driver;
  const wrong = trouble(driver);
  return (
    <section className="driver" aria-label={ROLE_WORD[role]} data-testid={`driver-${role}`}>
      <div className="driver-head">
        <h3 className="bar-title">{ROLE_WORD[role]}</h3>
        <span role="status" data-testid={`driver-state-${role}`}>
          <State state={state} />
        </span>
      </div>
      <p className="note driver-device">
        {driver.driver}: {device}
      </p>
      <p
        className="driver-trouble"
        role="status"
        data-grade={troubleGrade(driver)}
        data-testid={`driver-trouble-${role}`}
      >
        {wrong}
      </p>
      <Facts facts={driverFacts(driver)} testId={`driver-facts-${role}`} />
      <RawValues values={driver.values} />
      {capabilities.length === 0 ? null : (
        <details className="note">
          <summary>Capabilities</summary>
          {capabilities.join(", ")}
        </details>
      )}
    </section>
  );
}

/** As they came, before any transform. */
function RawValues({ values }: Pick<DriverStatus, "values">) {
  const names = namesOf(values);
  if (names.length === 0) return <p className="note">No raw values.</p>;
  return (
    <figure className="raw-values">
      <figcaption className="note">Raw values, as they came</figcaption>
      <dl>
        {names.map((name) => (
          <div key={name}>
            <dt>{name}</dt>
            <dd className="number">{(values[name] ?? []).map(raw).join(", ")}</dd>
          </div>
        ))}
      </dl>
    </figure>
  );
}
