// Drives plans with the compiled core: node random_drives.mjs CORE.wasm, a plan per line in, its course per line out.
// Plans and courses: crates/evidence/src/course.rs, which judges them as it judges the native core's.
import { createInterface } from "node:readline";
import { load } from "./core.mjs";

const [ROWS, PLACES, LONG] = [1000, 10, 0.5e-3];
let desk = await load(process.argv[2]);

/** One drive, tick by tick. */
function drive({ request, moves, followed }) {
  const { core, text, row, open } = desk;
  const description = open(request);
  if (description.error) return { refused: description.error.message, ...empty() };
  const signals = description.signals.map((signal) => signal.name);
  const course = { ...empty(), signals };
  const chambers = signals.flatMap((name, i) => (/\.p[12]$/.test(name) ? [i] : []));
  const [x, z] = ["tip.x", "tip.z"].map((name) => signals.indexOf(name));
  const last = moves.reduce((sum, move) => sum + move.ticks, 0);
  const see = (tick, end) => {
    const now = row().subarray(0, signals.length);
    if (!course.low.length) {
      [course.low, course.high] = [Array.from(now), Array.from(now)];
      course.peaks = chambers.map(() => now.slice());
    }
    chambers.forEach((at, chamber) => {
      if (now[at] > course.high[at] || Number.isNaN(now[at])) course.peaks[chamber] = now.slice();
    });
    for (let i = 0; i < signals.length; i++) {
      if (now[i] < course.low[i]) course.low[i] = now[i];
      if (now[i] > course.high[i]) course.high[i] = now[i];
    }
    if (tick % ROWS === 0 || end) course.rows.push(Array.from(now));
    if (tick % PLACES === 0 && tick <= followed) course.tip.push([now[x], now[z]]);
  };
  see(0, false);
  let tick = 0;
  for (const { ticks, deflections } of moves) {
    deflections.forEach((deflection, axis) => core.steer(axis, deflection));
    for (let i = 0; i < ticks; i++) {
      const began = performance.now();
      const goesOn = core.advance(1) === 1;
      timed(course.steps, (performance.now() - began) / 1000);
      tick += 1;
      see(tick, tick === last || !goesOn);
      if (tick === followed + 1 || (!goesOn && tick <= followed)) {
        core.save();
        course.saved = text().saved ?? null;
      }
      if (!goesOn) {
        core.events();
        return { ...course, peaks: course.peaks.map((peak) => Array.from(peak)), ended: text().ended };
      }
    }
  }
  return { ...course, peaks: course.peaks.map((peak) => Array.from(peak)) };
}

function empty() {
  const steps = { count: 0, total: 0, first: 0, worst: 0, long: 0 };
  return { signals: [], ended: null, rows: [], low: [], high: [], peaks: [], tip: [], saved: null, steps };
}

function timed(steps, seconds) {
  steps.count += 1;
  steps.total += seconds;
  if (steps.count === 1) {
    steps.first = seconds;
    return;
  }
  steps.worst = Math.max(steps.worst, seconds);
  steps.long += seconds > LONG ? 1 : 0;
}

for await (const line of createInterface({ input: process.stdin })) {
  let course;
  try {
    course = drive(JSON.parse(line));
  } catch (trap) {
    const ended = { kind: "trap", time: 0, message: String(trap) };
    course = { ...empty(), ended };
    desk = await load(process.argv[2]);
  }
  process.stdout.write(JSON.stringify(course) + "\n");
}
