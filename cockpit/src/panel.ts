/** The knobs beside the picture: load, pressure, friction, sensors, controller, machine, files. */

import { button, choice, make, slider } from "./elements";
import { device, keepMapping, mapping } from "./gamepad";
import type { Description, Request } from "./messages";
import { TASKS, type Score, type TaskName } from "./tasks";

export interface Actions {
  /** Changes the drive at hand, which goes on from its state. */
  change: (changes: Partial<Request>) => void;
  /** Another machine. */
  open: (request: Request) => void;
  carry: (mass: number) => void;
  drop: () => void;
  save: () => void;
  share: () => void;
  /** `machine`: text of the machine file that the scenario names, where it was chosen with it. */
  replay: (scenario: string, machine: string | null) => void;
  data: () => void;
  /** Back to the start with something to do, or nothing. */
  task: (task: TaskName | null) => void;
}

const MODES: Record<string, string> = {
  tip: "tip: one stick moves the tip",
  "heinze-pid": "heinze-pid: the thesis's controller",
  lever: "lever: one axis per cylinder",
};

export class Panel {
  /** Load that the button picks up, kg. */
  private load = 80;
  private task = "";
  private readonly scores: Score[] = [];
  private readonly board = make("div", { id: "scores" });

  constructor(
    private readonly room: HTMLElement,
    private readonly act: Actions,
  ) {}

  show(description: Description, request: Request): void {
    const open = new Set([...this.room.querySelectorAll("details[open]")].map((d) => d.getAttribute("data-name")));
    this.room.replaceChildren(
      this.machine(description, request),
      this.cargo(),
      this.tasks(),
      this.plant(description, request),
      this.control(description, request, open),
      this.device(description, open),
      this.files(),
    );
  }

  private machine(description: Description, request: Request): HTMLElement {
    const bundled = description.machines.map(({ name }): [string, string] => [name, name]);
    const name = description.machine.source;
    const own: [string, string][] = request.text ? [[name, name]] : [];
    const file = fileInput("machine-file", ([chosen]) => chosen && this.act.open({ machine: chosen.name, text: chosen.text }));
    return section(
      "Machine",
      choice("Crane", [...own, ...bundled], name, (machine) => this.act.open({ machine })),
      make("p", { className: "hint" }, description.machine.title),
      button("Open a machine file …", "Open a machine file from this computer", () => file.click()),
      file,
    );
  }

  private cargo(): HTMLElement {
    const show = (mass: number): string => `${mass.toFixed(0)} kg`;
    return section(
      "Load",
      slider("Log", { least: 5, most: 300, step: 5, value: this.load, show }, (mass) => (this.load = mass)),
      make(
        "div",
        { className: "row" },
        button("Pick up", "The tip takes up the log, which lies still", () => this.act.carry(this.load)),
        button("Drop", "The tip lets the log go", () => this.act.drop()),
      ),
    );
  }

