/** Gamepads and joysticks: which of their axes moves what, kept in the browser. */

export interface Pad {
  id: string;
  axes: number[];
}

export interface Mapping {
  /** Axis of the device, or -1 for none. */
  axis: number;
  inverted: boolean;
}

/** Play of a stick around its centre that counts for nothing. */
const PLAY = 0.08;

/** Up is negative on gamepads. The first stick moves the tip; levers take the sticks' axes in turn. */
const USUAL: Record<string, Mapping> = {
  x: { axis: 0, inverted: false },
  z: { axis: 1, inverted: true },
};
const USUAL_LEVERS = [1, 3, 0, 2];

const storeKey = (name: string): string => `hydrocrane.gamepad.${name}`;

export function mapping(name: string, index: number): Mapping {
  const usual = USUAL[name] ?? { axis: USUAL_LEVERS[index] ?? -1, inverted: true };
  try {
    const kept: unknown = JSON.parse(localStorage.getItem(storeKey(name)) ?? "null");
    return isMapping(kept) ? kept : usual;
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
  return typeof it === "object" && it !== null && Number.isInteger(it.axis) && typeof it.inverted === "boolean";
}

/** The first device that is there. Polled anew each time, so that one that is pulled out is gone at once. */
export function device(): Gamepad | null {
  return navigator.getGamepads?.().find((pad) => pad?.connected) ?? null;
}

export function readGamepad(names: string[]): Pad | null {
  const pad = device();
  if (!pad) return null;
  const axes = names.map((name, index) => {
    const { axis, inverted } = mapping(name, index);
    const raw = pad.axes[axis] ?? 0;
    const beyond = Math.sign(raw) * Math.max(Math.abs(raw) - PLAY, 0) / (1 - PLAY);
    return Math.min(Math.max(inverted ? -beyond : beyond, -1), 1);
  });
  return { id: pad.id, axes };
}
