/** What the picture says in numbers, and what it cannot show: what the ground carries. */

import { make } from "./elements";
import { GROUND, type Logs } from "./logs";
import type { Description, Point } from "./messages";
import { limitOf, type Reader } from "./picture";

/** What telephones leave to the charts. */
const MINOR = new Set(["pump", "work"]);

/** Shows the numbers, where they are others than before. */
export function showReadout(room: HTMLElement, description: Description, read: Reader, pads: string[]): void {
  const speed = Math.hypot(read("tip.vx"), read("tip.vz"));
  const entries: [string, string][] = [
    ["time", `${read("time").toFixed(1)} s`],
    ["tip", `${read("tip.x").toFixed(3)}, ${read("tip.z").toFixed(3)} m`],
    ["speed", `${speed.toFixed(2)} m/s`],
    ["pump", `${(read("supply.power") / 1000).toFixed(2)} kW`],
    ["work", `${(read("ledger.supply") / 1000).toFixed(1)} kJ`],
  ];
  for (const joint of description.joints) {
    const limit = limitOf(joint, read(`joint.${joint.name}.q`));
    if (limit) entries.push([`${joint.name} at its limit`, limit]);
  }
  if (pads.length) entries.push(["gamepad", pads.map((name) => name.slice(0, 24)).join(", ")]);
  const text = entries.flat().join("\n");
  if (room.dataset["shown"] === text) return;
  room.dataset["shown"] = text;
  room.replaceChildren(...entries.map(([name, value]) => make("span", { className: MINOR.has(name) ? "minor" : "" }, make("small", {}, name), make("b", {}, value))));
}

/** What carries at this instant, and where nothing does though the picture shows something. */
export function groundNote(logs: Logs, read: Reader): string {
  const tip: Point = [read("tip.x"), read("tip.z")];
  const place = logs.ground.within(tip);
  if (place && place !== GROUND) return `The tip is inside the ${place}: the model has no contact there.`;
  if (place && !logs.ground.carries) return "The tip is below the ground: in this drive the ground carries no load.";
  const carried = read("tip.contact.z");
  return carried > LIGHT ? `The ground carries ${(carried / 1000).toFixed(1)} kN.` : "";
}

/** Force below which the ground counts as carrying nothing, N. */
const LIGHT = 50;
