/** What the picture says in numbers, and what it cannot show: where nothing carries. */

import { make } from "./elements";
import { LINE, radius, type Logs } from "./logs";
import type { Description, Point } from "./messages";
import { limitOf, type Reader } from "./picture";

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
  room.replaceChildren(...entries.map(([name, value]) => make("span", {}, make("small", {}, name), make("b", {}, value))));
}

/** Laws know no contact: says so where the picture would show one. */
export function groundNote(logs: Logs, read: Reader): string {
  const tip: Point = [read("tip.x"), read("tip.z")];
  const place = logs.ground.within(tip);
  if (place === "ground") return "The tip is below the ground: the ground carries nothing in this model.";
  if (place) return `The tip is inside the ${place}: nothing carries or stops it there in this model.`;
  const payload = read("payload");
  const lowest = logs.support(tip[0]);
  const touches = payload > 0 && lowest !== null && tip[1] - LINE - 2 * radius(payload) < lowest - TOUCH;
  return touches ? "The log lies on, but what it lies on carries nothing in this model: its whole weight hangs on the tip." : "";
}

/** Depth below which a log counts as lying on something, m. */
const TOUCH = 0.005;
