/** Logs and what carries them: where they lie on the ground, what the grapple holds, the bunk, and how well a task was done. */

import type { MachineKey } from "./file-keys";
import type { Description, Overrides, Point, Support } from "./messages";
import type { Score } from "./tasks";

/** Mass of a log of the task, kg. */
export const LOG = 40;
/** Distance from a log at which the grapple reaches it, and how far below its ring of that: lower, it would be pressed into the
 * ground, m. */
const GRIP = 0.15;
const BELOW = 0.03;
/** Way from the start at which the clock begins, m. */
const OFF = 0.01;
/** Where the outermost log and the bunk may stand, in shares of the reach; the first places with room are taken. */
const OUTERMOST = 0.86;
const BUNKS = [0.44, 0.36, 0.5, 0.3];
const COUNT = 3;
/** Places that are tried for them at most. */
const TRIALS = 40;
/** Where the log of a free drive may lie. */
const FREE = [0.62, 0.7, 0.54, 0.78, 0.46, 0.86];
/** Height of the bunk's floor above the ground, its half width, and the room for letting go above it, m. */
const FLOOR = 0.35;
export const HALF = 0.3;
const ROOM = 0.5;

/** The region that is the ground where the machine states none. */
export const GROUND = "ground";
/** Name of the bunk among the supports on the ground, and the room between its walls and its floor's half width, m. */
export const BUNK = "bunk";
const WALL = 0.1;
/** Length of the line between tip and load, m, where what hangs there is long enough. */
const LINE = 0.12;
/** Logs that lie about at most; the first ones are taken away. */
const MOST = 20;
/** From log to log, m: room for an open grapple. */
const APART = 0.525;
/** Density of fresh spruce, kg/m³, and length of a log, m, as its end is drawn. */
const DENSITY = 850;
const LENGTH = 3;

export interface Lying {
  /** Place of the tip that grips it. */
  at: Point;
  mass: number;
}

/** Logs that lie, one that hangs, and a bunk where there is one. */
export class Logs {
  readonly ground: Ground;
  lying: Lying[] = [];
  /** What the grapple holds, kg. */
  holds: number;
  /** How far the logs in the bunk lie from its middle, m, outward positive. */
  readonly placed: number[] = [];
  /** Place of the tip where a log touches the floor of the bunk. */
  readonly bunk: Point | null;

  constructor(description: Description) {
    this.ground = new Ground(description);
    this.bunk = this.ground.bunk;
    this.holds = description.payload;
  }

  /** One log on the ground within reach, unless something hangs already; none where there is no ground. */
  static free(description: Description, mass: number): Logs {
    const logs = new Logs(description);
    const at = logs.somewhere(mass);
    if (at && !logs.holds) logs.lying = [{ at, mass }];
    return logs;
  }

  /** Where a log can lie on the ground for the tip to grip it, null where it can nowhere. */
  somewhere(mass: number): Point | null {
    const places = FREE.map((share) => this.ground.place(share * this.ground.reach, 0, mass));
    return places.find((place) => place !== null) ?? null;
  }

  /** The log that lies alone has another mass. */
  weigh(mass: number): void {
    this.lying = this.lying.map((log) => this.onGround(log.at[0], mass));
  }

  /** The grapple closes or opens at `tip`: the payload after that, kg, or why nothing happens. */
  grip(tip: Point): number | string {
    if (this.holds) return this.letGo(tip);
    if (!this.lying.length) return "There is no log to pick up.";
    const away = ({ at: [x, z] }: Lying): number => Math.hypot(tip[0] - x, tip[1] - z);
    const nearest = this.lying.reduce((a, b) => (away(b) < away(a) ? b : a));
    if (away(nearest) > GRIP) return "No log within reach of the grapple: move the tip to a ring.";
    if (tip[1] < nearest.at[1] - BELOW) return "The grapple is too low: raise the tip to the middle of the ring.";
    this.take(nearest);
    return nearest.mass;
  }

  private take(log: Lying): void {
    this.lying = this.lying.filter((other) => other !== log);
    this.holds = log.mass;
  }

