/** The crane to scale: ground, reach, links, cylinders with their oil, load, trail, velocities. */

import { extent, multiples } from "./bounds";
import type { Ghost } from "./ghost";
import { BUNK, GROUND, HALF, LOG, type Logs } from "./logs";
import type { Cylinder, Description, Joint, Point, Shape } from "./messages";
import { palette, scaleColour, type Palette } from "./palette";
import { reachOf, type Reach } from "./reach";
import { drawBucket, drawGrapple, drawHook, drawLog, drawSoil, drawVehicle, drawWeight, groundLevel, piled, polygon, tapered, type Brush } from "./scenery";
import type { Task } from "./tasks";
import { View } from "./view";

/** Length of the velocity arrows: metres per metre per second. */
const ARROW = 2.5;
/** Points of the trail. */
const TRAIL = 1500;
/** Widths of links from their first joint to their end, m: the pillar, a beam, what slides in it; of a rig's parts. */
const PILLAR: [number, number] = [0.22, 0.17];
const BEAM: [number, number] = [0.2, 0.11];
const INNER: [number, number] = [0.09, 0.07];
const PLAIN: [number, number] = [0.13, 0.13];
/** Room around the foot of the crane and below what it reaches, m. */
const ROOM = 0.5;
const BELOW = 0.1;
/** Least distance of grid lines and of a hatch's strokes, pixels, and of the latter in the world, m; strokes at most. */
const GRID = 50;
const HATCH = 5;
const HATCH_METRES = 0.14;
const STROKES = 1000;
/** Share of its range at which a joint counts as at its limit. */
const NEAR = 0.01;

interface Figure extends Shape {
  line: Point[];
}

/** What holds a load, null on a rig, and the link that it hangs from. */
interface Held {
  tool: Description["tool"] | null;
  link: Point[];
}

/** What holds a joint at `q`, null where nothing does. */
export function limitOf(joint: Joint, q: number): string | null {
  const [low, high] = joint.limits;
  const margin = NEAR * (high - low);
  if (q < low + margin) return joint.reasons[0];
  return q > high - margin ? joint.reasons[1] : null;
}

/** Numbers of a row by their names. */
export type Reader = (name: string) => number;

export class Picture {
  readonly view = new View(() => (this.stale = true));
  /** Whether it must be drawn anew. */
  stale = true;
  private readonly context: CanvasRenderingContext2D;
  private description: Description | null = null;
  private reach: Reach = reachOf([]);
  private trail: Point[] = [];
  /** Whether the view fits the machine: one without a reach is fitted once it is drawn. */
  private framed = true;
  /** A path to be followed. */
  task: Task | null = null;
  /** Where the tip is told to go. */
  goal: Point | null = null;
  /** An earlier drive. */
  ghost: Ghost | null = null;
  /** Logs that lie about. */
  logs: Logs | null = null;

  constructor(private readonly canvas: HTMLCanvasElement) {
    this.context = canvas.getContext("2d")!;
    new ResizeObserver(() => this.resize()).observe(canvas);
  }

  show(description: Description, keep: boolean): void {
    const other = this.description?.machine.name !== description.machine.name;
    this.description = description;
    this.reach = reachOf(description.workspace);
    if (!keep) this.trail = [];
    this.stale = true;
    if (!other) return;
    this.view.frame(worthSeeing(description));
    this.framed = description.workspace.length > 0;
  }

  follow(tip: Point): void {
    this.trail.push(tip);
    if (this.trail.length > TRAIL) this.trail.splice(0, this.trail.length - TRAIL);
  }

  private resize(): void {
    const ratio = window.devicePixelRatio || 1;
    const { clientWidth, clientHeight } = this.canvas;
    this.canvas.width = Math.round(clientWidth * ratio);
    this.canvas.height = Math.round(clientHeight * ratio);
    this.view.resize(clientWidth, clientHeight);
  }

