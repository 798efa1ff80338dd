/** What steers the crane: on-screen sticks, keyboard, gamepad. Whatever is moved farthest on an axis counts. */

import { make } from "./elements";
import { devices, PadButtons, readDevices, type Action, type Device } from "./gamepad";
import { key, learnKeys } from "./keys";

interface Axis {
  name: string;
  /** Key of each end: towards -1, towards 1. */
  keys: [string, string];
}

/** Shows the deflections of all axes. */
type Show = (values: number[]) => void;

/** Keys for the stick that moves the tip, and for levers from the first cylinder on. */
const TIP_KEYS: Record<string, [string, string]> = { x: ["ArrowLeft", "ArrowRight"], z: ["ArrowDown", "ArrowUp"] };
const TIP_NAMES: Record<string, string> = { x: "Stick, out and in", z: "Stick, up and down" };
export const LEVER_KEYS: [string, string][] = [
  ["KeyA", "KeyQ"],
  ["KeyS", "KeyW"],
  ["KeyD", "KeyE"],
  ["KeyF", "KeyR"],
  ["KeyG", "KeyT"],
  ["KeyH", "KeyY"],
];
/** End of a lever to which an arrow key moves it while it has the focus. */
const ARROW_ENDS: Record<string, 0 | 1> = { ArrowDown: 0, ArrowLeft: 0, ArrowUp: 1, ArrowRight: 1 };
/** Share of the full speed that counts with Shift held or precision switched on. */
const PRECISE = 0.25;

export class Sticks {
  private axes: Axis[] = [];
  private touched: number[] = [];
  /** Key that is held, and what it stands for. */
  private readonly keys = new Map<string, string>();
  private fine = false;
  /** Whether precision is switched on. */
  precise = false;
  private shows: Show[] = [];
  private shown = "";
  pads: Device[] = [];
  private readonly buttons = new PadButtons();
  private slow = false;

  /** Sticks in `room`, what their keys do in `guide`. */
  constructor(
    private readonly room: HTMLElement,
    private readonly guide: HTMLElement,
    /** Told of each button of a gamepad that is pressed. */
    private readonly act: (action: Action) => void,
  ) {
    learnKeys(LEVER_KEYS.flat());
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
    this.shown = "";
    this.room.replaceChildren();
    this.shows = tip ? [this.addPad()] : names.map((_, i) => this.addLever(i));
    this.guide.querySelector(".help")?.remove();
    this.guide.append(this.help(tip));
  }

  private help(tip: boolean): HTMLElement {
    const line = (...parts: (Node | string)[]): HTMLElement => make("p", {}, ...parts);
    const row = (end: 0 | 1): (Node | string)[] => this.axes.flatMap(({ keys }) => [key("span", keys[end]), " "]);
    const moves = tip ? ["Arrow keys move the tip"] : [...row(1), "out, ", ...row(0), "in"];
    return make(
      "div",
      { className: "help" },
      line("Release ", tip ? "the stick" : "the levers", " and the valves close."),
      line(...moves, "; with Shift a quarter as fast."),
      line("Space grips a log or lets it go. ", ...(tip ? ["After G, click where the tip is to go; Esc stops it."] : [])),
      line("1 tip, 2 lever, 3 height, ", key("span", "KeyP"), " pause, 0 reset."),
    );
  }

  letGo(): void {
    this.keys.clear();
    this.touched.fill(0);
    this.fine = false;
  }

  /** Share of the full speed that counts. */
  get share(): number {
    return this.fine || this.precise || this.slow ? PRECISE : 1;
  }

  /** Deflections now, -1 to 1. */
  read(): number[] {
    this.pads = devices();
    const { down: buttons, pressed } = this.buttons.read(this.pads);
    this.slow = buttons.has("slow");
    pressed.forEach((action) => this.act(action));
    const pads = readDevices(this.axes.map((axis) => axis.name), this.pads);
    const down = new Set(this.keys.values());
    const held = this.axes.map((axis, i) => {
      const [less, more] = axis.keys;
      const byKey = Number(down.has(more)) - Number(down.has(less));
      const requested = [this.touched[i] ?? 0, byKey, pads[i] ?? 0];
      return requested.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
    });
    if (held.join() !== this.shown) this.shows.forEach((show) => show(held));
    this.shown = held.join();
    return held;
  }

