/** The bar above the picture: mode, clock, pace; and the marks in the picture's corners. */

import { button, make } from "./elements";
import type { Description, Mode, Pace } from "./messages";
import { palette, scaleColour } from "./palette";
import type { View } from "./view";

/** Speeds of the clock, and further ones of a run that is only looked at. */
const SPEEDS = [0.1, 0.25, 0.5, 1, 2];
const FASTER = [5, 10];

const MODES: [Mode, string][] = [
  ["tip", "One stick moves the tip (key 1)"],
  ["lever", "One lever per cylinder (key 2)"],
  ["height", "Levers, and the telescope holds the height of the tip (key 3)"],
];

export type Clock = "runs" | "paused" | "ended";

interface Actions {
  mode: (mode: Mode) => void;
  pause: () => void;
  reset: () => void;
  speed: (speed: number) => void;
  theme: () => void;
}

export class Bar {
  private readonly modes: [Mode, HTMLButtonElement][];
  private readonly pause: HTMLButtonElement;
  private readonly name = make("small", { id: "machine-name" });
  private readonly badge = make("span", { id: "pace" });

  /** `looks`: at a run, nobody drives. */
  constructor(room: HTMLElement, act: Actions, looks: boolean) {
    this.modes = MODES.map(([mode, title]) => {
      const made = button(mode, title, () => act.mode(mode));
      made.value = mode;
      return [mode, made];
    });
    const group = make("div", { id: "modes" }, ...this.modes.map(([, made]) => made));
    group.setAttribute("role", "group");
    group.setAttribute("aria-label", "Mode");
    const speed = make("select", { id: "speed", title: "Speed of the clock" });
    speed.setAttribute("aria-label", "Speed of the clock");
    [...SPEEDS, ...(looks ? FASTER : [])].forEach((s) => speed.add(new Option(`clock ${s} ×`, String(s), s === 1, s === 1)));
    speed.addEventListener("change", () => {
      speed.blur();
      act.speed(Number(speed.value));
    });
    this.pause = button("Pause", "Stop the clock (key P)", act.pause);
    this.pause.id = "pause";
    const reset = button("↺ Reset", "Back to the start, at rest (key 0)", act.reset);
    reset.id = "reset";
    room.append(
      make("h1", {}, "hydrocrane", this.name),
      group,
      this.pause,
      reset,
      speed,
      this.badge,
      button("◐", "Light or dark", act.theme, "theme"),
    );
    this.clock("runs");
  }

  clock(state: Clock): void {
    this.pause.textContent = { runs: "❚❚ Pause", paused: "▶ Go on", ended: "■ Ended" }[state];
    this.pause.disabled = state === "ended";
    document.body.classList.toggle("paused", state !== "runs");
  }

  machine({ machine, controllers, controller }: Description): void {
    this.name.textContent = machine.name;
    document.title = `${machine.name} · hydrocrane cockpit`;
    for (const [mode, made] of this.modes) {
      made.hidden = !controllers.includes(mode);
      made.setAttribute("aria-pressed", String(mode === controller));
    }
  }

  /** `doing` stands before how fast it goes; a clock that stands has no pace. */
  pace(pace: Pace, state: Clock, doing: string): void {
    const goes = pace.factor === null ? "…" : `${pace.factor.toFixed(2)} × real time`;
    const slow = pace.slow && state === "runs";
    const lost = pace.lost >= 0.1 ? ` · ${pace.lost.toFixed(1)} s given up` : "";
    const text = doing + (state === "runs" ? `${slow ? "too slow a computer: " : ""}${goes}` : state) + lost;
    if (this.badge.textContent !== text) this.badge.textContent = text;
    this.badge.classList.toggle("slow", slow);
    this.badge.title = `Computing takes ${(100 * pace.load).toFixed(0)} % of the time. Time is given up where the computer is too slow or the page asleep.`;
  }
}

export function addViewButtons(room: HTMLElement, view: View): void {
  room.append(
    button("+", "Zoom in", () => view.zoom(1.25)),
    button("−", "Zoom out", () => view.zoom(0.8)),
    button("⤢", "Show everything", () => view.fit()),
  );
}

/** Buttons that stay pressed while what they stand for holds. */
export interface Switches {
  aim: HTMLButtonElement;
  precise: HTMLButtonElement;
}

export function addDriveButtons(room: HTMLElement, act: { aim: () => void; precise: () => void }): Switches {
  const aim = button("⌖", "Go to a point: click it (key G)", act.aim);
  const precise = button("¼", "Precision: a quarter of the speed (key X)", act.precise);
  room.append(aim, precise);
  return { aim, precise };
}

export function showLegend(room: HTMLElement): void {
  const colours = palette();
  const bar = make("span", { className: "scale" });
  for (let i = 0; i <= 10; i++) {
    const step = make("i");
    step.style.background = scaleColour(i / 10);
    bar.append(step);
  }
  const key = (colour: string, text: string): HTMLElement => {
    const mark = make("i", { className: "mark" });
    mark.style.background = colour;
    return make("span", {}, mark, text);
  };
  room.replaceChildren(
    make("span", {}, "oil pressure 0", bar, "supply"),
    key(colours.actual, "velocity of the tip"),
    key(colours.wanted, "asked by the stick"),
    key(colours.limit, "limit reached"),
    key(colours.reachEdge, "within reach"),
    key(colours.forbiddenEdge, "keep out"),
  );
}
