/** Which part of the world the picture shows: zoom about a point, pan, fit. Metres to pixels. */

import { extent } from "./bounds";
import type { Point } from "./messages";

const MOST = 2000;
const LEAST = 10;
/** Heights of the readout at the top of the picture and of the legend at its foot, pixels. */
const TOP = 44;
const FOOT = 40;

export class View {
  /** Pixels per metre. */
  scale = 100;
  /** Pixel of the world's origin. */
  x = 0;
  z = 0;
  private box: [Point, Point] = [
    [-1, -1],
    [4, 3],
  ];
  private size: Point = [1, 1];
  private moved = false;

  constructor(private readonly changed: () => void) {}

  /** What is to be seen whole. */
  frame(points: Point[]): void {
    this.box = extent(points) ?? this.box;
    this.fit();
  }

  fit(): void {
    const [low, high] = this.box;
    const [width, height] = [high[0] - low[0], high[1] - low[1]];
    const room = Math.max(this.size[1] - TOP - FOOT, 1);
    this.scale = Math.min(this.size[0] / (width * 1.08), room / (height * 1.08));
    this.x = this.size[0] / 2 - (this.scale * (low[0] + high[0])) / 2;
    this.z = TOP + room / 2 + (this.scale * (low[1] + high[1])) / 2;
    this.moved = false;
    this.changed();
  }

  resize(width: number, height: number): void {
    const [dx, dz] = [(width - this.size[0]) / 2, (height - this.size[1]) / 2];
    this.size = [width, height];
    if (!this.moved) return this.fit();
    this.x += dx;
    this.z += dz;
    this.changed();
  }

  zoom(factor: number, at: Point = [this.size[0] / 2, this.size[1] / 2]): void {
    const scale = Math.min(Math.max(this.scale * factor, Math.min(LEAST, this.scale)), MOST);
    this.x = at[0] - ((at[0] - this.x) * scale) / this.scale;
    this.z = at[1] - ((at[1] - this.z) * scale) / this.scale;
    this.scale = scale;
    this.moved = true;
    this.changed();
  }

  pan(dx: number, dz: number): void {
    this.x += dx;
    this.z += dz;
    this.moved = true;
    this.changed();
  }

  /** The part of the world that is shown: least and largest x and z, m. */
  get shown(): [Point, Point] {
    return [this.at([0, this.size[1]]), this.at([this.size[0], 0])];
  }

  to([x, z]: Point): Point {
    return [this.x + this.scale * x, this.z - this.scale * z];
  }

  /** The place in the world at a pixel. */
  at([x, z]: Point): Point {
    return [(x - this.x) / this.scale, (this.z - z) / this.scale];
  }
}

/**
 * Lets people move the view: wheel and pinch zoom, drag pans, double click fits. Within another page, the plain wheel and a finger
 * that goes up or down scroll that page, as they do beside the picture; Ctrl and the wheel zoom.
 */
export function steerView(canvas: HTMLCanvasElement, view: View): void {
  const fingers = new Map<number, Point>();
  const within = window.top !== window;
  if (within) canvas.style.touchAction = "pan-y";
  const here = (event: MouseEvent): Point => [event.offsetX, event.offsetY];
  canvas.addEventListener(
    "wheel",
    (event) => {
      if (within && !event.ctrlKey) return;
      event.preventDefault();
      view.zoom(Math.exp(-event.deltaY * 0.0015), here(event));
    },
    { passive: false },
  );
  canvas.addEventListener("dblclick", () => view.fit());
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, here(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const now = here(event);
    const other = [...fingers].find(([id]) => id !== event.pointerId)?.[1];
    if (other) {
      const span = (a: Point): number => Math.max(Math.hypot(a[0] - other[0], a[1] - other[1]), 1);
      view.zoom(span(now) / span(before), other);
    } else {
      view.pan(now[0] - before[0], now[1] - before[1]);
    }
    fingers.set(event.pointerId, now);
  });
  for (const end of ["pointerup", "pointercancel"] as const) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
}

/** Farthest that a pointer may move in a click, pixels. */
const CLICK = 4;

/** Tells the place of each click on the canvas, which is no drag. */
export function clickedPlaces(canvas: HTMLCanvasElement, view: View, tell: (place: Point) => void): void {
  let down: Point = [0, 0];
  canvas.addEventListener("pointerdown", (event) => (down = [event.offsetX, event.offsetY]));
  canvas.addEventListener("click", (event) => {
    const moved = Math.hypot(event.offsetX - down[0], event.offsetY - down[1]);
    if (moved <= CLICK) tell(view.at([event.offsetX, event.offsetY]));
  });
}
