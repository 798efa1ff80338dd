// Drives the compiled core without a page: node drive.mjs CORE.wasm < plan.json
// The plan is { request, moves: [{ request, axes, mass, ticks }] }; answers { description, rows, saved, seconds }.
import { readFileSync } from "node:fs";
import { load } from "./core.mjs";

const { core, text, row, open } = await load(process.argv[2]);
const plan = JSON.parse(readFileSync(0, "utf8"));
const description = open(plan.request);
if (description.error) {
  console.log(JSON.stringify(description));
  process.exit(0);
}
const rows = [row()];
let seconds = 0;
for (const { request, axes = [], mass, ticks } of plan.moves) {
  if (request) open({ ...plan.request, ...request, "keep-state": true });
  axes.forEach((deflection, axis) => core.steer(axis, deflection));
  if (mass !== undefined) core.carry(mass);
  const began = performance.now();
  core.advance(ticks);
  seconds += (performance.now() - began) / 1000;
  rows.push(row());
}
core.save();
const numbers = rows.map((row) => Array.from(row));
console.log(JSON.stringify({ description, rows: numbers, saved: text(), seconds }));
