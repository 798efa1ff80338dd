/** The panel of gamepads and joysticks: which axis moves what, which button does what. */

import { button, choice, make } from "./elements";
import { buttonOf, ACTIONS, devices, keep, mapping, moved, type Action, type Device, type Mapping, type Part } from "./gamepad";

/** Longest wait for somebody to move what is to be assigned, ms. */
const PATIENCE = 8000;
/** Axes and buttons offered where no device tells how many it has. */
const AXES = 4;
const BUTTONS = 12;

const TITLES: Record<string, string> = { x: "Tip, out and in", z: "Tip, up and down" };

/** Rows for each of the named sticks and for each button; `changed` after one was assigned by moving it. */
export function deviceRows(axes: string[], changed: () => void): HTMLElement[] {
  const found = devices();
  const names = found.map(({ name }) => name).join(", ") || "None found yet. Plug one in and press one of its buttons.";
  const about = "Select an axis or button, or press Assign and then move it: the direction of that motion is out or up.";
  return [
    make("p", { className: "hint" }, names),
    make("p", { className: "hint" }, about),
    ...axes.map((name, place) => axisRow(name, mapping(name, place), found, changed)),
    ...(Object.keys(ACTIONS) as Action[]).map((action) => row("button", `button.${action}`, ACTIONS[action], buttonOf(action), found, changed)),
  ];
}

function axisRow(name: string, chosen: Mapping, found: Device[], changed: () => void): HTMLElement {
  const inverted = make("input", { type: "checkbox", checked: chosen.inverted });
  inverted.addEventListener("change", () => {
    chosen.inverted = inverted.checked;
    keep(`axis.${name}`, chosen);
  });
  const made = row("axis", `axis.${name}`, TITLES[name] ?? `Lever of ${name}`, chosen, found, changed);
  made.append(make("label", {}, inverted, " reversed"));
  return made;
}

function row(kind: "axis" | "button", key: string, label: string, chosen: Part, found: Device[], changed: () => void): HTMLElement {
  const value = (device: string, index: number): string => JSON.stringify([device, index]);
  const text = (device: string, index: number): string => `${device ? `${device.slice(0, 24)}: ` : ""}${kind} ${index + 1}`;
  const options: [string, string][] = [[value("", -1), "none"]];
  const add = (device: string, count: number): void => {
    for (let index = 0; index < count; index++) options.push([value(device, index), text(device, index)]);
  };
  const count = (one: Device): number => (kind === "axis" ? one.axes : one.buttons).length;
  const least = kind === "axis" ? AXES : BUTTONS;
  add("", Math.max(found.length ? 0 : least, ...found.map(count), chosen.device ? 0 : chosen.index + 1));
  if (found.length > 1) found.forEach((one) => add(one.name, count(one)));
  const now = value(chosen.device, chosen.index);
  if (!options.some(([value]) => value === now)) options.push([now, text(chosen.device, chosen.index)]);
  const select = choice(label, options, now, (value) => {
    [chosen.device, chosen.index] = JSON.parse(value) as [string, number];
    keep(key, chosen);
  });
  return make("div", { className: "axis-row" }, select.room, assign(kind, key, label, changed));
}

/** A button that waits until somebody moves the axis, or presses the button, that is to be assigned. */
function assign(kind: "axis" | "button", key: string, label: string, changed: () => void): HTMLElement {
  const made = button("Assign", `Then ${kind === "axis" ? "move the axis" : "press the button"} for: ${label}`, () => {
    const [before, end] = [devices(), performance.now() + PATIENCE];
    made.textContent = kind === "axis" ? "Move it …" : "Press it …";
    const look = (): void => {
      const found = moved(kind, before);
      if (found) keep(key, found);
      if (!found && performance.now() < end && made.isConnected) return void requestAnimationFrame(look);
      made.textContent = "Assign";
      if (found) changed();
    };
    look();
  });
  return made;
}
