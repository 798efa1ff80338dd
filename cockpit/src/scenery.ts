/** What stands around the crane, in metres with z upwards: the ground, the vehicle's outline, logs, what holds a load. */

import { extent, multiples } from "./bounds";
import { GROUND } from "./logs";
import type { Description, Point } from "./messages";
import type { Palette } from "./palette";

/** What draws: the canvas, its colours, the width in metres of so many pixels, and the part of the world that is shown. */
export interface Brush {
  c: CanvasRenderingContext2D;
  colours: Palette;
  pixels: (count: number) => number;
  shown: [Point, Point];
}

/** Distance and length of the strokes below the surface of the ground, m and pixels at least; strokes at most. */
const STROKE = 0.16;
const LEAST_STROKE = 7;
const STROKES = 600;
/** Least height of the first joint above the ground for a vehicle to be drawn, m. */
const LOW = 0.4;
/** Density of steel, kg/m³. */
const STEEL = 7850;

export function polygon(corners: Point[]): Path2D {
  const path = new Path2D();
  corners.forEach(([x, z], i) => (i ? path.lineTo(x, z) : path.moveTo(x, z)));
  path.closePath();
  return path;
}

/** Height of the ground: what carries, or the flat top of the region of that name; null where neither is there. */
export function groundLevel({ ground, "keep-out": regions }: Description): number | null {
  if (ground) return ground.height;
  const corners = regions.find(({ name }) => name === GROUND)?.corners ?? [];
  const [low, high] = extent(corners) ?? [null, null];
  const flat = extent(corners.filter(([, z]) => z === high?.[1]));
  return low && flat && flat[0][0] === low[0] && flat[1][0] === high[0] ? high[1] : null;
}

/** The half-plane below `level`. */
export function drawSoil({ c, colours, pixels, shown }: Brush, level: number): void {
  const [[left, bottom], [right]] = shown;
  if (level <= bottom) return;
  c.fillStyle = colours.soil;
  c.fillRect(left, bottom, right - left, level - bottom);
  c.strokeStyle = colours.soilEdge;
  const step = Math.max(STROKE, pixels(LEAST_STROKE));
  c.lineWidth = pixels(1);
  c.beginPath();
  for (const x of multiples(step, left, right + step, STROKES)) {
    c.moveTo(x, level);
    c.lineTo(x - 0.6 * step, level - 0.6 * step);
  }
  c.stroke();
  c.lineWidth = pixels(2);
  c.beginPath();
  c.moveTo(left, level);
  c.lineTo(right, level);
  c.stroke();
}

/** Outline of a vehicle that carries the crane, sized by the height of its first joint: a drawing only, it stops nothing. */
export function drawVehicle({ c, colours, pixels }: Brush, level: number, [foot, joint]: Point): void {
  const size = joint - level;
  if (size < LOW) return;
  const at = ([x, z]: Point): Point => [foot + size * x, level + size * z];
  const frame: Point[] = [[-3, 0.33], [0.16, 0.33], [0.16, 0.46], [-3, 0.46]];
  const cab: Point[] = [[-2.95, 0.5], [-1.85, 0.5], [-1.85, 1.3], [-2.6, 1.3], [-2.95, 0.95]];
  const window: Point[] = [[-2.8, 0.92], [-2.1, 0.92], [-2.1, 1.2], [-2.55, 1.2]];
  c.save();
  c.strokeStyle = colours.vehicle;
  c.fillStyle = colours.vehicleFill;
  c.lineWidth = pixels(1.3);
  for (const shape of [frame, cab, window]) {
    const path = polygon(shape.map(at));
    if (shape !== window) c.fill(path);
    c.stroke(path);
  }
  for (const wheel of [-0.45, -1.05, -2.4]) {
    for (const radius of [0.27, 0.12]) {
      c.beginPath();
      c.arc(...at([wheel, 0.27]), radius * size, 0, 2 * Math.PI);
      c.fill();
      c.stroke();
    }
  }
  c.restore();
}

/** The end of a log, with its rings. */
export function drawLog({ c, colours, pixels }: Brush, [x, z]: Point, radius: number): void {
  c.fillStyle = colours.load;
  c.strokeStyle = colours.ink;
  c.lineWidth = pixels(1.3);
  c.beginPath();
  c.arc(x, z, radius, 0, 2 * Math.PI);
  c.fill();
  c.stroke();
  c.lineWidth = pixels(0.6);
  c.beginPath();
  for (const share of [0.7, 0.4]) {
    c.moveTo(x + share * radius, z);
    c.arc(x, z, share * radius, 0, 2 * Math.PI);
  }
  c.stroke();
}

/** Heights above the floor of the middles of logs at `places`, each on what lies there before it. */
export function piled(places: number[], radius: number): number[] {
  const heights: number[] = [];
  places.forEach((x, i) => {
    const below = places.slice(0, i).map((other, j): number => {
      const across = Math.abs(x - other);
      return across < 2 * radius ? heights[j]! + Math.sqrt(4 * radius ** 2 - across ** 2) : 0;
    });
    heights.push(below.reduce((a, b) => Math.max(a, b), radius));
  });
  return heights;
}