  draw(row: Float64Array, read: Reader): void {
    const description = this.description;
    if (!description) return;
    this.stale = false;
    const colours = palette();
    const ratio = window.devicePixelRatio || 1;
    const c = this.context;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.fillStyle = colours.ground;
    c.fillRect(0, 0, this.canvas.width, this.canvas.height);
    const figures = figuresOf(description, row.subarray(description.signals.length));
    if (!this.framed) {
      this.view.frame(around(figures));
      this.framed = true;
    }
    const { scale, x, z } = this.view;
    c.setTransform(ratio * scale, 0, 0, -ratio * scale, ratio * x, ratio * z);
    c.lineJoin = c.lineCap = "round";
    const brush: Brush = { c, colours, pixels: (count) => this.pixels(count), shown: this.view.shown };
    this.drawReach(colours);
    this.drawGrid(colours);
    this.drawPlace(description, figures, brush);
    if (this.task) this.drawTask(this.task, colours);
    if (this.logs) this.drawLogs(this.logs, brush);
    if (this.goal) this.drawGoal(this.goal, colours);
    if (this.ghost) this.drawGhost(description, this.ghost, colours);
    this.drawTrail(colours);
    this.drawCrane(description, figures, read, colours);
    const tip = figures.find((figure) => figure.kind === "tip")?.line[0];
    if (!tip) return;
    const tool = description.controllers.includes("tip") ? description.tool : null;
    const link = figures.findLast(({ kind }) => kind === "link")?.line ?? [tip];
    if (this.logs) this.drawLoad(this.logs, tip, read("payload"), { tool, link }, brush);
    this.drawTip(tip, read, colours);
  }

  /** Width in pixels, whatever the zoom. */
  private pixels(width: number): number {
    return width / this.view.scale;
  }

  private drawGrid(colours: Palette): void {
    const c = this.context;
    const [[left, bottom], [right, top]] = this.view.shown;
    const least = this.pixels(GRID);
    const decade = 10 ** Math.floor(Math.log10(least));
    const step = decade * ([1, 2, 5].find((times) => times * decade >= least) ?? 10);
    c.strokeStyle = colours.grid;
    c.lineWidth = this.pixels(1);
    c.beginPath();
    for (const x of multiples(step, left, right, STROKES)) {
      c.moveTo(x, bottom);
      c.lineTo(x, top);
    }
    for (const z of multiples(step, bottom, top, STROKES)) {
      c.moveTo(left, z);
      c.lineTo(right, z);
    }
    c.stroke();
  }

  /** The area as one, with an edge outside alone: where its parts overlap there is none. */
  private drawReach(colours: Palette): void {
    const c = this.context;
    c.strokeStyle = colours.reachEdge;
    c.lineWidth = this.pixels(1.5);
    c.stroke(this.reach.lines);
    c.lineWidth = this.pixels(3);
    c.stroke(this.reach.area);
    c.fillStyle = colours.ground;
    c.fill(this.reach.area);
    c.fillStyle = colours.reach;
    c.fill(this.reach.area);
  }

  /** Ground, vehicle, keep-out regions, and supports; the bunk has its own picture. */
  private drawPlace(description: Description, figures: Figure[], brush: Brush): void {
    const { c, colours } = brush;
    const level = groundLevel(description);
    if (level !== null) {
      drawSoil(brush, level);
      const foot = figures.find((figure) => figure.kind === "joint")?.line[0];
      if (foot) drawVehicle(brush, level, foot);
    }
    for (const { name, corners } of description["keep-out"]) {
      if (name === GROUND && extent(corners)?.[1][1] === level) continue;
      const path = polygon(corners);
      c.fillStyle = colours.forbidden;
      c.fill(path);
      this.hatch(path, corners, colours.forbiddenEdge);
    }
    c.fillStyle = colours.soilEdge;
    for (const { name, height, from, to, edge } of description.ground?.supports ?? []) {
      const foot = description.ground!.height;
      const sides: Point[] = [[from - edge, foot], [from, height], [to, height], [to + edge, foot]];
      if (name !== BUNK) c.fill(polygon(sides));
    }
  }

  /** A ring with a cross. */
  private drawGoal([x, z]: Point, colours: Palette): void {
    const c = this.context;
    const [ring, cross] = [this.pixels(8), this.pixels(13)];
    c.strokeStyle = colours.wanted;
    c.lineWidth = this.pixels(1.5);
    c.beginPath();
    c.arc(x, z, ring, 0, 2 * Math.PI);
    for (const [dx, dz] of [
      [cross, 0],
      [0, cross],
    ] as Point[]) {
      c.moveTo(x - dx, z - dz);
      c.lineTo(x + dx, z + dz);
    }
    c.stroke();
  }

  private hatch(path: Path2D, corners: Point[], colour: string): void {
    const c = this.context;
    const [[left, bottom], [right, top]] = extent(corners) ?? [
      [0, 0],
      [0, 0],
    ];
    // What is out of sight needs no strokes.
    const [[x0, z0], [x1, z1]] = this.view.shown;
    const [low, high] = [Math.max(bottom, z0), Math.min(top, z1)];
    c.save();
    c.clip(path);
    c.strokeStyle = colour;
    c.lineWidth = this.pixels(0.7);
    c.beginPath();
    // Each stroke is where x - z has one value, so that strokes stay where they are while the view moves.
    const step = Math.max(HATCH_METRES, this.pixels(HATCH));
    for (const place of multiples(step, Math.max(left, x0) - high, Math.min(right, x1) - low, STROKES)) {
      c.moveTo(place + low, low);
      c.lineTo(place + high, high);
    }
    c.stroke();
    c.restore();
    c.lineWidth = this.pixels(1.4);
    c.strokeStyle = colour;
    c.stroke(path);
  }

