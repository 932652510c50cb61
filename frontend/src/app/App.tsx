import { Loader, SegmentedControl, Tabs } from "@mantine/core";
import { memo, useEffect, useState, type ComponentType } from "react";
import { Login } from "./Login";
import { CommissioningBar, Lacking, WaivedBar } from "../hardware/commissioning/CommissioningBar";
import { isHardware } from "../hardware/commissioning/commissioning";
import { useCommissioningState } from "../hardware/commissioning/useCommissioning";
import { HealthPanel } from "../health/HealthPanel";
import { Flags } from "../health/Flags";
import { PageStore, usePage, type Page } from "../live/page";
import { LogPanel } from "../health/log/LogPanel";
import { Banner, LatchedBanner } from "../operate/Banner";
import { ControlPanel } from "../operate/ControlPanel";
import { Asking } from "../operate/lease/Asking";
import { PlanView } from "../plan/PlanView";
import { PlotStrip } from "../plots/PlotStrip";
import { ActuatorPanel } from "../hardware/ActuatorPanel";
import { FirstModeBar } from "../operate/presets/FirstMode";
import { GainsPanel } from "../operate/presets/GainsPanel";
import { MacroBar, MacroPanel } from "../runs/macros/MacroPanel";
import { RunPanel } from "../runs/RunPanel";
import { Scene3D } from "../scene/Scene3D";
import { SensingPanel } from "../operate/sensing/SensingPanel";
import { textOf } from "../ui/format";
import { useNarrow } from "../ui/narrow";
import { Part } from "../ui/Part";
import { Guide } from "./guide/Guide";
import { Header } from "./Header";
import { KeyHelp } from "./KeyHelp";
import { WallDisplay } from "./WallDisplay";
import { CommissioningPanel } from "../hardware/commissioning/CommissioningPanel";
import { lackingText } from "../hardware/commissioning/steps";
import { DriversPanel } from "../hardware/DriversPanel";
import { RigFilePanel } from "../hardware/RigFilePanel";
import { useService } from "../ui/services";

const SLOW_MS = 1500;
/** Null until its code has come. */
let Review: ComponentType | null = null;
const loadReview = async () => {
  Review ??= (await import("../recorder/Review")).default;
};
/** From when on a page that stands is at leisure to load what is likely to be asked next [ms]. */
const LEISURE_MS = 1000;

export function App() {
  const session = usePage((page) => page.session);
  if (session === "unknown") return <Starting />;
  return session === "absent" ? <Login /> : <Bench />;
}

/** Before the server's first answer. */
function Starting() {
  const [slow, setSlow] = useState(false);
  useEffect(() => {
    const timer = setTimeout(() => setSlow(true), SLOW_MS);
    return () => {
      clearTimeout(timer);
    };
  }, []);
  return (
    <main className="starting" role="status" data-testid="starting">
      <Loader aria-hidden />
      <p>{slow ? "The server does not answer yet. This page goes on trying." : "Connecting"}</p>
    </main>
  );
}

/** Live and Review. The live half stays mounted (hidden) while reviewing: nothing reloads on return. */
function Bench() {
  const view = usePage((state) => state.view);
  useEffect(() => {
    const timer = setTimeout(() => {
      loadReview().catch(() => undefined); // asked again once it is needed
    }, LEISURE_MS);
    return () => {
      clearTimeout(timer);
    };
  }, []);
  return (
    <div className="bench">
      {view === "wall" ? (
        <Part name="Large numbers">
          <WallDisplay />
        </Part>
      ) : (
        <Header />
      )}
      {view === "live" ? (
        <Part name="Guide">
          <Guide />
        </Part>
      ) : null}
      <div className="over-place">
        <Part name="Requests for control">
          <Asking />
        </Part>
        <Part name="Macro">
          <MacroBar />
        </Part>
        <Part name="First mode">
          <FirstModeBar />
        </Part>
        <Part name="Commissioning">
          <CommissioningBar />
          <WaivedBar />
        </Part>
        {view === "review" ? (
          <Part name="Latched state">
            <LatchedBanner />
          </Part>
        ) : null}
      </div>
      <Live hidden={view !== "live"} />
      {view === "review" ? (
        <Part name="Review">
          <ReviewOnceThere />
        </Part>
      ) : null}
      <KeyHelp />
    </div>
  );
}