  private tasks(): HTMLElement {
    const tasks: [string, string][] = [["", "none"], ...Object.entries(TASKS)];
    return section(
      "Task",
      choice("To be done", tasks, this.task, (task) => {
        this.task = task;
        this.act.task(task ? (task as TaskName) : null);
      }),
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
    const about = "Worst and mean distance from the path, of logs from the middle of the bunk; work of the pump.";
    this.board.replaceChildren(make("table", {}, head, ...rows), make("p", { className: "hint" }, about));
  }

  private plant(description: Description, request: Request): HTMLElement {
    const bar = (pascal: number): string => `${(pascal / 1e5).toFixed(0)} bar`;
    const percent = (share: number): string => `${(100 * share).toFixed(0)} %`;
    const supply = { least: 40e5, most: 250e5, step: 5e5, value: description.supply, show: bar };
    const friction = { least: 0, most: 3, step: 0.1, value: request.friction ?? 1, show: percent };
    const sensors: [string, string][] = [
      ["ideal", "ideal: exact"],
      ["real", "real: data sheets, noise, steps"],
    ];
    const parts = [
      slider("Supply pressure", supply, (value) =>
        this.act.change({ overrides: { ...request.overrides, "supply.pressure": value } }),
      ),
      slider("Friction", friction, (value) => this.act.change({ friction: value })),
    ];
    if (description.sensors) {
      const chosen = request["real-sensors"] ? "real" : "ideal";
      parts.push(choice("Sensors", sensors, chosen, (value) => this.act.change({ "real-sensors": value === "real" })));
    }
    return section("Hydraulics and sensors", ...parts);
  }

  private control(description: Description, request: Request, open: Set<string | null>): HTMLElement {
    const modes = description.controllers.map((name): [string, string] => [name, MODES[name] ?? name]);
    const parts = [choice("Mode", modes, description.controller, (controller) => this.act.change({ controller }))];
    if (description.controller !== "lever") {
      const show = (speed: number): string => `${speed.toFixed(2)} m/s`;
      const value = description["full-speed"] ?? 0.3;
      parts.push(
        slider("Full stick", { least: 0.05, most: 1, step: 0.05, value, show }, (speed) =>
          this.act.change({ "full-speed": speed }),
        ),
      );
    }
    if (description.gains.length) parts.push(this.gains(description, request, open.has("gains")));
    return section("Control", ...parts);
  }

  private gains(description: Description, request: Request, open: boolean): HTMLElement {
    const rows = description.gains.map(({ name, key, unit, value }) => {
      const input = make("input", { type: "number", step: "any", value: String(Number(value.toPrecision(6))) });
      input.addEventListener("change", () => {
        if (Number.isFinite(input.valueAsNumber)) {
          this.act.change({ overrides: { ...request.overrides, [key]: input.valueAsNumber } });
        }
      });
      return make("label", { className: "gain" }, make("span", {}, name), input, make("small", {}, unit));
    });
    return folded("gains", "Gains", open, ...rows);
  }

  private device(description: Description, open: Set<string | null>): HTMLElement {
    const rows = description.axes.map((name, index) => {
      const kept = mapping(name, index);
      const count = Math.max(device()?.axes.length ?? 4, kept.axis + 1);
      const options: [string, string][] = [["-1", "none"]];
      for (let axis = 0; axis < count; axis++) options.push([String(axis), `axis ${axis + 1}`]);
      const inverted = make("input", { type: "checkbox", checked: kept.inverted });
      const chosen = { ...kept };
      inverted.addEventListener("change", () => {
        chosen.inverted = inverted.checked;
        keepMapping(name, chosen);
      });
      const select = choice(name, options, String(kept.axis), (value) => {
        chosen.axis = Number(value);
        keepMapping(name, chosen);
      });
      return make("div", { className: "axis-row" }, select, make("label", {}, inverted, " reversed"));
    });
    const found = device()?.id ?? "None found yet: plug one in and press one of its buttons.";
    return folded("gamepad", "Gamepad or joystick", open.has("gamepad"), make("p", { className: "hint" }, found), ...rows);
  }

  private files(): HTMLElement {
    const file = fileInput("drive-file", (files) => {
      const scenario = files.find(({ text }) => /^\s*\[scenario\]/m.test(text)) ?? files[0];
      const machine = files.find((other) => other !== scenario);
      if (scenario) this.act.replay(scenario.text, machine?.text ?? null);
    });
    file.multiple = true;
    return section(
      "Keep this drive",
      file,
      make(
        "div",
        { className: "row" },
        button("Scenario", "Save what you did since the last reset, changes of mode and knobs included, as a scenario for hydrocrane simulate", this.act.save),
        button("Data", "Save the last two minutes as CSV", this.act.data),
      ),
      make(
        "div",
        { className: "row" },
        button("Link", "Copy an address that opens this page and replays the drive", this.act.share),
        button("Replay …", "Replay a saved drive, or another scenario with a joystick; choose its machine file with it", () => file.click()),
      ),
    );
  }
}

/** A hidden input that hands on the names and texts of the files that somebody chooses. */
function fileInput(id: string, act: (files: { name: string; text: string }[]) => void): HTMLInputElement {
  const file = make("input", { type: "file", accept: ".toml", id, hidden: true });
  file.addEventListener("change", () => {
    const chosen = [...(file.files ?? [])];
    file.value = "";
    void Promise.all(chosen.map(async (one) => ({ name: one.name, text: await one.text() }))).then(act);
  });
  return file;
}

function section(title: string, ...children: (Node | string)[]): HTMLElement {
  return make("section", {}, make("h2", {}, title), ...children);
}

function folded(name: string, title: string, open: boolean, ...children: Node[]): HTMLElement {
  const made = make("details", { open }, make("summary", {}, title), ...children);
  made.setAttribute("data-name", name);
  return made;
}