  /** A log that is let go falls into the bunk or to the ground, where there is some. */
  protected letGo([x]: Point): number | string {
    if (this.bunk && Math.abs(x - this.bunk[0]) <= HALF) this.placed.push(x - this.bunk[0]);
    else if (this.ground.top(x) !== null) this.lying = [...this.lying.slice(1 - MOST), this.onGround(x, this.holds)];
    this.holds = 0;
    return 0;
  }

  private onGround(x: number, mass: number): Lying {
    return { at: [x, (this.ground.top(x) ?? 0) + this.ground.hanging(mass)], mass };
  }

  /** What the tip carries in a replay, where nobody here grips. */
  see(payload: number, tip: Point): void {
    if (payload === this.holds) return;
    if (this.holds) this.letGo(tip);
    const [first] = this.lying;
    if (payload && first) this.take(first);
    this.holds = payload;
  }

  /** Height of what a log at `x` lies on, null where there is nothing under it. */
  support(x: number): number | null {
    if (this.bunk && Math.abs(x - this.bunk[0]) <= HALF) return this.bunk[1] - this.ground.hanging(LOG);
    return this.ground.top(x);
  }
}

export class LogTask extends Logs {
  readonly name = "logs";
  over = false;
  private began: { time: number; work: number } | null = null;
  private readonly modes = new Set<string>();
  private readonly count: number;

  private constructor(
    description: Description,
    private readonly start: Point,
    places: Point[],
    override readonly bunk: Point,
  ) {
    super(description);
    this.holds = 0;
    this.lying = places.map((at) => ({ at, mass: LOG }));
    this.count = places.length;
  }

  /** The machine's keys that put the bunk where the tip reaches it and some logs; null where there is no room. */
  static keys(description: Description): Overrides | null {
    const ground = new Ground(description);
    const bunk = BUNKS.map((share) => ground.place(share * ground.reach, FLOOR, LOG)).find((place) => place !== null);
    if (!bunk || !places(ground, bunk[0]).length) return null;
    const [x, height] = [bunk[0], bunk[1] - ground.hanging(LOG)];
    return {
      [ofBunk("height")]: height,
      [ofBunk("from")]: x - HALF,
      [ofBunk("to")]: x + HALF,
      [ofBunk("edge")]: WALL,
    };
  }

  /** What is changed on a machine but for its bunk. */
  static without(overrides: Overrides): Overrides {
    return Object.fromEntries(Object.entries(overrides).filter(([key]) => !key.startsWith(`ground.support.${BUNK}.`)));
  }

  /** Logs where the tip, which is at `start`, can reach them beside the bunk; null where there is no bunk. */
  static within(description: Description, start: Point): LogTask | null {
    const ground = new Ground(description);
    return ground.bunk && new LogTask(description, start, places(ground, ground.bunk[0]), ground.bunk);
  }

  protected override letGo([x, z]: Point): number | string {
    const [middle, floor] = this.bunk;
    if (Math.abs(x - middle) <= HALF && z >= floor - GRIP && z <= floor + ROOM) {
      this.placed.push(x - middle);
      this.holds = 0;
      return 0;
    }
    if (!this.ground.place(x, 0, LOG)) return "The tip could not reach the log again here: let it go over the ground or in the bunk.";
    return super.letGo([x, z]);
  }

  /** The tip at a time (s), with the pump's work so far (J): the score once all logs lie in the bunk. */
  follow(time: number, tip: Point, work: number, mode: string): Score | null {
    if (!this.began) {
      if (Math.hypot(tip[0] - this.start[0], tip[1] - this.start[1]) > OFF) this.began = { time, work };
      return null;
    }
    this.modes.add(mode);
    if (this.placed.length < this.count) return null;
    this.over = true;
    const off = this.placed.map(Math.abs);
    return {
      task: this.name,
      mode: [...this.modes].join(" + "),
      time: time - this.began.time,
      worst: Math.max(...off),
      mean: off.reduce((sum, one) => sum + one, 0) / off.length,
      work: work - this.began.work,
    };
  }
}

/** A key of the bunk. */
function ofBunk(key: "height" | "from" | "to" | "edge"): MachineKey {
  return `ground.support.${BUNK}.${key}`;
}