  private drawTask({ path, done }: Task, colours: Palette): void {
    const c = this.context;
    const line = (points: Point[], width: number, dash: number[]): void => {
      c.lineWidth = this.pixels(width);
      c.setLineDash(dash.map((length) => this.pixels(length)));
      c.beginPath();
      points.forEach(([x, z], i) => (i ? c.lineTo(x, z) : c.moveTo(x, z)));
      c.stroke();
      c.setLineDash([]);
    };
    c.strokeStyle = colours.task;
    line(path, 2.5, [9, 8]);
    line(path.slice(0, done + 1), 5, []);
    this.ring(path.at(-1)!, this.pixels(9));
  }

  private ring([x, z]: Point, size: number): void {
    const c = this.context;
    c.beginPath();
    c.arc(x, z, size, 0, 2 * Math.PI);
    c.lineWidth = this.pixels(2.5);
    c.stroke();
  }

  /** Logs on the ground with the place of the tip that grips them, and the bunk with those that are done. */
  private drawLogs(logs: Logs, brush: Brush): void {
    for (const { at, mass } of logs.lying) {
      const radius = logs.ground.radius(mass);
      drawLog(brush, [at[0], at[1] - logs.ground.hanging(mass) + radius], radius);
      brush.c.strokeStyle = brush.colours.task;
      this.ring(at, 0.15);
    }
    if (logs.bunk) this.drawBunk(logs, logs.bunk[0], brush);
  }

  private drawBunk(logs: Logs, x: number, brush: Brush): void {
    const { c, colours } = brush;
    const radius = logs.ground.radius(LOG);
    const floor = logs.support(x) ?? 0;
    const heights = piled(logs.placed, radius);
    logs.placed.forEach((off, i) => drawLog(brush, [x + off, floor + heights[i]!], radius));
    c.strokeStyle = logs.holds ? colours.task : colours.steelEdge;
    c.lineWidth = this.pixels(5);
    c.beginPath();
    c.moveTo(x - HALF - 0.1, floor + 0.75);
    c.lineTo(x - HALF - 0.1, floor);
    c.lineTo(x + HALF + 0.1, floor);
    c.lineTo(x + HALF + 0.1, floor + 0.75);
    for (const leg of [x - HALF, x + HALF]) {
      c.moveTo(leg, floor);
      c.lineTo(leg, logs.ground.top(x) ?? floor);
    }
    c.stroke();
  }

  /** What hangs from the tip: a grapple with or without a log, a bucket, or a hook or a rig's rod with its weight. */
  private drawLoad(logs: Logs, tip: Point, payload: number, { tool, link }: Held, brush: Brush): void {
    const { ground, lying } = logs;
    const length = ground.hanging(payload || lying[0]?.mass || LOG);
    const room = tip[1] - (logs.support(tip[0]) ?? -Infinity);
    if (tool === "bucket") {
      drawBucket(brush, tip, link, payload);
    } else if (tool !== "grapple") {
      if (tool === "hook") drawHook(brush, tip, length);
      if (payload) drawWeight(brush, tip, length, payload);
    } else {
      const radius = payload ? ground.radius(payload) : 0;
      const reach = payload ? Math.min(length, room) : length;
      drawGrapple(brush, tip, { length: reach, line: ground.line, holds: radius, room });
      if (payload) drawLog(brush, [tip[0], tip[1] - reach + radius], radius);
    }
    const beside: Point = [tip[0] + this.pixels(18) + 0.12, tip[1] - 0.75 * length];
    if (payload) this.label(`${payload.toFixed(0)} kg`, beside, brush.colours.ink, "left");
  }

  /** Where the crane was on an earlier drive, and the path of its tip. */
  private drawGhost(description: Description, { corners, path, mode }: Ghost, colours: Palette): void {
    const c = this.context;
    c.strokeStyle = colours.ghost;
    c.lineWidth = this.pixels(1.3);
    c.setLineDash([this.pixels(5), this.pixels(5)]);
    c.beginPath();
    path.forEach(([x, z], i) => (i ? c.lineTo(x, z) : c.moveTo(x, z)));
    c.stroke();
    c.setLineDash([]);
    c.globalAlpha = 0.35;
    c.lineWidth = 0.09;
    for (const { kind, line } of figuresOf(description, corners)) {
      if (kind === "link") c.stroke(polyline(line));
      if (kind !== "tip") continue;
      c.globalAlpha = 1;
      c.lineWidth = this.pixels(2);
      this.ring(line[0]!, this.pixels(6));
      const [x, z] = line[0]!;
      this.label(`earlier drive, ${mode}`, [x + this.pixels(12), z + this.pixels(12)], colours.ghost, "left");
    }
    c.globalAlpha = 1;
  }

