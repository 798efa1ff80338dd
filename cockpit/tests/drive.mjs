// Drives the compiled core without a page: node drive.mjs CORE.wasm < plan.json
// The plan is { request, moves: [{ request, axes, mass, ticks }] }; answers { description, rows, saved, seconds }.
import { readFileSync } from "node:fs";

const { instance } = await WebAssembly.instantiate(readFileSync(process.argv[2]), {});
const core = instance.exports;
const text = () =>
  JSON.parse(new TextDecoder().decode(new Uint8Array(core.memory.buffer, core.text_at(), core.text_length())));
const row = () => {
  const length = core.frame();
  return Array.from(new Float64Array(core.memory.buffer, core.frame_at(), length));
};

const plan = JSON.parse(readFileSync(0, "utf8"));
const open = (request) => {
  const bytes = new TextEncoder().encode(JSON.stringify(request));
  // Asking for room can move the memory.
  const room = core.input(bytes.length);
  new Uint8Array(core.memory.buffer, room, bytes.length).set(bytes);
  core.open();
  return text();
};
core.start();
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
console.log(JSON.stringify({ description, rows, saved: text(), seconds }));
