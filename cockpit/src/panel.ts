/** The knobs beside the picture: load, pressure, friction, sensors, controller, machine, files. */

import { deviceRows } from "./devices";
import { button, choice, make, number, slider, type Knob, type Range } from "./elements";
import type { MachineKey } from "./file-keys";
import { fileInput } from "./files";
import { devices } from "./gamepad";
import { GHOSTS, type GhostName } from "./ghost";
import type { Description, Mode, Request } from "./messages";
import { TASKS, type Score, type TaskName } from "./tasks";

export interface Actions {
  /** Changes the drive at hand, which goes on from its state. */
  change: (changes: Partial<Request>) => void;
  /** Another machine. */
  open: (request: Request) => void;
  /** The log that lies there has this mass, kg. */
  weigh: (mass: number) => void;
  /** Back to the start with a load at the tip, kg. */
  load: (mass: number) => void;
  /** Files that somebody has chosen. */
  files: (files: Iterable<File>) => void;
  share: () => void;
  data: () => void;
  /** Back to the start with something to do, or nothing. */
  task: (task: TaskName | null) => void;
  /** Which earlier drive is shown beside the one at hand. */
  ghost: (ghost: GhostName) => void;
}

const MODES: Record<Mode, string> = {
  tip: "tip: one stick moves the tip",
  "heinze-pid": "heinze-pid: the controller of the thesis",
  lever: "lever: one axis per cylinder",
  height: "height: levers; the telescope holds the height",
};

/** What the page knows of the place that the panel does not: what there is to be done there. */
export interface Place {
  /** Whether a log lies, or could lie, on the ground. */
  ground: boolean;
  tasks: TaskName[];
}

export class Panel {
  /** Mass of the log, kg. */
  mass = 80;
  private task = "";
  private ghost: GhostName = "best";
  private readonly scores: Score[] = [];
  private readonly board = make("div", { id: "scores" });
  private description!: Description;
  private request!: Request;
  private place!: Place;
  /** What the knobs at hand are for: they stay while it is the same, and only show other values. */
  private shape = "";
  private showing: (() => void)[] = [];

  constructor(
    private readonly room: HTMLElement,
    private readonly act: Actions,
  ) {}

  show(description: Description, request: Request, place: Place): void {
    [this.description, this.request, this.place] = [description, request, place];
    const { machine, controller, controllers, axes, gains, sensors } = description;
    const names = gains.map(({ key }) => key);
    const shape = JSON.stringify([machine, controller, controllers, axes, names, sensors, place, devices().map(({ name }) => name)]);
    if (shape === this.shape) return this.showing.forEach((show) => show());
    this.shape = shape;
    this.build();
  }

  /** Other devices are there. */
  plugged(): void {
    if (this.shape) this.show(this.description, this.request, this.place);
  }

  /** Knobs for what is at hand; whichever of them somebody is at is so afterwards too. */
  private build(): void {
    const open = new Set([...this.room.querySelectorAll("details[open]")].map((d) => d.getAttribute("data-name")));
    const at = this.room.contains(document.activeElement) ? (document.activeElement as HTMLElement).dataset["key"] : undefined;
    this.showing = [];
    const parts = [
      this.machine(),
      this.cargo(),
      ...(this.place.tasks.length ? [this.tasks()] : []),
      this.plant(),
      this.control(open),
      this.device(open),
      this.files(),
    ];
    this.room.replaceChildren(...parts);
    [...this.room.querySelectorAll<HTMLElement>("[data-key]")].find((knob) => knob.dataset["key"] === at)?.focus();
  }

  /** A knob that shows what is in force. */
  private knob<T>(knob: Knob<T>, value: () => T): HTMLElement {
    this.showing.push(() => knob.set(value()));
    return knob.room;
  }

  private slider(label: string, range: Omit<Range, "value">, value: () => number, act: (value: number) => void): HTMLElement {
    const now = value();
    const most = now > range.most ? now : range.most;
    return this.knob(slider(label, { ...range, most, value: now }, act), value);
  }

  private override(key: MachineKey, value: number): void {
    this.act.change({ overrides: { [key]: value } });
  }

  private machine(): HTMLElement {
    const { machine, machines } = this.description;
    const bundled = machines.map(({ name }): [string, string] => [name, name]);
    const name = machine.source;
    const own: [string, string][] = this.request.text ? [[name, name]] : [];
    const file = fileInput("machine-file", this.act.files);
    return section(
      "Machine",
      this.knob(
        choice("Crane", [...own, ...bundled], name, (machine) => this.act.open({ machine })),
        () => this.description.machine.source,
      ),
      make("p", { className: "hint" }, machine.title),
      button("Open a machine file …", "Open a machine file from this computer, with the files that it extends; or drop it here", () => file.click()),
      file,
    );
  }

  private cargo(): HTMLElement {
    const show = (mass: number): string => `${mass.toFixed(0)} kg`;
    const weigh = (mass: number): void => {
      this.mass = mass;
      this.act.weigh(mass);
    };
    return section(
      "Load",
      slider(this.place.ground ? "Log" : "Mass", { least: 5, most: 300, step: 5, value: this.mass, show }, weigh).room,
      make(
        "div",
        { className: "row" },
        button("Start loaded", "Back to the start, with the load at the tip", () => this.act.load(this.mass)),
        button("Start empty", "Back to the start, with nothing at the tip", () => this.act.load(0)),
      ),
    );
  }