  private drawTrail(colours: Palette): void {
    const c = this.context;
    c.strokeStyle = colours.trail;
    c.lineWidth = this.pixels(2);
    const pieces = 12;
    const length = Math.ceil(this.trail.length / pieces);
    for (let piece = 0; piece < pieces; piece++) {
      const part = this.trail.slice(piece * length, (piece + 1) * length + 1);
      if (part.length < 2) continue;
      c.globalAlpha = 0.08 + (0.55 * (piece + 1)) / pieces;
      c.beginPath();
      part.forEach(([x, z], i) => (i ? c.lineTo(x, z) : c.moveTo(x, z)));
      c.stroke();
    }
    c.globalAlpha = 1;
  }

  private drawCrane(description: Description, figures: Figure[], read: Reader, colours: Palette): void {
    // Each joint moves the link after it; what slides is inside of what it slides in.
    const links = figures.filter((figure) => figure.kind === "link");
    const slides = (i: number): boolean => i > 0 && description.joints[i - 1]?.unit === "m";
    const crane = description.controllers.includes("tip");
    const beam = (i: number): [number, number] => (!crane ? PLAIN : slides(i) ? INNER : i ? BEAM : PILLAR);
    links.forEach((figure, i) => slides(i) && this.beam(figure.line, beam(i), colours));
    links.forEach((figure, i) => slides(i) || this.beam(figure.line, beam(i), colours));
    for (const cylinder of description.cylinders) this.drawCylinder(description, cylinder, figures, read, colours);
    for (const figure of figures) if (figure.kind === "torque-link") this.beam(figure.line, [0.05, 0.05], colours);
    const c = this.context;
    figures
      .filter((figure) => figure.kind === "joint")
      .forEach((figure, i) => {
        const joint = description.joints[i]!;
        const atLimit = limitOf(joint, read(`joint.${joint.name}.q`)) !== null;
        const [x, z] = figure.line[0]!;
        if (joint.unit === "m" && !atLimit) return;
        c.beginPath();
        c.arc(x, z, atLimit ? 0.075 : 0.045, 0, 2 * Math.PI);
        c.fillStyle = atLimit ? colours.limit : colours.ground;
        c.fill();
        c.strokeStyle = atLimit ? colours.limit : colours.steelEdge;
        c.lineWidth = this.pixels(1.6);
        c.stroke();
      });
  }

  private beam(line: Point[], [first, last]: [number, number], colours: Palette): void {
    const c = this.context;
    const [begin, end] = [line[0]!, line.at(-1)!];
    const plate = line.length > 2 && begin[0] === end[0] && begin[1] === end[1];
    // A closed outline is a plate with eyes around its pins.
    const path = plate ? tapered(line, last, last) : tapered(line, first, last);
    if (plate) path.addPath(polygon(line));
    c.strokeStyle = colours.steelEdge;
    c.lineWidth = this.pixels(2);
    c.stroke(path);
    c.fillStyle = colours.steel;
    c.fill(path);
  }

  /** Barrel with both chambers in the colour of their pressure, piston and rod. */
  private drawCylinder(
    description: Description,
    cylinder: Cylinder,
    figures: Figure[],
    read: Reader,
    colours: Palette,
  ): void {
    const of = (kind: string): Figure | undefined =>
      figures.find((figure) => figure.kind === kind && figure.name === cylinder.name);
    const [from, mouth] = of("cylinder-barrel")?.line ?? [];
    const pin = of("cylinder-rod")?.line[1];
    if (!from || !mouth || !pin) return;
    const half = cylinder.stroke / 2;
    const x = read(`cylinder.${cylinder.name}.x`);
    const share = 0.06 + (0.88 * (x + half)) / cylinder.stroke;
    const piston: Point = [from[0] + share * (mouth[0] - from[0]), from[1] + share * (mouth[1] - from[1])];
    const edge = x < cylinder.limits[0] + cylinder.stop || x > cylinder.limits[1] - cylinder.stop;
    const bore = Math.max(cylinder.bore, 0.05);
    const stroke = (a: Point, b: Point, width: number, colour: string, cap: CanvasLineCap = "butt"): void => {
      const c = this.context;
      c.lineCap = cap;
      c.strokeStyle = colour;
      c.lineWidth = width;
      c.beginPath();
      c.moveTo(...a);
      c.lineTo(...b);
      c.stroke();
      c.lineCap = "round";
    };
    const pressure = (side: number): string =>
      scaleColour(read(`cylinder.${cylinder.name}.p${side}`) / description.supply);
    stroke(from, mouth, bore + this.pixels(edge ? 6 : 3), edge ? colours.limit : colours.steelEdge);
    stroke(from, piston, bore, pressure(1));
    stroke(piston, mouth, bore, pressure(2));
    stroke(piston, pin, Math.max(cylinder.rod, 0.025) + this.pixels(1.5), colours.steelEdge);
    stroke(piston, pin, Math.max(cylinder.rod, 0.025), colours.rod);
    const width = 0.03 / Math.max(Math.hypot(mouth[0] - from[0], mouth[1] - from[1]), 1e-9);
    const back: Point = [piston[0] - width * (mouth[0] - from[0]), piston[1] - width * (mouth[1] - from[1])];
    stroke(back, piston, bore, colours.ink);
  }

