/** Where a run that is looked at stands: a slider over its time, and what is known of it. */

import { button, make } from "./elements";
import type { Recording } from "./messages";

/** Steps of the slider. */
const STEPS = 1000;
/** Events listed at most. */
const LISTED = 30;

export class Timeline {
  private readonly slider = make("input", { type: "range", min: "0", max: String(STEPS), value: "0", id: "timeline" });
  private readonly label = make("output", { id: "timeline-time" });
  private held = false;

  constructor(
    room: HTMLElement,
    private readonly end: number,
    private readonly seek: (time: number) => void,
  ) {
    this.slider.setAttribute("aria-label", "Time of the run");
    this.slider.addEventListener("input", () => {
      this.held = true;
      this.seek((Number(this.slider.value) / STEPS) * this.end);
    });
    this.slider.addEventListener("change", () => (this.held = false));
    room.replaceChildren(this.slider, this.label);
  }

  show(time: number): void {
    if (!this.held) this.slider.value = String(Math.round((STEPS * time) / this.end));
    this.label.textContent = `${time.toFixed(2)} of ${this.end.toFixed(2)} s`;
  }
}

/** The panel of a run: what it is, how it ended, what happened on the way. */
export function aboutRun(run: Recording, machine: string, seek: (time: number) => void, data: () => void): HTMLElement[] {
  const lines = [run.title, machine, run.outcome, `simulated by ${run.source}`];
  const about = make("section", {}, make("h2", {}, "Run"), ...lines.map((line) => make("p", { className: "hint" }, line)));
  about.append(make("div", { className: "row" }, button("Data", "Save what the charts hold as CSV", data)));
  if (!run.events.length) return [about];
  // What makes the run doubtful is never left out for what merely happened.
  const listed = [...run.events.filter(([, , warning]) => warning), ...run.events.filter(([, , warning]) => !warning)];
  const events = listed.slice(0, LISTED).map(([time, text, warning]) => {
    const shown = `${warning ? "⚠ " : ""}${time.toFixed(2)} s: ${text}`;
    return button(shown, "Go there", () => seek(Math.max(time - 0.5, 0)), warning ? "event doubt" : "event");
  });
  return [about, make("section", {}, make("h2", {}, "What happened"), ...events)];
}
