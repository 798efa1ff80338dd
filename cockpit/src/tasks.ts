/** Things to do with the tip, and how well they were done: time, distance from the path, work of the pump. */

import type { Point } from "./messages";

export const TASKS = {
  line: "Follow a line, straight up",
  square: "Follow a square",
  circle: "Follow a circle",
  logs: "Move logs into the bunk",
} as const;
export type TaskName = keyof typeof TASKS;
export type PathName = Exclude<TaskName, "logs">;

export interface Score {
  task: TaskName;
  mode: string;
  /** s */
  time: number;
  /** Distance from the path, or of logs from the middle of the bunk, m. */
  worst: number;
  mean: number;
  /** Work of the pump, J. */
  work: number;
}

/** Points of a path. */
const POINTS = 400;
/** Points ahead of the last one that the tip may reach at once: nobody cuts a corner. */
const AHEAD = 12;
/** Way from the start at which the clock begins, m. */
const OFF = 0.01;

/** Corners of each path in sizes, from the start, outward (x) and up (z). */
const CORNERS: Record<Exclude<PathName, "circle">, Point[]> = {
  line: [
    [0, 0],
    [0, 1.4],
  ],
  square: [
    [0, 0],
    [0, 1],
    [-1, 1],
    [-1, 0],
    [0, 0],
  ],
};

function shape(task: PathName, share: number): Point {
  if (task === "circle") {
    const angle = 2 * Math.PI * share;
    return [-0.5 * Math.sin(angle), 0.5 - 0.5 * Math.cos(angle)];
  }
  const corners = CORNERS[task];
  const place = Math.min(share * (corners.length - 1), corners.length - 1 - 1e-9);
  const [from, to] = [corners[Math.floor(place)]!, corners[Math.floor(place) + 1]!];
  const rest = place - Math.floor(place);
  return [from[0] + rest * (to[0] - from[0]), from[1] + rest * (to[1] - from[1])];
}

export class Task {
  readonly path: Point[];
  /** Points behind the tip. */
  done = 0;
  over = false;
  private readonly modes = new Set<string>();
  private began: { time: number; work: number } | null = null;
  private worst = 0;
  private sum = 0;
  private samples = 0;

  /** `size`: edge of the square, m. */
  constructor(
    readonly name: PathName,
    start: Point,
    size: number,
  ) {
    this.path = Array.from({ length: POINTS + 1 }, (_, i) => {
      const [x, z] = shape(name, i / POINTS);
      return [start[0] + size * x, start[1] + size * z];
    });
  }

  /** The tip at a time (s), with the pump's work so far (J): the score once the end is reached. */
  follow(time: number, tip: Point, work: number, mode: string): Score | null {
    const away = (i: number): number => Math.hypot(tip[0] - this.path[i]![0], tip[1] - this.path[i]![1]);
    if (!this.began) {
      if (away(0) > OFF) this.began = { time, work };
      return null;
    }
    this.modes.add(mode);
    let nearest = this.done;
    for (let i = this.done; i <= Math.min(this.done + AHEAD, POINTS); i++) if (away(i) < away(nearest)) nearest = i;
    this.done = nearest;
    const distance = away(nearest);
    this.worst = Math.max(this.worst, distance);
    this.sum += distance;
    this.samples++;
    if (nearest < POINTS - 1) return null;
    this.over = true;
    const mean = this.sum / this.samples;
    return { task: this.name, mode: [...this.modes].join(" + "), time: time - this.began.time, worst: this.worst, mean, work: work - this.began.work };
  }
}
