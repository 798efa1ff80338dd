/** Gamepads and joysticks: which of their axes moves what, kept in the browser. */

export interface Mapping {
  /** Name of the device, empty for any. */
  device: string;
  /** Axis of the device, or -1 for none. */
  axis: number;
  inverted: boolean;
}

/** Play of a stick around its centre that counts for nothing. */
const PLAY = 0.08;
/** Axes of a device that are offered at most. */
const MOST_AXES = 16;

/** Up is negative on gamepads. The first stick moves the tip; levers take the sticks' axes in turn. */
const USUAL: Record<string, Omit<Mapping, "device">> = {
  x: { axis: 0, inverted: false },
  z: { axis: 1, inverted: true },
};
const USUAL_LEVERS = [1, 3, 0, 2];

const storeKey = (name: string): string => `hydrocrane.gamepad.${name}`;

export function mapping(name: string, index: number): Mapping {
  const usual = { device: "", ...(USUAL[name] ?? { axis: USUAL_LEVERS[index] ?? -1, inverted: true }) };
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(storeKey(name)) ?? "null");
    return isMapping(kept) ? { ...usual, ...kept } : usual;
  } catch {
    return usual;
  }
}

export function keepMapping(name: string, chosen: Mapping): void {
  try {
    localStorage.setItem(storeKey(name), JSON.stringify(chosen));
  } catch {
    // A browser without storage keeps nothing.
  }
}

function isMapping(value: unknown): value is Mapping {
  const it = value as Mapping | null;
  if (typeof it !== "object" || it === null || typeof (it.device ?? "") !== "string") return false;
  return Number.isInteger(it.axis) && it.axis < MOST_AXES && typeof it.inverted === "boolean";
}

export interface Device {
  /** Its own name, with a number where there are several of it. */
  name: string;
  axes: readonly number[];
}

/** The devices that are there. Polled anew each time, so that one that is pulled out is gone at once. */
export function devices(): Device[] {
  const pads = (navigator.getGamepads?.() ?? []).filter((pad): pad is Gamepad => pad?.connected === true);
  return pads.map(({ id, axes }, i) => {
    const twins = pads.slice(0, i).filter((other) => other.id === id).length;
    return { name: twins ? `${id} (${twins + 1})` : id, axes: axes.slice(0, MOST_AXES) };
  });
}

/** Deflection of each of the named sticks; of several devices the one that is moved farthest counts. */
export function readDevices(names: string[], found = devices()): number[] {
  return names.map((name, index) => {
    const { device, axis, inverted } = mapping(name, index);
    const raw = found.filter((one) => !device || one.name === device).map((one) => one.axes[axis] ?? 0);
    const farthest = raw.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
    const beyond = (Math.sign(farthest) * Math.max(Math.abs(farthest) - PLAY, 0)) / (1 - PLAY);
    return Math.min(Math.max(inverted ? -beyond : beyond, -1), 1);
  });
}
