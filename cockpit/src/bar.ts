/** The bar above the picture: mode, clock, files, pace; the buttons beside the sticks; the legend. */

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
  save: () => void;
  replay: () => void;
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
    const reset = button("↺", "Back to the start, at rest (key 0)", act.reset);
    reset.append(word("Reset"));
    reset.id = "reset";
    reset.removeAttribute("aria-label");
    const save = button("Save", "Save this drive since the last reset as a scenario, which hydrocrane simulate repeats", act.save, "files");
    const replay = button("Replay …", "Replay a saved drive or another scenario; choose its machine file and its logs with it, or drop them here", act.replay, "files");
    room.append(
      make("h1", {}, "hydrocrane", this.name),
      group,
      this.pause,
      reset,
      speed,
      save,
      replay,
      this.badge,
      button("◐", "Light or dark", act.theme, "theme"),
    );
    this.clock("runs");
  }

  clock(state: Clock): void {
    const [mark, text] = { runs: ["❚❚", "Pause"], paused: ["▶", "Continue"], ended: ["■", "Ended"] }[state] as [string, string];
    this.pause.replaceChildren(mark, word(text));
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
    const lost = pace.lost >= 0.1 ? ` · ${pace.lost.toFixed(1)} s lost` : "";
    const text = doing + (state === "runs" ? `${slow ? "this computer is too slow: " : ""}${goes}` : state) + lost;
    if (this.badge.textContent !== text) this.badge.textContent = text;
    this.badge.classList.toggle("slow", slow);
    // Nothing that a telephone has to show.
    this.badge.classList.toggle("minor", !slow && !doing && pace.lost < 1 && state === "runs");
    this.badge.title = `The simulation takes ${(100 * pace.load).toFixed(0)} % of the time. Time is lost when the computer is too slow or the page is hidden.`;
  }
}

export function addViewButtons(room: HTMLElement, view: View): void {
  room.append(
    button("+", "Zoom in", () => view.zoom(1.25)),
    button("−", "Zoom out", () => view.zoom(0.8)),
    button("⤢", "Show everything", () => view.fit()),
  );
}

/** Text of a button that has a mark too; telephones show the mark alone. */
const word = (text: string): HTMLElement => make("span", { className: "word" }, ` ${text}`);

/** The buttons beside the sticks. Two stay pressed while what they stand for holds. */
export interface Switches {
  grip: HTMLButtonElement;
  aim: HTMLButtonElement;
  precise: HTMLButtonElement;
}

export function addDriveButtons(room: HTMLElement, act: { grip: () => void; aim: () => void; precise: () => void }): Switches {
  const grip = button("Grip", "Close the grapple round the log at the ring, or open it (Space)", act.grip);
  const precise = button("Slow ¼", "A quarter of the speed (key X, or hold Shift)", act.precise);
  const aim = button("Go to …", "Then click in the picture: the tip moves there (key G)", act.aim);
  [grip.id, precise.id, aim.id] = ["grip", "slow", "aim"];
  room.append(grip, precise, aim);
  return { grip, aim, precise };
}

/** What telephones have no room for. */
function minor(shown: HTMLElement): HTMLElement {
  shown.classList.add("minor");
  return shown;
}

/** Lengths of the scale bar, m, and the width that it may have, pixels. */
const LENGTHS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50];
const WIDEST = 110;

/** A bar as long as so many metres of the picture, `scale` pixels per metre. */
export function showScale(scale: number): void {
  const bar = document.getElementById("scale-bar");
  if (!bar) return;
  const length = LENGTHS.findLast((metres) => metres * scale <= WIDEST) ?? LENGTHS[0]!;
  bar.style.width = `${length * scale}px`;
  bar.nextSibling!.textContent = length < 1 ? `${length * 100} cm` : `${length} m`;
}

export function showLegend(room: HTMLElement, scale: number): void {
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
    make("span", { id: "scale" }, make("i", { id: "scale-bar" }), ""),
    make("span", {}, "oil 0", bar, "supply"),
    key(colours.actual, "velocity of the tip"),
    key(colours.wanted, "requested"),
    ...[key(colours.limit, "at its limit"), key(colours.reachEdge, "reachable"), key(colours.forbiddenEdge, "keep out")].map(minor),
  );
  showScale(scale);
}