/** Not by React's `lazy`: what follows a fallback is held back there until that has stood for 300 ms. */
function ReviewOnceThere() {
  const [there, setThere] = useState(Review !== null);
  const [problem, setProblem] = useState<Error | null>(null);
  useEffect(() => {
    if (there) return;
    loadReview().then(
      () => {
        setThere(true);
      },
      (error: unknown) => {
        setProblem(new Error(textOf(error)));
      },
    );
  }, [there]);
  if (problem) throw problem; // the part says so, and is tried again
  return there && Review ? <Review /> : <Loader m="xl" />;
}

function Live({ hidden }: { readonly hidden: boolean }) {
  const stale = usePage((page) => !page.online || !page.rigLive);
  return (
    <main className="live" hidden={hidden} data-stale={stale}>
      <LiveParts />
    </main>
  );
}

/** Apart: none of it is drawn again because Review is shown. */
const LiveParts = memo(function LiveParts() {
  const narrow = useNarrow();
  return (
    <>
      <div className="stage">
        <Part name="Plan" className="plan">
          <PlanView />
        </Part>
        <Part name="Flags">
          <Flags />
        </Part>
        <Part name="Banner">
          <Banner />
        </Part>
      </div>
      <aside className="side">
        {narrow ? null : (
          <Part name="3D view" className="scene">
            <Scene3D />
          </Part>
        )}
        <Panels tabs={narrow ? NARROW_TABS : TABS} />
      </aside>
      {narrow ? null : (
        <Part name="Plots" className="plots">
          <PlotStrip />
        </Part>
      )}
    </>
  );
});

function Control() {
  return (
    <>
      <ControlPanel />
      <MacroPanel />
    </>
  );
}

const SECTIONS: readonly { readonly value: Page["rigSection"]; readonly label: string }[] = [
  { value: "drivers", label: "Drivers" },
  { value: "file", label: "Rig file" },
  { value: "commissioning", label: "Commissioning" },
];

/** A rig of real devices: how they fare, the file that describes it, and its commissioning. */
function RigPanel() {
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
        onChange={(value) => page.patch({ rigSection: value })}
      />
      {section === "drivers" && state !== null ? <Lacking text={lackingText(state)} /> : null}
      {section === "drivers" ? <DriversPanel /> : null}
      {section === "file" ? <RigFilePanel /> : null}
      {section === "commissioning" ? <CommissioningPanel /> : null}
    </div>
  );
}

type Tab = readonly [string, string, ComponentType];

const TABS: readonly Tab[] = [
  ["control", "Control", Control],
  ["run", "Run", RunPanel],
  ["sensing", "Sensing", SensingPanel],
  ["gains", "Gains", GainsPanel],
  ["actuator", "Actuator", ActuatorPanel],
  ["health", "Health", HealthPanel],
  ["log", "Log", LogPanel],
];

/** Of a rig that is made of devices. */
const RIG_TAB: Tab = ["rig", "Rig", RigPanel];

/** One panel at a time: what otherwise stands beside the panels is one of them. */
const NARROW_TABS: readonly Tab[] = [
  ...TABS.slice(0, 2),
  ["plots", "Plots", PlotStrip],
  ["3d", "3D", Scene3D],
  ...TABS.slice(2),
];

function Panels({ tabs }: { readonly tabs: readonly Tab[] }) {
  const [chosen, setChosen] = useState<string | null>("control");
  const hardware = usePage(isHardware);
  const all = hardware ? [...tabs, RIG_TAB] : tabs;
  const shown = all.some(([value]) => value === chosen) ? chosen : "control";
  return (
    <Tabs value={shown} onChange={setChosen} className="tabs" keepMounted={false}>
      <Tabs.List>
        {all.map(([value, label], i) => (
          <Tabs.Tab key={value} value={value} title={`${label} (${i + 1})`} aria-keyshortcuts={`${i + 1}`}>
            {label}
            {value === "rig" ? <NotCommissioned /> : null}
          </Tabs.Tab>
        ))}
      </Tabs.List>
      {all.map(([value, label, Panel]) => (
        <Tabs.Panel key={value} value={value}>
          <Part name={label}>
            <Panel />
          </Part>
        </Tabs.Panel>
      ))}
    </Tabs>
  );
}

/** A mark on the tab of a rig that lacks something. */
function NotCommissioned() {
  const state = useCommissioningState();
  if (state === null || !state.available || state.complete) return null;
  return (
    <span data-grade="warning">
      {" "}
      <span aria-hidden>▲</span>
      <span className="sr-only">not commissioned</span>
    </span>
  );
}