/** Places of the tip that grips the logs of the task, outside of a bunk at `x`. */
function places(ground: Ground, x: number): Point[] {
  const trials = Array.from({ length: TRIALS }, (_, i) => OUTERMOST * ground.reach - i * APART);
  const clear = trials.filter((trial) => trial > x + 2 * HALF).map((trial) => ground.place(trial, 0, LOG));
  return clear.filter((place) => place !== null).slice(0, COUNT);
}

/** Where the ground is, how far loads hang, and where the tip can be with a log that hangs clear of it. */
export class Ground {
  readonly reach: number;
  /** Length of the line between tip and load, m. */
  readonly line: number;
  /** Place of the tip where a log touches the floor of the bunk; null where there is none. */
  readonly bunk: Point | null;
  /** Whether the ground carries. */
  readonly carries: boolean;
  private readonly height: number | null;
  private readonly hang: [number, number];
  private readonly supports: Support[];
  private readonly curves = new Path2D();
  private readonly context = document.createElement("canvas").getContext("2d")!;
  private readonly regions: { name: string; path: Path2D; left: number; right: number; top: number }[];

  constructor(description: Description) {
    this.reach = description.workspace.flat().reduce((most, [x]) => Math.max(most, x), 0);
    this.hang = description.hang;
    this.line = Math.min(LINE, 0.5 * this.hang[0]);
    this.carries = description.ground !== null;
    this.height = description.ground?.height ?? null;
    const supports = description.ground?.supports ?? [];
    this.supports = supports.filter(({ name }) => name !== BUNK);
    const bunk = supports.find(({ name }) => name === BUNK);
    this.bunk = bunk ? [0.5 * (bunk.from + bunk.to), bunk.height + this.hanging(LOG)] : null;
    for (const curve of description.workspace) {
      curve.forEach(([x, z], i) => (i ? this.curves.lineTo(x, z) : this.curves.moveTo(x, z)));
      this.curves.closePath();
    }
    this.regions = description["keep-out"].map(({ name, corners }) => {
      const path = new Path2D();
      corners.forEach(([x, z], i) => (i ? path.lineTo(x, z) : path.moveTo(x, z)));
      const over = (pick: (a: number, b: number) => number, axis: 0 | 1): number =>
        corners.reduce((so, corner) => pick(so, corner[axis]), corners[0]?.[axis] ?? NaN);
      return { name, path, left: over(Math.min, 0), right: over(Math.max, 0), top: over(Math.max, 1) };
    });
  }

  /** From the tip to the lowest point of a load that hangs, m. */
  hanging(mass: number): number {
    return this.hang[0] + this.hang[1] * Math.sqrt(mass);
  }

  /** Radius of a log, m, of its density; it has room below the line. */
  radius(mass: number): number {
    return Math.min(Math.sqrt(mass / (DENSITY * Math.PI * LENGTH)), 0.5 * (this.hanging(mass) - this.line));
  }

  /** Height of the ground at `x`, or of what else is in the way there but the bunk; null where there is none. */
  top(x: number): number | null {
    const here = this.regions.filter(({ name, left, right }) => left < x && x < right && !(this.carries && name === GROUND));
    const carrying = this.supports.filter(({ from, to, edge }) => from - edge < x && x < to + edge);
    const tops = [...here.map(({ top }) => top), ...carrying.map(({ height }) => height)];
    if (this.height !== null) tops.push(this.height);
    return tops.length ? tops.reduce((a, b) => Math.max(a, b)) : null;
  }

  /** Name of what a place lies in, null where it is free. */
  within([x, z]: Point): string | null {
    return this.regions.find(({ path }) => this.context.isPointInPath(path, x, z))?.name ?? null;
  }

  /** Place of the tip whose load touches what lies `above` (m) the ground at `x`; null where the tip cannot get there. */
  place(x: number, above: number, mass: number): Point | null {
    const top = this.top(x);
    if (top === null) return null;
    const z = top + this.hanging(mass) + above;
    const reached = (z: number): boolean => this.context.isPointInPath(this.curves, x, z);
    return reached(z) && reached(z + ROOM) ? [x, z] : null;
  }
}
