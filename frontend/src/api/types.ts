/** Short names of the generated message types (schema.d.ts is made from the server's OpenAPI document). */
import type { components, operations } from "./schema";

type Schemas = components["schemas"];

export type Field = Schemas["Field"];
export type Mode = Schemas["Mode"];
export type Cause = Schemas["Cause"];
export type Law = Schemas["Law"];
export type Settings = Schemas["Settings"];
export type ControllerInfo = Schemas["ControllerInfo"];
export type Lease = Schemas["Lease"];
export type Session = Schemas["Session"];
export type People = Schemas["People"];
export type Person = Schemas["Person"];
export type Role = Person["role"];
export type RigInfo = Schemas["RigInfo"];
export type CommandReply = Schemas["CommandReply"];
export type CommandBody = Schemas["CommandBody"];
export type Workspace = Schemas["Workspace"];
export type ReferenceInfo = Schemas["ReferenceInfo"];
export type ReferencePath = Schemas["ReferencePath"];
export type Recording = Schemas["Recording"];
export type Bookmark = Schemas["Bookmark"];
export type Quick = Schemas["Quick"];
export type SignalInfo = Schemas["SignalInfo"];
export type QuickSignal = Schemas["QuickSignal"];
export type Measured = Schemas["Measured"];
export type Metrics = Schemas["Metrics"];
export type ProfileInfo = Schemas["ProfileInfo"];
export type Profile = ProfileInfo["name"];
export type RecordingState = Schemas["RecordingState"];
export type PlotChannel = Schemas["PlotChannel"];
export type PlotChoice = Schemas["PlotChoice"];
export type PlotLayout = Schemas["PlotLayout"];
export type Plot = PlotLayout["plots"][number];
export type Health = Schemas["Health"];
export type LoopHealth = Schemas["LoopHealth"];
export type AlarmLimits = Schemas["AlarmLimits-Output"];
export type LogEntry = Schemas["LogEntry"];

export type DrawingBody = Schemas["DrawingBody"];
export type DrawingInfo = Schemas["DrawingInfo"];
export type DrawingPlan = Schemas["DrawingPlan"];
export type ImportedPath = Schemas["ImportedPath"];
export type ImportProposal = Schemas["ImportProposal"];
export type ImportChoices = NonNullable<operations["propose_path"]["parameters"]["query"]>;
export type ProposedColumn = Schemas["ProposedColumn"];
export type ProposedRow = Schemas["ProposedRow"];
export type TextPath = Schemas["TextPath"];
export type PreviewBody = Schemas["PreviewBody"];
export type Preview = Schemas["Preview"];
export type PreviewPart = Schemas["PreviewPart"];
export type RunBody = Schemas["RunBody"];
export type RunState = Schemas["RunState"];
export type RunResult = Schemas["RunResult"];

export type Macro = Schemas["Macro"];
export type MacroStep = Macro["steps"][number];
export type MacroState = Schemas["MacroState"];
export type LearnBody = Schemas["LearnBody"];
export type Learned = Schemas["Learned"];
export type FirstModeState = Schemas["FirstModeState"];

export type FromServer =
  | Schemas["Hello"]
  | Schemas["Status"]
  | Schemas["Reply"]
  | Schemas["Refused"]
  | Schemas["Pong"]
  | Schemas["LogEntry"];

export type FromBrowser =
  | Schemas["Target"]
  | Schemas["Release"]
  | Schemas["EStop"]
  | Schemas["Presence"]
  | Schemas["Ping"]
  | PlotChoice;

/** A point of the plane frame [m]. */
export type Point = readonly [number, number];
