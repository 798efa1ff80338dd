/** What steers the crane: on-screen sticks, keyboard, gamepad. Whatever is moved farthest on an axis counts. */

import { readGamepad, type Pad } from "./gamepad";

export interface Axis {
  name: string;
  /** Key of each end: towards -1, towards 1. */
  keys: [string, string];
}

/** Keys for the stick that moves the tip, and for levers from the first cylinder on. */
const TIP_KEYS: Record<string, [string, string]> = { x: ["ArrowLeft", "ArrowRight"], z: ["ArrowDown", "ArrowUp"] };
const LEVER_KEYS: [string, string][] = [
  ["KeyA", "KeyQ"],
  ["KeyS", "KeyW"],
  ["KeyD", "KeyE"],
  ["KeyF", "KeyR"],
  ["KeyG", "KeyT"],
  ["KeyH", "KeyY"],
];
/** Share of the deflection that a key gives with Shift held. */
const FINE = 0.3;

const SHOWN: Record<string, string> = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓" };
export const keyName = (code: string): string => SHOWN[code] ?? code.replace(/^Key/, "");

export class Sticks {
  private axes: Axis[] = [];
  private touched: number[] = [];
  private readonly keys = new Set<string>();
  private fine = false;
  private knobs: { put: (values: number[]) => void }[] = [];
  pad: Pad | null = null;

  constructor(private readonly room: HTMLElement) {
    window.addEventListener("keydown", (event) => this.press(event, true));
    window.addEventListener("keyup", (event) => this.press(event, false));
    // Whoever looks elsewhere does not hold a stick.
    window.addEventListener("blur", () => this.letGo());
    document.addEventListener("visibilitychange", () => document.hidden && this.letGo());
  }

  /** Sticks for these axes: one pad for x and z, else a lever each. */
  show(names: string[]): void {
    this.letGo();
    const tip = names.length === 2 && names[0] === "x" && names[1] === "z";
    this.axes = names.map((name, i) => ({
      name,
      keys: (tip ? TIP_KEYS[name] : undefined) ?? LEVER_KEYS[i % LEVER_KEYS.length]!,
    }));
    this.touched = names.map(() => 0);
    this.room.replaceChildren();
    this.knobs = tip ? [this.addPad()] : names.map((_, i) => this.addLever(i));
    this.room.append(this.help(tip));
  }

  private help(tip: boolean): HTMLElement {
    const ends = [1, 0].map((end) => this.axes.map(({ keys }) => keyName(keys[end]!)).join(" "));
    const lines = [
      [tip ? "Drag the stick: the tip goes where it points." : "Drag the levers: up moves a piston out.", ""],
      ["Let go, and the valves close.", ""],
      [`Keys: ${tip ? "the arrows" : `${ends[0]} out, ${ends[1]} in`}; with Shift a third as fast.`, "keys"],
      ["1 tip, 2 lever, P pause, 0 reset.", "keys"],
    ] as const;
    const help = document.createElement("div");
    help.className = "help";
    lines.forEach(([line, kind]) => {
      const row = document.createElement("p");
      row.className = kind;
      row.textContent = line;
      help.append(row);
    });
    return help;
  }

  letGo(): void {
    this.keys.clear();
    this.touched.fill(0);
  }

  /** Deflections now, -1 to 1. */
  read(): number[] {
    const pad = readGamepad(this.axes.map((axis) => axis.name));
    this.pad = pad;
    const held = this.axes.map((axis, i) => {
      const [less, more] = axis.keys;
      const key = (Number(this.keys.has(more)) - Number(this.keys.has(less))) * (this.fine ? FINE : 1);
      const wishes = [this.touched[i] ?? 0, key, pad?.axes[i] ?? 0];
      return wishes.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
    });
    this.knobs.forEach((knob) => knob.put(held));
    return held;
  }

  private press(event: KeyboardEvent, down: boolean): void {
    this.fine = event.shiftKey;
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) {
      if (!down) this.keys.delete(event.code);
      return;
    }
    if (!this.axes.some((axis) => axis.keys.includes(event.code))) return;
    event.preventDefault();
    if (down) this.keys.add(event.code);
    else this.keys.delete(event.code);
  }

  /** A pad with a knob: sideways is the first axis, up the second. */
  private addPad(): { put: (values: number[]) => void } {
    const [pad, knob] = this.frame("pad", "Stick: drag it, or use the arrow keys");
    const [x, z] = [this.axes[0]!, this.axes[1]!];
    this.mark(pad, [
      ["left", keyName(x.keys[0])],
      ["right", keyName(x.keys[1])],
      ["top", keyName(z.keys[1])],
      ["bottom", keyName(z.keys[0])],
    ]);
    this.drag(pad, (across, up) => {
      const length = Math.max(Math.hypot(across, up), 1);
      this.touched = [across / length, up / length];
    });
    return { put: (values) => place(knob, values[0] ?? 0, values[1] ?? 0) };
  }

  private addLever(index: number): { put: (values: number[]) => void } {
    const axis = this.axes[index]!;
    const [lever, knob] = this.frame("lever", `Lever of ${axis.name}`);
    const title = document.createElement("span");
    title.className = "axis";
    title.textContent = axis.name;
    lever.after(title);
    this.mark(lever, [
      ["top", keyName(axis.keys[1])],
      ["bottom", keyName(axis.keys[0])],
    ]);
    this.drag(lever, (_, up) => {
      this.touched[index] = up;
    });
    return { put: (values) => place(knob, 0, values[index] ?? 0) };
  }

  private frame(kind: string, label: string): [HTMLElement, HTMLElement] {
    const holder = document.createElement("div");
    holder.className = "stick";
    const body = document.createElement("div");
    body.className = kind;
    body.setAttribute("role", "slider");
    body.setAttribute("aria-label", label);
    body.setAttribute("aria-valuenow", "0");
    const knob = document.createElement("div");
    knob.className = "knob";
    body.append(knob);
    holder.append(body);
    this.room.append(holder);
    return [body, knob];
  }

  private mark(body: HTMLElement, marks: [string, string][]): void {
    for (const [side, text] of marks) {
      const key = document.createElement("kbd");
      key.className = side;
      key.textContent = text;
      body.append(key);
    }
  }

  /** Shares from -1 to 1, across and up, while a finger or the mouse holds the body; centred when it lets go. */
  private drag(body: HTMLElement, move: (across: number, up: number) => void): void {
    const bounded = (value: number): number => Math.min(Math.max(value, -1), 1);
    const follow = (event: PointerEvent): void => {
      if (!body.hasPointerCapture(event.pointerId)) return;
      const box = body.getBoundingClientRect();
      const reach = 0.38;
      const across = (event.clientX - box.left - box.width / 2) / (box.width * reach);
      const up = -(event.clientY - box.top - box.height / 2) / (box.height * reach);
      move(bounded(across), bounded(up));
    };
    body.addEventListener("pointerdown", (event) => {
      body.setPointerCapture(event.pointerId);
      follow(event);
    });
    body.addEventListener("pointermove", follow);
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"] as const) {
      body.addEventListener(end, () => move(0, 0));
    }
  }
}

function place(knob: HTMLElement, across: number, up: number): void {
  knob.style.left = `${50 + 38 * across}%`;
  knob.style.top = `${50 - 38 * up}%`;
  knob.classList.toggle("held", across !== 0 || up !== 0);
  knob.parentElement?.setAttribute("aria-valuenow", (up || across).toFixed(2));
}