  private drawTip(tip: Point, read: Reader, colours: Palette): void {
    const c = this.context;
    const velocity = (name: string): Point => [read(`${name}.vx`), read(`${name}.vz`)];
    this.arrow(tip, velocity("wanted"), colours.wanted, 7);
    this.arrow(tip, velocity("tip"), colours.actual, 3.5);
    c.beginPath();
    c.arc(tip[0], tip[1], this.pixels(5), 0, 2 * Math.PI);
    c.fillStyle = colours.ink;
    c.fill();
  }

  private arrow(from: Point, velocity: Point, colour: string, width: number): void {
    const speed = Math.hypot(...velocity);
    if (!(speed * ARROW * this.view.scale > 4)) return;
    const c = this.context;
    const to: Point = [from[0] + ARROW * velocity[0], from[1] + ARROW * velocity[1]];
    const [ux, uz] = [velocity[0] / speed, velocity[1] / speed];
    const head = this.pixels(width + 9);
    c.strokeStyle = c.fillStyle = colour;
    c.lineWidth = this.pixels(width);
    c.beginPath();
    c.moveTo(...from);
    c.lineTo(...to);
    c.stroke();
    c.beginPath();
    c.moveTo(to[0] + ux * head, to[1] + uz * head);
    c.lineTo(to[0] - uz * head * 0.6, to[1] + ux * head * 0.6);
    c.lineTo(to[0] + uz * head * 0.6, to[1] - ux * head * 0.6);
    c.fill();
  }

  private label(text: string, at: Point, colour: string, align: CanvasTextAlign): void {
    const c = this.context;
    const ratio = window.devicePixelRatio || 1;
    c.save();
    const [x, z] = this.view.to(at);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.font = "600 12px system-ui, sans-serif";
    c.textAlign = align;
    c.textBaseline = "middle";
    c.fillStyle = colour;
    c.fillText(text, x, z);
    c.restore();
  }
}

/** What the tip can reach outside of keep-out regions, and the foot of the crane. */
function worthSeeing(description: Description): Point[] {
  const boxes = description["keep-out"].flatMap(({ corners }) => {
    const box = extent(corners);
    return box ? [box] : [];
  });
  const inside = ([x, z]: Point): boolean =>
    boxes.some(([low, high]) => x > low[0] && x < high[0] && z > low[1] && z < high[1]);
  const free = description.workspace.flat().filter((point) => !inside(point));
  const depth = (extent(free)?.[0][1] ?? 0) - BELOW;
  return [...free, [-ROOM, 0], [0, depth]];
}

/** The machine as it stands, with as much room again on every side as it takes itself. */
function around(figures: Figure[]): Point[] {
  const box = extent(figures.flatMap(({ line }) => line));
  if (!box) return [];
  const [[left, bottom], [right, top]] = box;
  return [
    [2 * left - right, bottom],
    [2 * right - left, 2 * top - bottom],
  ];
}

function polyline(line: Point[]): Path2D {
  const path = new Path2D();
  line.forEach(([x, z], i) => (i ? path.lineTo(x, z) : path.moveTo(x, z)));
  return path;
}

/** The corners of all shapes, shape by shape. */
function figuresOf(description: Description, corners: ArrayLike<number>): Figure[] {
  let at = 0;
  return description.shapes.map((shape) => {
    const line: Point[] = [];
    for (let i = 0; i < shape.points; i++, at += 2) line.push([corners[at]!, corners[at + 1]!]);
    return { ...shape, line };
  });
}
