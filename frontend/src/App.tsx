import { Loader, Tabs } from "@mantine/core";
import { lazy, Suspense, type ComponentType } from "react";
import { ActuatorPanel } from "./panels/ActuatorPanel";
import { Asking } from "./panels/Asking";
import { Banner } from "./panels/Banner";
import { ControlPanel } from "./panels/ControlPanel";
import { GainsPanel } from "./panels/GainsPanel";
import { Guide } from "./panels/Guide";
import { Header } from "./panels/Header";
import { HealthPanel } from "./panels/HealthPanel";
import { HealthStrip } from "./panels/HealthStrip";
import { KeyHelp } from "./panels/KeyHelp";
import { LogPanel } from "./panels/LogPanel";
import { Login } from "./panels/Login";
import { RunPanel } from "./panels/RunPanel";
import { Scene3D } from "./panels/Scene3D";
import { SensingPanel } from "./panels/SensingPanel";
import { Starting } from "./panels/Starting";
import { useDashboard, usePage } from "./panels/context";
import { useKeys } from "./panels/useKeys";
import { PlanView } from "./plan/PlanView";
import { PlotStrip } from "./plots/PlotStrip";

const Review = lazy(() => import("./review/Review"));

export function App() {
  const session = usePage((page) => page.session);
  if (session === "unknown") return <Starting />;
  return session === "absent" ? <Login /> : <Bench />;
}

/** Live and Review. The live half stays mounted (hidden) while reviewing: nothing reloads on return. */
function Bench() {
  const { page } = useDashboard();
  const view = usePage((state) => state.view);
  const [help, setHelp] = useKeys();
  return (
    <div className="bench">
      <Header
        view={view}
        onView={(wanted) => {
          page.patch({ view: wanted });
        }}
        onHelp={() => {
          setHelp(true);
        }}
      />
      <Asking />
      {view === "live" ? <Guide /> : null}
      <HealthStrip />
      <Live hidden={view !== "live"} />
      {view === "review" ? (
        <Suspense fallback={<Loader m="xl" />}>
          <Review />
        </Suspense>
      ) : null}
      <KeyHelp
        opened={help}
        onClose={() => {
          setHelp(false);
        }}
      />
    </div>
  );
}

function Live({ hidden }: { readonly hidden: boolean }) {
  const stale = usePage((page) => !page.online || !page.rigLive);
  return (
    <main className="live" hidden={hidden} data-stale={stale}>
      <div className="stage">
        <PlanView />
        <Banner />
      </div>
      <aside className="side">
        <Scene3D />
        <Panels />
      </aside>
      <PlotStrip />
    </main>
  );
}

const TABS: readonly (readonly [string, string, ComponentType])[] = [
  ["control", "Control", ControlPanel],
  ["run", "Run", RunPanel],
  ["sensing", "Sensing", SensingPanel],
  ["gains", "Gains", GainsPanel],
  ["actuator", "Actuator", ActuatorPanel],
  ["health", "Health", HealthPanel],
  ["log", "Log", LogPanel],
];

function Panels() {
  return (
    <Tabs defaultValue="control" className="tabs" keepMounted={false}>
      <Tabs.List>
        {TABS.map(([value, label]) => (
          <Tabs.Tab key={value} value={value}>
            {label}
          </Tabs.Tab>
        ))}
      </Tabs.List>
      {TABS.map(([value, , Panel]) => (
        <Tabs.Panel key={value} value={value}>
          <Panel />
        </Tabs.Panel>
      ))}
    </Tabs>
  );
}
