/** An earlier drive to race against: where the crane was so long after its first motion. */

import type { Point } from "./messages";
import type { TaskName } from "./tasks";

export const GHOSTS = { best: "best drive of the task", last: "the drive before", none: "none" } as const;
export type GhostName = keyof typeof GHOSTS;

/** Time between two recorded instants, s, and instants kept: ten minutes. */
const EVERY = 0.05;
const MOST = 12000;
/** Travel of the tip from its start at which a drive begins, m. */
const OFF = 0.01;

/** A drive as a ghost shows it. */
interface Drive {
  machine: string;
  mode: string;
  times: number[];
  tips: Point[];
  /** Corners of all shapes, in their order. */
  corners: Float32Array[];
  /** Time of the first motion, s. */
  began: number | null;
}

/** What a ghost shows at an instant. */
export interface Ghost {
  corners: Float32Array;
  path: Point[];
  mode: string;
}

const empty = (machine: string): Drive => ({ machine, mode: "", times: [], tips: [], corners: [], began: null });

export class Ghosts {
  chosen: GhostName = "best";
  private now = empty("");
  private last: Drive | null = null;
  /** The best drive of each task, and its time, s. */
  private readonly best = new Map<TaskName, { time: number; drive: Drive }>();

  /** A fresh start: the drive at hand becomes the one before, if the crane has moved in it. */
  begin(machine: string): void {
    if (this.now.began !== null) this.last = this.now;
    this.now = empty(machine);
  }

  /** An instant of the drive at hand. */
  see(time: number, tip: Point, mode: string, corners: Float64Array): void {
    const { times, tips } = this.now;
    if (times.length >= MOST || time < (times.at(-1) ?? -1) + EVERY - 1e-9) return;
    times.push(time);
    tips.push(tip);
    this.now.corners.push(Float32Array.from(corners));
    this.now.mode = mode;
    const [x, z] = tips[0]!;
    if (this.now.began === null && Math.hypot(tip[0] - x, tip[1] - z) > OFF) this.now.began = time;
  }

  /** The drive at hand has done a task in a time, s. */
  done(task: TaskName, time: number): void {
    const best = this.best.get(task);
    if (best && best.time <= time && best.drive.machine === this.now.machine) return;
    const { times, tips, corners } = this.now;
    this.best.set(task, { time, drive: { ...this.now, times: [...times], tips: [...tips], corners: [...corners] } });
  }

  /** The ghost at a time (s) of the drive at hand, where there is one for this machine. */
  at(time: number, task: TaskName | null): Ghost | null {
    const best = task ? this.best.get(task)?.drive : null;
    const drive = { best, last: this.last, none: null }[this.chosen];
    if (!drive || drive.began === null || drive.machine !== this.now.machine) return null;
    const since = this.now.began === null ? 0 : time - this.now.began;
    const place = drive.times.findLastIndex((other) => other <= drive.began! + since);
    const [a, b] = [Math.max(place, 0), Math.min(Math.max(place, 0) + 1, drive.times.length - 1)];
    const span = drive.times[b]! - drive.times[a]!;
    const share = span > 0 ? Math.min(Math.max((drive.began + since - drive.times[a]!) / span, 0), 1) : 0;
    const corners = drive.corners[a]!.map((value, i) => value + share * (drive.corners[b]![i]! - value));
    return { corners, path: drive.tips, mode: drive.mode };
  }
}
