// Half an hour of driving without a page: node soak.mjs CORE.wasm [MINUTES]
// Tells how fast it goes, whether memory grows after the first minutes, and the tip's largest way in a millisecond.
import { load } from "./core.mjs";

const { core, row, open } = await load(process.argv[2]);
const minutes = Number(process.argv[3] ?? 30);
const request = { machine: "rottne-f9-lab", "full-speed": 0.3, ramp: 0.15, "real-sensors": true };
const { signals } = open(request);
const [x, z] = ["tip.x", "tip.z"].map((name) => signals.findIndex((signal) => signal.name === name));
const tip = () => {
  const now = row();
  return [now[x], now[z]];
};

const memory = [];
let [largest, seconds, before] = [0, 0, tip()];
for (let minute = 0; minute < minutes; minute++) {
  for (let half = 0; half < 120; half++) {
    // Sticks that change with every sample are the most that a drive can have to remember.
    for (let sample = 0; sample < 50; sample++) {
      const phase = (minute * 120 + half) * 0.11 + sample * 0.01;
      core.steer(0, Math.sin(phase));
      core.steer(1, Math.sin(1.7 * phase + 1));
      const began = performance.now();
      if (core.advance(10) !== 1) throw new Error("the drive ended");
      seconds += (performance.now() - began) / 1000;
      const now = tip();
      largest = Math.max(largest, Math.hypot(now[0] - before[0], now[1] - before[1]) / 10);
      before = now;
    }
    core.events();
  }
  // Somebody resets now and then, and changes a knob in between.
  if (minute % 5 === 4) before = (open(request), tip());
  else if (minute % 5 === 2) open({ ...request, friction: 1.2, "keep-state": true });
  memory.push(core.memory.buffer.byteLength / 2 ** 20);
}
console.log(`${minutes} min driven in ${seconds.toFixed(0)} s: ${((60 * minutes) / seconds).toFixed(0)} times real time`);
console.log(`memory after each minute, MiB: ${memory.map((m) => m.toFixed(1)).join(" ")}`);
console.log(`largest way of the tip: ${(1e3 * largest).toFixed(3)} mm per ms`);
const settled = memory[Math.min(9, memory.length - 1)];
if (memory.at(-1) > settled + 1 || !(largest < 2e-3)) process.exit(1);
