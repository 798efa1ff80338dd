/** Gamepads and joysticks: which of their axes moves what, and which of their buttons does what, kept in the browser. */

/** A part of a device: `device` is its name, empty for any, and `index` that of the axis or button, or -1 for none. */
export interface Part {
  device: string;
  index: number;
}

export interface Mapping extends Part {
  inverted: boolean;
}

/** What buttons do. */
export const ACTIONS = {
  grip: "Grip or let go",
  slow: "Slow, while held",
  mode: "Tip, levers, height in turn",
  pause: "Pause",
  reset: "Reset",
} as const;
export type Action = keyof typeof ACTIONS;

/** Play of a stick around its centre that counts for nothing. */
const PLAY = 0.08;
/** Axes and buttons of a device that are offered at most. */
const MOST_AXES = 16;
const MOST_BUTTONS = 32;
/** Deflection by which somebody shows the axis that is meant. */
const MEANT = 0.6;

/** Up is negative on gamepads. The first stick moves the tip; levers take the sticks' axes in turn. */
const USUAL: Record<string, Omit<Mapping, "device">> = {
  x: { index: 0, inverted: false },
  z: { index: 1, inverted: true },
};
const USUAL_LEVERS = [1, 3, 0, 2];
/** Buttons of the usual gamepad: A, B, Y, start, back. */
const USUAL_BUTTONS: Record<Action, number> = { grip: 0, slow: 1, mode: 3, pause: 9, reset: 8 };

function kept(name: string): unknown {
  try {
    return JSON.parse(localStorage.getItem(`hydrocrane.gamepad.${name}`) ?? "null");
  } catch {
    return null;
  }
}

export function keep(name: string, chosen: Part): void {
  try {
    localStorage.setItem(`hydrocrane.gamepad.${name}`, JSON.stringify(chosen));
  } catch {
    // A browser without storage keeps nothing.
  }
}

function isPart(value: unknown, most: number): value is Part {
  const it = value as Part | null;
  return typeof it === "object" && it !== null && typeof it.device === "string" && Number.isInteger(it.index) && it.index < most;
}

export function mapping(name: string, place: number): Mapping {
  const usual = { device: "", ...(USUAL[name] ?? { index: USUAL_LEVERS[place] ?? -1, inverted: true }) };
  const found = kept(`axis.${name}`);
  return isPart(found, MOST_AXES) && typeof (found as Mapping).inverted === "boolean" ? (found as Mapping) : usual;
}

export function buttonOf(action: Action): Part {
  const found = kept(`button.${action}`);
  return isPart(found, MOST_BUTTONS) ? found : { device: "", index: USUAL_BUTTONS[action] };
}

export interface Device {
  /** Its own name, with a number where there are several of it. */
  name: string;
  axes: readonly number[];
  buttons: readonly boolean[];
}

/** The devices that are there. Polled anew each time, so that one that is pulled out is gone at once. */
export function devices(): Device[] {
  const pads = (navigator.getGamepads?.() ?? []).filter((pad): pad is Gamepad => pad?.connected === true);
  return pads.map(({ id, axes, buttons }, i) => {
    const twins = pads.slice(0, i).filter((other) => other.id === id).length;
    const pressed = buttons.slice(0, MOST_BUTTONS).map((button) => button.pressed);
    return { name: twins ? `${id} (${twins + 1})` : id, axes: axes.slice(0, MOST_AXES), buttons: pressed };
  });
}

const meant = (found: Device[], { device }: Part): Device[] => found.filter((one) => !device || one.name === device);

/** Deflection of each of the named sticks; of several devices the one that is moved farthest counts. */
export function readDevices(names: string[], found = devices()): number[] {
  return names.map((name, place) => {
    const chosen = mapping(name, place);
    const raw = meant(found, chosen).map((one) => one.axes[chosen.index] ?? 0);
    const farthest = raw.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
    const beyond = (Math.sign(farthest) * Math.max(Math.abs(farthest) - PLAY, 0)) / (1 - PLAY);
    return Math.min(Math.max(chosen.inverted ? -beyond : beyond, -1), 1);
  });
}

/** Tells which actions' buttons are down, and which have just been pressed. */
export class PadButtons {
  private before = new Set<Action>();

  read(found: Device[]): { down: Set<Action>; pressed: Action[] } {
    const all = found.length ? (Object.keys(ACTIONS) as Action[]) : [];
    const down = new Set(all.filter((action) => {
      const chosen = buttonOf(action);
      return meant(found, chosen).some(({ buttons }) => buttons[chosen.index]);
    }));
    const pressed = [...down].filter((action) => !this.before.has(action));
    this.before = down;
    return { down, pressed };
  }
}

/** The axis that is moved, or the button that is pressed, farthest since `before`; null while nothing is. */
export function moved(kind: "axis" | "button", before: Device[], found = devices()): Mapping | null {
  for (const { name, axes, buttons } of found) {
    const rest = before.find((one) => one.name === name);
    const values = kind === "axis" ? axes : buttons.map(Number);
    const index = values.findIndex((value, i) => Math.abs(value - Number((kind === "axis" ? rest?.axes : rest?.buttons)?.[i] ?? 0)) > MEANT);
    if (index < 0 || (kind === "button" && !values[index])) continue;
    return { device: found.length > 1 ? name : "", index, inverted: kind === "axis" && values[index]! < Number(rest?.axes[index] ?? 0) };
  }
  return null;
}