  private tasks(): HTMLElement {
    const offered = this.place.tasks.map((task): [string, string] => [task, TASKS[task]]);
    if (!this.place.tasks.some((task) => task === this.task)) this.task = "";
    return section(
      "Task",
      choice("Choose a task", [["", "none"], ...offered], this.task, (task) => {
        this.task = task;
        this.act.task(task ? (task as TaskName) : null);
      }).room,
      choice("Show as a ghost", Object.entries(GHOSTS) as [GhostName, string][], this.ghost, (ghost) => {
        this.ghost = ghost;
        this.act.ghost(ghost);
      }).room,
      this.board,
    );
  }

  /** Shows how a task was done beside how it was done in the other modes: the latest of each. */
  score(score: Score): void {
    const others = this.scores.filter(({ task, mode }) => task !== score.task || mode !== score.mode);
    this.scores.splice(0, this.scores.length, score, ...others);
    const cell = (text: string): HTMLElement => make("td", {}, text);
    const rows = this.scores.map(({ task, mode, time, worst, mean, work }) =>
      make(
        "tr",
        {},
        make("th", {}, `${task}, ${mode}`),
        cell(`${time.toFixed(1)} s`),
        cell(`${(1000 * worst).toFixed(0)} mm`),
        cell(`${(1000 * mean).toFixed(0)} mm`),
        cell(`${(work / 1000).toFixed(1)} kJ`),
      ),
    );
    const head = make("tr", {}, ...["", "time", "worst", "mean", "work"].map((text) => make("th", {}, text)));
    const about = "Worst and mean: distance from the path, or of the logs from the middle of the bunk. Work: of the pump.";
    this.board.replaceChildren(make("table", {}, head, ...rows), make("p", { className: "hint" }, about));
  }

  private plant(): HTMLElement {
    const bar = (pascal: number): string => `${(pascal / 1e5).toFixed(0)} bar`;
    const percent = (share: number): string => `${(100 * share).toFixed(0)} %`;
    const sensors: [string, string][] = [
      ["ideal", "ideal: exact values"],
      ["real", "real: errors of the data sheets"],
    ];
    const supply = { least: 40e5, most: 250e5, step: 5e5, show: bar };
    const friction = { least: 0, most: 3, step: 0.1, show: percent };
    const chosen = (): string => (this.request["real-sensors"] ? "real" : "ideal");
    const parts = [
      this.slider("Supply pressure", supply, () => this.description.supply, (value) => this.override("supply.pressure", value)),
      this.slider("Friction", friction, () => this.request.friction ?? 1, (value) => this.act.change({ friction: value })),
    ];
    if (this.description.sensors) {
      const act = (value: string): void => this.act.change({ "real-sensors": value === "real" });
      parts.push(this.knob(choice("Sensors", sensors, chosen(), act), chosen));
    }
    return section("Hydraulics and sensors", ...parts);
  }

  private control(open: Set<string | null>): HTMLElement {
    const { controllers, controller, gains } = this.description;
    const modes = controllers.map((name): [Mode, string] => [name, MODES[name]]);
    const mode = choice("Mode", modes, controller, (mode) => this.act.change({ controller: mode }));
    const parts = [this.knob(mode, () => this.description.controller)];
    if (controller !== "lever" && controller !== "height") {
      // A replay need not state a speed; the controller then takes its own.
      const speed = (): number => this.description["full-speed"] ?? NaN;
      const show = (value: number): string => (Number.isNaN(value) ? "the controller's own" : `${value.toFixed(2)} m/s`);
      const range = { least: 0.05, most: 1, step: 0.05, show };
      parts.push(this.slider("Speed at full stick", range, speed, (value) => this.act.change({ "full-speed": value })));
    }
    if (gains.length) {
      const rows = gains.map(({ name, key, unit, value }, i) =>
        this.knob(number(name, unit, value, (now) => this.override(key, now)), () => this.description.gains[i]?.value ?? value),
      );
      parts.push(folded("gains", "Gains", open.has("gains"), ...rows));
    }
    return section("Control", ...parts);
  }

  private device(open: Set<string | null>): HTMLElement {
    const again = (): void => this.build();
    return folded("gamepad", "Gamepad or joystick", open.has("gamepad"), ...deviceRows(this.description.axes, again));
  }

  private files(): HTMLElement {
    return section(
      "Data and link",
      make(
        "div",
        { className: "row" },
        button("Data", "Save the last two minutes of all signals as CSV", this.act.data),
        button("Link", "Copy an address that opens this page and replays the drive", this.act.share),
      ),
    );
  }
}

function section(title: string, ...children: (Node | string)[]): HTMLElement {
  return make("section", {}, make("h2", {}, title), ...children);
}

function folded(name: string, title: string, open: boolean, ...children: Node[]): HTMLElement {
  const made = make("details", { open }, make("summary", {}, title), ...children);
  made.setAttribute("data-name", name);
  return made;
}