  private press(event: KeyboardEvent, down: boolean): void {
    this.fine = event.shiftKey;
    if (!down) return void this.keys.delete(event.code);
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return;
    const lever = this.axes[Number(target.dataset["axis"] ?? -1)];
    const end = ARROW_ENDS[event.code];
    const code = lever && end !== undefined ? lever.keys[end] : event.code;
    if (!this.axes.some((axis) => axis.keys.includes(code))) return;
    event.preventDefault();
    this.keys.set(event.code, code);
  }

  /** A pad with a knob: sideways is the first axis, up the second. */
  private addPad(): Show {
    const [x, z] = [this.axes[0]!, this.axes[1]!];
    const body = make("div", { className: "pad", title: "Drag the stick, or use the arrow keys" });
    const [across, up] = [this.end(x, "horizontal"), this.end(z, "vertical")];
    body.append(across, up);
    this.mark(body, [
      ["left", x.keys[0]],
      ["right", x.keys[1]],
      ["top", z.keys[1]],
      ["bottom", z.keys[0]],
    ]);
    const knob = this.knob(body);
    drag(body, (x, z) => {
      const length = Math.max(Math.hypot(x, z), 1);
      this.touched = [x / length, z / length];
    });
    return ([x, z]) => {
      place(knob, x!, z!);
      tell(across, x!);
      tell(up, z!);
    };
  }

  private addLever(index: number): Show {
    const axis = this.axes[index]!;
    const body = this.end(axis, "vertical");
    body.className = "lever";
    body.dataset["axis"] = String(index);
    this.mark(body, [
      ["top", axis.keys[1]],
      ["bottom", axis.keys[0]],
    ]);
    const knob = this.knob(body);
    knob.parentElement!.after(make("span", { className: "axis" }, axis.name));
    drag(body, (_, up) => {
      this.touched[index] = up;
    });
    return (values) => {
      place(knob, 0, values[index]!);
      tell(body, values[index]!);
    };
  }

  /** One direction of a stick as assistive technology knows it. */
  private end(axis: Axis, orientation: string): HTMLElement {
    const made = make("div", { className: "end", tabIndex: 0 });
    const facts = { role: "slider", "aria-label": TIP_NAMES[axis.name] ?? `Lever of ${axis.name}`, "aria-orientation": orientation };
    Object.entries({ ...facts, "aria-valuemin": "-1", "aria-valuemax": "1" }).forEach(([name, value]) => made.setAttribute(name, value));
    tell(made, 0);
    return made;
  }

  private knob(body: HTMLElement): HTMLElement {
    const knob = make("div", { className: "knob" });
    body.append(knob);
    this.room.append(make("div", { className: "stick" }, body));
    return knob;
  }

  private mark(body: HTMLElement, marks: [string, string][]): void {
    for (const [side, code] of marks) {
      const shown = key("kbd", code);
      shown.className = side;
      shown.setAttribute("aria-hidden", "true");
      body.append(shown);
    }
  }
}

/** Shares from -1 to 1, across and up, while a finger or the mouse holds the body; centred when it lets go. */
function drag(body: HTMLElement, move: (across: number, up: number) => void): void {
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

function place(knob: HTMLElement, across: number, up: number): void {
  knob.style.left = `${50 + 38 * across}%`;
  knob.style.top = `${50 - 38 * up}%`;
  knob.classList.toggle("held", across !== 0 || up !== 0);
}

function tell(slider: HTMLElement, deflection: number): void {
  slider.setAttribute("aria-valuenow", deflection.toFixed(2));
  slider.setAttribute("aria-valuetext", `${(100 * deflection).toFixed(0)} %`);
}
