/** Logs to be moved from the ground into a bunk: where they lie, what the grapple holds, how well it was done. */

import type { Description, Point } from "./messages";
import type { Score } from "./tasks";

/** Mass of a log, kg. */
export const LOG = 40;
/** Distance from a log at which the grapple reaches it, m. */
const GRIP = 0.15;
/** Way from the start at which the clock begins, m. */
const OFF = 0.01;
/** Where the outermost log and the bunk may stand, in shares of the reach; the first places with room are taken. */
const OUTERMOST = 0.86;
const BUNKS = [0.44, 0.36, 0.5, 0.3];
const COUNT = 3;
/** Height of the bunk's floor above the ground, its half width, and the room for letting go above it, m. */
const FLOOR = 0.35;
export const HALF = 0.3;
const ROOM = 0.5;
/** Fineness of the search for room, m. */
const FINE = 0.05;

/** Length of the line between tip and load, and radius of a load, m. */
export const LINE = 0.12;
export const radius = (mass: number): number => 0.1 + 0.022 * Math.sqrt(mass);
/** From the tip to the lowest point of a log that hangs. */
const HANGING = LINE + 2 * radius(LOG);
/** From log to log. */
const APART = 2.2 * radius(LOG);

export class LogTask {
  readonly name = "logs";
  /** Places of the tip where it grips the logs that lie on the ground. */
  lying: Point[];
  /** How far the logs in the bunk lie from its middle, m, outward positive. */
  readonly placed: number[] = [];
  holds = false;
  over = false;
  private began: { time: number; work: number } | null = null;
  private readonly modes = new Set<string>();
  private readonly count: number;

  private constructor(
    private readonly ground: Ground,
    private readonly start: Point,
    logs: Point[],
    /** Place of the tip where a log touches the floor of the bunk. */
    readonly bunk: Point,
  ) {
    this.lying = logs;
    this.count = logs.length;
  }

  /** Logs and bunk where the tip, which is at `start`, can reach them; null where there is no room. */
  static within(description: Description, start: Point): LogTask | null {
    const ground = new Ground(description);
    const bunk = BUNKS.map((share) => ground.place(share * ground.reach, FLOOR)).find((place) => place !== null);
    if (!bunk) return null;
    const logs: Point[] = [];
    for (let x = OUTERMOST * ground.reach; x > bunk[0] + 2 * HALF && logs.length < COUNT; x -= APART) {
      const place = ground.place(x, 0);
      if (place) logs.push(place);
    }
    return logs.length ? new LogTask(ground, start, logs, bunk) : null;
  }

  /** The grapple closes or opens at `tip`: the payload after that, kg, or why nothing happens. */
  grip(tip: Point): number | string {
    if (this.holds) return this.letGo(tip);
    const away = ([x, z]: Point): number => Math.hypot(tip[0] - x, tip[1] - z);
    const nearest = [...this.lying].sort((a, b) => away(a) - away(b))[0];
    if (!nearest || away(nearest) > GRIP) return "No log within reach of the grapple: bring the tip to a ring.";
    this.lying = this.lying.filter((log) => log !== nearest);
    this.holds = true;
    return LOG;
  }

  private letGo([x, z]: Point): number | string {
    const [middle, floor] = this.bunk;
    if (Math.abs(x - middle) <= HALF && z >= floor - GRIP && z <= floor + ROOM) this.placed.push(x - middle);
    else {
      const place = this.ground.place(x, 0);
      if (!place) return "The log would be lost here: let it go over the ground or in the bunk.";
      this.lying.push(place);
    }
    this.holds = false;
    return 0;
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

/** Where the tip can be with a log that hangs clear of the ground. */
class Ground {
  readonly reach: number;
  private readonly curves: Path2D;
  private readonly context = document.createElement("canvas").getContext("2d")!;
  private readonly heights: [number, number];

  constructor(private readonly description: Description) {
    const corners = description.workspace.flat();
    this.reach = Math.max(...corners.map(([x]) => x));
    this.heights = [Math.min(...corners.map(([, z]) => z)), Math.max(...corners.map(([, z]) => z))];
    this.curves = new Path2D();
    for (const curve of description.workspace) {
      curve.forEach(([x, z], i) => (i ? this.curves.lineTo(x, z) : this.curves.moveTo(x, z)));
      this.curves.closePath();
    }
  }

  /** Place of the tip whose log touches what lies `above` (m) the ground at `x`, or, where there is no ground, above the
   * lowest place within reach; null where the tip cannot get there. */
  place(x: number, above: number): Point | null {
    const tops = this.description["keep-out"]
      .filter(({ corners }) => Math.min(...corners.map((p) => p[0])) < x && x < Math.max(...corners.map((p) => p[0])))
      .map(({ corners }) => Math.max(...corners.map((p) => p[1])));
    const least = Math.max(this.heights[0], ...tops) + HANGING + above;
    const most = tops.length ? least : this.heights[1];
    const reached = (z: number): boolean => this.context.isPointInPath(this.curves, x, z);
    for (let z = least; z <= most; z += FINE) if (reached(z) && reached(z + ROOM)) return [x, z];
    return null;
  }
}