/** How a grapple hangs from a tip. */
export interface Grip {
  /** From the tip to the ends of its claws, m. */
  length: number;
  /** Length of the joint between the tip and its rotator, m. */
  line: number;
  /** Radius of the log that it holds, m; 0 where it is open. */
  holds: number;
  /** Room from the tip to what is below it, m: a grapple without a load lies down where there is too little. */
  room: number;
}

export function drawGrapple({ c, colours, pixels }: Brush, tip: Point, { length, line, holds, room }: Grip): void {
  const wide = holds ? Math.max(1.25 * holds + 0.03, 0.11) : 0.27;
  const end = holds ? 0.35 * holds : 0.24;
  const lean = holds || room >= length ? 0 : Math.acos(Math.max(room / length, 0.1));
  const hinge = -Math.min(line + 0.1, 0.5 * length);
  const claw = (side: number): Path2D => {
    const path = new Path2D();
    path.moveTo(side * 0.05, hinge);
    path.bezierCurveTo(side * wide, 0.75 * hinge - 0.25 * length, side * 1.3 * wide, -0.93 * length, side * end, -length);
    return path;
  };
  c.save();
  c.translate(...tip);
  c.rotate(lean);
  const paint = (path: Path2D, width: number): void => {
    c.strokeStyle = colours.steelEdge;
    c.lineWidth = width + pixels(2);
    c.stroke(path);
    c.strokeStyle = colours.steel;
    c.lineWidth = width;
    c.stroke(path);
  };
  const link = new Path2D();
  link.lineTo(0, 0);
  link.lineTo(0, hinge + 0.08);
  paint(link, 0.03);
  [-1, 1].forEach((side) => paint(claw(side), 0.04));
  const rotator = new Path2D();
  rotator.rect(-0.05, hinge - 0.02, 0.1, 0.1);
  paint(rotator, pixels(0.1));
  c.fillStyle = colours.steel;
  c.fill(rotator);
  c.restore();
}

/** A hook on a line, `length` long. */
export function drawHook({ c, colours, pixels }: Brush, [x, z]: Point, length: number): void {
  const size = Math.min(0.12, 0.3 * length);
  const end = z - length + size;
  c.strokeStyle = colours.steelEdge;
  c.lineWidth = Math.max(0.025, pixels(2));
  c.beginPath();
  c.moveTo(x, z);
  c.lineTo(x, end + size);
  c.arc(x, end, size / 2, 0.5 * Math.PI, 1.9 * Math.PI, false);
  c.stroke();
}

/** A bucket at the end of a link, which opens towards its foot; what is in it is its load. */
export function drawBucket({ c, colours, pixels }: Brush, tip: Point, link: Point[], payload: number): void {
  const foot = link[0] ?? tip;
  const reach = Math.hypot(tip[0] - foot[0], tip[1] - foot[1]);
  const size = Math.min(Math.max(0.3 * reach, 0.15), 1.2);
  c.save();
  c.translate(...tip);
  c.rotate(Math.atan2(tip[1] - foot[1], tip[0] - foot[0]) || 0);
  const shell = new Path2D();
  shell.moveTo(0, 0.06 * size);
  shell.bezierCurveTo(0.75 * size, 0.1 * size, 0.85 * size, -0.75 * size, 0.1 * size, -0.95 * size);
  shell.lineTo(-0.08 * size, -0.85 * size);
  shell.closePath();
  c.fillStyle = payload ? colours.load : colours.steel;
  c.fill(shell);
  c.strokeStyle = colours.steelEdge;
  c.lineWidth = pixels(2);
  c.stroke(shell);
  c.restore();
}

/** A block of steel on a rod, as rigs lift it, whose underside is `length` below the tip. */
export function drawWeight({ c, colours, pixels }: Brush, [x, z]: Point, length: number, mass: number): void {
  const side = Math.min(Math.cbrt(mass / STEEL), length);
  c.strokeStyle = colours.ink;
  c.fillStyle = colours.load;
  c.lineWidth = pixels(1.5);
  c.beginPath();
  c.moveTo(x, z);
  c.lineTo(x, z - length + side);
  c.rect(x - side / 2, z - length, side, side);
  c.fill();
  c.stroke();
}

/** A beam along a line whose width goes from `first` to `last`, m, round at both ends. */
export function tapered(line: Point[], first: number, last: number): Path2D {
  const path = new Path2D();
  const lengths = line.map((point, i) => (i ? Math.hypot(point[0] - line[i - 1]![0], point[1] - line[i - 1]![1]) : 0));
  const whole = lengths.reduce((a, b) => a + b, 0) || 1;
  let along = 0;
  const half = lengths.map((length) => 0.5 * (first + ((last - first) * (along += length)) / whole));
  line.forEach(([x, z], i) => {
    path.moveTo(x + half[i]!, z);
    path.arc(x, z, half[i]!, 0, 2 * Math.PI);
    const next = line[i + 1];
    const length = lengths[i + 1] ?? 0;
    if (!next || !length) return;
    // Each piece goes round as the circles do, so that where they overlap nothing is left out.
    const [nx, nz] = [-(next[1] - z) / length, (next[0] - x) / length];
    const [a, b] = [half[i]!, half[i + 1]!];
    path.moveTo(x - a * nx, z - a * nz);
    path.lineTo(next[0] - b * nx, next[1] - b * nz);
    path.lineTo(next[0] + b * nx, next[1] + b * nz);
    path.lineTo(x + a * nx, z + a * nz);
    path.closePath();
  });
  return path;
}
