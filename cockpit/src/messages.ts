/** What page and worker tell each other, and what the core tells of a drive. SI units throughout. */

import type { Controller, MachineKey } from "./file-keys";

/** A controller, or its levers with which `tip` holds the height. */
export type Mode = Controller | "height";

export interface Signal {
  name: string;
  unit: string;
  long: string;
}

export interface Joint {
  name: string;
  unit: string;
  limits: [number, number];
  reasons: [string, string];
  start: number;
}

export interface Cylinder {
  name: string;
  bore: number;
  rod: number;
  stroke: number;
  limits: [number, number];
  stop: number;
  spool: number;
}

export interface Gain {
  name: string;
  key: MachineKey;
  unit: string;
  value: number;
}

export interface Shape {
  kind: "link" | "cylinder-barrel" | "cylinder-rod" | "torque-link" | "joint" | "tip";
  name: string;
  points: number;
}

export type Point = [number, number];

/** A flat support on the ground: full height between `from` and `to`, m. */
export interface Support {
  name: string;
  height: number;
  from: number;
  to: number;
  edge: number;
}

/** What there is to see and steer. */
export interface Description {
  version: string;
  machine: { name: string; title: string; source: string };
  machines: { name: string; title: string }[];
  controllers: Mode[];
  controller: Mode;
  axes: string[];
  tick: number;
  payload: number;
  supply: number;
  "full-speed": number | null;
  gains: Gain[];
  sensors: boolean;
  /** Whether it goes on from what was before. */
  continued: boolean;
  /** When a replay ends, s. */
  "replay-until": number | null;
  /** Version of the cockpit that recorded what is replayed. */
  "recorded-by": string | null;
  /** What the drive was made of, whole. */
  request: Request;
  joints: Joint[];
  cylinders: Cylinder[];
  /** Names of the states, in order; they are signals too. */
  states: string[];
  signals: Signal[];
  ledger: [string, number][];
  shapes: Shape[];
  "keep-out": { name: string; corners: Point[] }[];
  /** What carries the tip and its load; null where nothing does. */
  ground: { height: number; supports: Support[] } | null;
  /** How far the underside of a load hangs below the tip: m, and m per root of its mass, m/kg^0.5. */
  hang: [number, number];
  /** What is drawn at the tip. */
  tool: "hook" | "grapple" | "bucket";
  workspace: Point[][];
}

/** Values in place of those of a machine. */
export type Overrides = Partial<Record<MachineKey, number | string | boolean>>;

/** What makes a drive, as the core takes it. */
export interface Request {
  machine?: string;
  text?: string | null;
  /** Texts of further files: what the machine extends; of a scenario, its machine and its logs. */
  files?: Record<string, string>;
  overrides?: Overrides;
  friction?: number;
  joints?: Record<string, number>;
  payload?: number;
  /** Hoses that burst: cylinder, side, time, s, and area of the hole, m^2. */
  bursts?: [string, string, number, number][];
  controller?: Mode;
  "full-speed"?: number;
  "real-sensors"?: boolean;
  seed?: number;
  "dead-zone"?: number;
  ramp?: number;
  delay?: number;
  /** Whether the ground that is drawn carries, where the machine states none of its own. */
  ground?: boolean;
  /** A scenario to be replayed, which stands for everything else but the `files`, and what errors call it. */
  scenario?: string;
  "scenario-name"?: string;
  "keep-state"?: boolean;
}

/** What is told of a run that somebody looks at. */
export interface Recording {
  title: string;
  /** What simulated it. */
  source: string;
  outcome: string;
  /** Names of the columns of its table, time first. */
  columns: string[];
  /** Time, s, text, and the kind of warning where it is one. */
  events: [number, string, string?][];
}

export interface Problem {
  message: string;
  /** What kind of problem it is, where there is a name for it. */
  slug?: string;
  line?: number | null;
}

export interface Occurrence {
  time: number;
  text: string;
  /** Kind of doubt, where what happened makes the result doubtful, and what helps. */
  warning?: string;
  cure?: string;
}

/** What has happened since it was last asked for. */
export interface News {
  events: Occurrence[];
  ended: Ended | null;
  replaying: boolean;
  /** Where a replay has come to another phase: what there is to see and steer in it. */
  changed: Description | null;
}

export interface Ended {
  kind: string;
  time: number;
  message: string;
}

export type ToWorker =
  | { do: "open"; request: Request }
  /** A run in place of a drive: its table, row by row. */
  | { do: "view"; request: Request; columns: string[]; table: Float64Array }
  | { do: "seek"; time: number }
  /** `share` of the full speed counts. */
  | { do: "steer"; axes: number[]; share: number }
  /** The tip goes to a place (x, z), m, by itself. */
  | { do: "go"; place: Point }
  /** The tip goes to no place any more. */
  | { do: "drop" }
  | { do: "carry"; mass: number }
  | { do: "pace"; speed: number; paused: boolean }
  /** `share`: for a link, not a file. */
  | { do: "save"; share: boolean };

/** How the simulation keeps up with the clock on the wall. */
export interface Pace {
  /** Simulated seconds per second of the wall, over the last while; null until it is measured. */
  factor: number | null;
  /** Whether computing is what keeps the clock from its speed. */
  slow: boolean;
  /** Time given up since the start because the computer was too slow or the page asleep, s. */
  lost: number;
  /** Share of the time that computing takes. */
  load: number;
}

export type FromWorker =
  /** Told all the time, so that a worker that hangs is noticed. */
  | { tell: "alive" }
  | { tell: "opened"; description: Description; fresh: boolean }
  | { tell: "refused"; problem: Problem }
  | { tell: "rows"; latest: Float64Array; history: Float64Array; width: number; pace: Pace; replaying: boolean; anew: boolean }
  | { tell: "happened"; events: Occurrence[]; ended: Ended | null }
  | { tell: "saved"; text: string; share: boolean }
  | { tell: "broken"; message: string };
