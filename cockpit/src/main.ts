/** The cockpit: joins worker, picture, sticks, charts and knobs. */

import "./style.css";
import { Charts } from "./charts";
import { button, download, make } from "./elements";
import { Hint } from "./hint";
import { History } from "./history";
import { linkOf, requestOf } from "./link";
import { LogTask } from "./logs";
import type { Description, Ended, FromWorker, Occurrence, Pace, Point, Recording, Request, ToWorker } from "./messages";
import { keepOffline } from "./offline";
import { dark, palette, scaleColour } from "./palette";
import { Panel } from "./panel";
import { limitOf, Picture } from "./picture";
import { Sticks } from "./sticks";
import { Task, type TaskName } from "./tasks";
import { aboutRun, Timeline } from "./timeline";
import { steerView } from "./view";

/** Time between two drawings of the charts, ms. */
const CHARTS = 100;
/** Rows of the charts between two points of the trail. */
const TRAIL = 4;
/** Size of tasks as a share of the reach. */
const TASK_SIZE = 0.15;
/** Speeds of the clock. */
const SPEEDS = [0.1, 0.25, 0.5, 1, 2];
/** Further ones of a run that is only looked at. */
const FASTER = [5, 10];
/** Where a drive begins unless the address says otherwise: comfortable sticks. */
const COMFORT: Partial<Request> = { "full-speed": 0.3, "dead-zone": 0.02, ramp: 0.15 };
const USUAL: Request = { machine: "rottne-f9-lab", controller: "tip", ...COMFORT };

const part = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

class CockpitPage {
  private readonly worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
  private readonly history = new History();
  private readonly canvas = part<HTMLCanvasElement>("picture");
  private readonly picture = new Picture(this.canvas);
  private readonly sticks = new Sticks(part("sticks"));
  private readonly hint = new Hint(part("stage"));
  private readonly charts = new Charts(part("charts"), this.history);
  private readonly panel: Panel;
  private description: Description | null = null;
  private request: Request = USUAL;
  private row: Float64Array | null = null;
  private speed = 1;
  private paused = false;
  private replaying = false;
  private task: TaskName | null = null;
  /** A task was chosen, and the fresh start that it begins with has not come yet. */
  private taskWaits = false;
  private timeline: Timeline | null = null;
  private drawnCharts = 0;
  private sinceTrail = 0;
  private sentSticks = "";
  private sentAt = 0;

  constructor(
    first: Request,
    private readonly run: Run | null = null,
  ) {
    this.panel = new Panel(part("panel"), {
      change: (changes) => this.change(changes),
      open: (request) => this.open({ ...COMFORT, controller: this.request.controller ?? "tip", ...request }),
      carry: (mass) => (this.logs ? this.grip(this.logs) : this.send({ do: "carry", mass })),
      drop: () => (this.logs ? this.grip(this.logs) : this.send({ do: "carry", mass: 0 })),
      save: () => this.send({ do: "save", share: false }),
      share: () => this.send({ do: "save", share: true }),
      replay: (scenario, machine) => this.open({ scenario, text: machine ?? this.request.text ?? null }),
      task: (task) => this.setTask(task),
      data: () => this.data(),
    });
    this.worker.onmessage = (event: MessageEvent<FromWorker>) => this.hear(event.data);
    this.worker.onerror = (event) => this.notice(`The simulation cannot run here: ${event.message}`, "error", 0);
    steerView(this.canvas, this.picture.view);
    this.addViewButtons();
    this.addBar();
    this.addLegend();
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
    window.addEventListener("keydown", (event) => this.shortcut(event));
    if (this.run) this.view(first, this.run);
    else this.open(first);
    const frame = (now: number): void => {
      this.frame(now);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  private send(message: ToWorker): void {
    this.worker.postMessage(message);
  }

  /** A run in place of a drive. */
  private view(request: Request, { about, table }: Run): void {
    document.body.classList.add("viewing");
    this.worker.postMessage({ do: "view", request, columns: about.columns, table } satisfies ToWorker, [table.buffer]);
  }

  private seek(time: number): void {
    this.send({ do: "seek", time });
  }

  private open(request: Request): void {
    this.send({ do: "open", request: { ...request, "keep-state": false } });
  }

  /** Other settings for the crane as it moves. */
  private change(changes: Partial<Request>): void {
    this.send({ do: "open", request: { ...this.request, ...changes, "keep-state": true } });
  }

  private reset(): void {
    if (this.paused) this.pause(false);
    if (this.run) return this.seek(0);
    this.open(this.request);
  }

  private pause(paused: boolean): void {
    this.paused = paused;
    this.send({ do: "pace", speed: this.speed, paused });
    const pauseButton = part("pause");
    pauseButton.textContent = paused ? "▶ Go on" : "❚❚ Pause";
    document.body.classList.toggle("paused", paused);
  }

  private hear(message: FromWorker): void {
    switch (message.tell) {
      case "opened":
        return this.begin(message.description, message.fresh);
      case "rows":
        this.replaying = message.replaying;
        if (message.anew) this.clearWay();
        return this.take(message.latest, message.history, message.width, message.pace);
      case "refused":
        this.notice(message.problem.message, "error", 0);
        // Where the very first wish fails, the usual crane takes its place.
        if (this.description) this.panel.show(this.description, this.request);
        else if (!this.run) this.open(USUAL);
        return;
      case "happened":
        return this.happened(message.events, message.ended);
      case "saved":
        return message.share ? void this.shared(message.text) : this.saved(message.text);
      case "broken":
        return this.notice(`The simulation has stopped: ${message.message}. Reload the page to begin anew.`, "error", 0);
      case "ready":
        return;
    }
  }

  private begin(description: Description, fresh: boolean): void {
    const hadOne = this.description !== null;
    const axes = this.description?.axes.join();
    this.description = description;
    const { scenario: _, ...request } = description.request;
    this.request = request;
    if (hadOne) part("notices").replaceChildren();
    this.warnOfVersion(description);
    this.history.begin(description.signals, !fresh);
    this.picture.show(description, !fresh);
    if (fresh) {
      this.picture.task = null;
      this.taskWaits = false;
    }
    if (this.run) this.showRun(this.run.about, description);
    else this.showControls(description, axes);
    this.charts.rebuild();
    document.querySelectorAll<HTMLButtonElement>("#modes button").forEach((made) => {
      made.setAttribute("aria-pressed", String(made.value === description.controller));
    });
    part("machine-name").textContent = description.machine.name;
    document.title = `${description.machine.name} · hydrocrane cockpit`;
  }

  private showControls(description: Description, axesBefore: string | undefined): void {
    if (axesBefore !== description.axes.join()) this.sticks.show(description.axes);
    if (description["replay-until"] === null) this.hint.show(description.controller !== "lever");
    else this.hint.hide();
    this.sentSticks = "";
    this.panel.show(description, this.request);
  }

  private showRun(about: Recording, description: Description): void {
    const seek = (time: number): void => this.seek(time);
    this.timeline = new Timeline(part("sticks"), description["replay-until"] ?? 1, seek);
    part("panel").replaceChildren(...aboutRun(about, description.machine.title, seek, () => this.data()));
  }

  /** Charts and trail begin anew. */
  private clearWay(): void {
    if (!this.description) return;
    this.history.begin(this.description.signals, false);
    this.picture.show(this.description, false);
  }

  private setTask(task: TaskName | null): void {
    this.task = task;
    this.picture.task = null;
    this.taskWaits = task !== null;
    if (task) this.reset();
  }

  /** The path begins where the tip is at rest after a fresh start. */
  private followTask(row: Float64Array): void {
    if (!this.task || this.taskWaits || !this.description) return;
    const read = (name: string): number => row[this.history.at(name)]!;
    const tip: Point = [read("tip.x"), read("tip.z")];
    const task = (this.picture.task ??= this.newTask(this.task, tip, this.description));
    if (!task) return this.setTask(null);
    const mode = this.description.controller;
    const score = task.over ? null : task.follow(read("time"), tip, read("ledger.supply"), mode);
    if (score) {
      this.panel.score(score);
      this.notice("Done. Reset begins the task again, key 2 first tries it with levers.", "info", 8000);
    }
  }

  private newTask(name: TaskName, tip: Point, description: Description): Task | LogTask | null {
    if (name !== "logs") return new Task(name, tip, TASK_SIZE * Math.max(...description.workspace.flat().map(([x]) => x)));
    const task = LogTask.within(description, tip);
    if (task) this.notice("Bring the tip to a ring, Space grips; bring the log over the bunk, Space lets go.", "info", 10000);
    else this.notice("This crane has no room for logs and a bunk.", "error", 0);
    return task;
  }

  private get logs(): LogTask | null {
    return this.picture.task instanceof LogTask ? this.picture.task : null;
  }

  /** The grapple closes or opens where the tip is. */
  private grip(task: LogTask): void {
    if (!this.row) return;
    const done = task.grip([this.row[this.history.at("tip.x")]!, this.row[this.history.at("tip.z")]!]);
    if (typeof done === "number") this.send({ do: "carry", mass: done });
    else this.notice(done, "info", 4000);
  }

  private warnOfVersion(description: Description): void {
    const from = description["recorded-by"];
    if (from && from !== description.version) {
      this.notice(`Recorded with version ${from}, replayed with ${description.version}: the drive may differ.`, "info", 0);
    }
  }

  private take(latest: Float64Array, history: Float64Array, width: number, pace: Pace): void {
    // Rows of the drive before, still on their way.
    if (!this.description || width < this.description.signals.length) return;
    this.row = latest;
    this.history.add(history, width);
    const [x, z] = [this.history.at("tip.x"), this.history.at("tip.z")];
    for (let at = 0; at < history.length; at += width) {
      this.followTask(history.subarray(at, at + width));
      if (this.sinceTrail++ % TRAIL === 0) this.picture.follow([history[at + x]!, history[at + z]!]);
    }
    this.showPace(pace);
  }

  private showPace(pace: Pace): void {
    const slow = !this.paused && !this.run && pace.factor < 0.95 * this.speed && (this.row?.[0] ?? 0) > 2;
    const until = this.description?.["replay-until"]?.toFixed(1);
    const doing = this.replaying ? `replay until ${until} s, any stick takes over · ` : "";
    const rate = `${slow ? "too slow a computer: " : ""}${pace.factor.toFixed(2)} × real time`;
    const text = doing + (this.paused ? "paused" : rate);
    const lost = pace.lost >= 0.1 ? ` · ${pace.lost.toFixed(1)} s given up` : "";
    const badge = part("pace");
    badge.textContent = text + lost;
    badge.classList.toggle("slow", slow);
    badge.title = `Computing takes ${(100 * pace.load).toFixed(0)} % of the time. Time is given up where the computer is too slow or the page asleep.`;
  }

  private happened(events: Occurrence[], ended: Ended | null): void {
    for (const { time, text } of events) this.notice(`${time.toFixed(2)} s: ${text}`, "info", 6000);
    if (ended) this.notice(`The drive ended at ${ended.time.toFixed(2)} s (${ended.kind}): ${ended.message}. Reset begins anew.`, "error", 0);
  }

  private data(): void {
    download("drive.csv", this.history.csv(), "text/csv");
  }

  private saved(text: string): void {
    download("drive.toml", text, "application/toml");
    const own = this.request.text ? ` Keep it beside ${this.request.machine}.` : "";
    this.notice(`Saved. \`hydrocrane simulate drive.toml\` repeats the drive.${own}`, "info", 8000);
  }

  private async shared(text: string): Promise<void> {
    let address: string;
    try {
      address = await linkOf(text, this.request.text ?? null);
    } catch (error) {
      return this.notice((error as Error).message, "error", 0);
    }
    const copied = await navigator.clipboard?.writeText(address).then(
      () => true,
      () => false,
    );
    history.replaceState(null, "", address);
    this.notice(`${copied ? "Copied" : "In the address bar"}: an address that replays the drive.`, "info", 8000);
  }

  notice(text: string, kind: "info" | "error", life: number): void {
    const room = part("notices");
    const box = make("div", { className: `notice ${kind}` }, make("pre", {}, text));
    box.append(button("×", "Close this message", () => box.remove()));
    room.append(box);
    while (room.childElementCount > 4) room.firstElementChild?.remove();
    if (life) setTimeout(() => box.remove(), life);
  }

  private frame(now: number): void {
    const axes = this.sticks.read();
    const text = axes.join();
    this.hint.see(axes);
    // Told again now and then, so that the simulation knows that somebody is there.
    if (this.description && !this.run && (text !== this.sentSticks || now - this.sentAt > 100)) {
      this.send({ do: "steer", axes });
      this.sentSticks = text;
      this.sentAt = now;
    }
    if (!this.row) return;
    const row = this.row;
    const read = (name: string): number => row[this.history.at(name)] ?? NaN;
    this.picture.draw(row, read);
    this.timeline?.show(read("time"));
    if (now - this.drawnCharts > CHARTS) {
      this.drawnCharts = now;
      this.charts.draw(!this.paused);
      this.showReadout(read);
    }
  }

  private showReadout(read: (name: string) => number): void {
    const speed = Math.hypot(read("tip.vx"), read("tip.vz"));
    const entries: [string, string][] = [
      ["time", `${read("time").toFixed(1)} s`],
      ["tip", `${read("tip.x").toFixed(3)}, ${read("tip.z").toFixed(3)} m`],
      ["speed", `${speed.toFixed(2)} m/s`],
      ["pump", `${(read("supply.power") / 1000).toFixed(2)} kW`],
      ["work", `${(read("ledger.supply") / 1000).toFixed(1)} kJ`],
    ];
    for (const joint of this.description?.joints ?? []) {
      const limit = limitOf(joint, read(`joint.${joint.name}.q`));
      if (limit) entries.push([`${joint.name} at its limit`, limit]);
    }
    const pad = this.sticks.pad;
    if (pad) entries.push(["gamepad", pad.id.slice(0, 24)]);
    part("readout").replaceChildren(
      ...entries.map(([name, value]) => make("span", {}, make("small", {}, name), make("b", {}, value))),
    );
  }

  private addBar(): void {
    const modes = make("div", { id: "modes" });
    modes.setAttribute("role", "group");
    modes.setAttribute("aria-label", "Mode");
    for (const [mode, title] of [
      ["tip", "One stick moves the tip (key 1)"],
      ["lever", "One lever per cylinder (key 2)"],
    ] as const) {
      const made = button(mode, title, () => this.change({ controller: mode }));
      made.value = mode;
      modes.append(made);
    }
    const speed = make("select", { id: "speed", title: "Speed of the clock" });
    [...SPEEDS, ...(this.run ? FASTER : [])].forEach((s) => speed.add(new Option(`clock ${s} ×`, String(s), s === 1, s === 1)));
    speed.addEventListener("change", () => {
      speed.blur();
      this.speed = Number(speed.value);
      this.pause(this.paused);
    });
    const pauseButton = button("❚❚ Pause", "Stop the clock (key P)", () => this.pause(!this.paused));
    pauseButton.id = "pause";
    const resetButton = button("↺ Reset", "Back to the start, at rest (key 0)", () => this.reset());
    resetButton.id = "reset";
    part("bar").append(
      make("h1", {}, "hydrocrane", make("small", { id: "machine-name" })),
      modes,
      pauseButton,
      resetButton,
      speed,
      make("span", { id: "pace" }),
      button("◐", "Light or dark", () => this.switchTheme(), "theme"),
    );
  }

  private addViewButtons(): void {
    const view = this.picture.view;
    part("view-buttons").append(
      button("+", "Zoom in", () => view.zoom(1.25)),
      button("−", "Zoom out", () => view.zoom(0.8)),
      button("⤢", "Show everything", () => view.fit()),
    );
  }

  private addLegend(): void {
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
    part("legend").replaceChildren(
      make("span", {}, "oil pressure 0", bar, "supply"),
      key(colours.actual, "velocity of the tip"),
      key(colours.wanted, "asked by the stick"),
      key(colours.limit, "limit reached"),
      key(colours.reachEdge, "within reach"),
      key(colours.forbiddenEdge, "keep out"),
    );
  }

  private switchTheme(): void {
    document.documentElement.dataset["theme"] = dark() ? "light" : "dark";
    this.recolour();
  }

  private recolour(): void {
    this.charts.rebuild();
    this.addLegend();
  }

  private shortcut(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return;
    if (this.run && event.code.startsWith("Digit") && event.code !== "Digit0") return;
    if (event.code === "Digit1") this.change({ controller: "tip" });
    else if (event.code === "Digit2") this.change({ controller: "lever" });
    else if (event.code === "Space" && this.logs && target.tagName !== "BUTTON") {
      event.preventDefault();
      this.grip(this.logs);
    } else if (event.code === "KeyP") this.pause(!this.paused);
    else if (event.code === "Digit0") this.reset();
  }
}

/** A run to be looked at. */
interface Run {
  about: Recording;
  table: Float64Array<ArrayBuffer>;
}

/** What the page is to open. */
interface First {
  request: Request;
  run?: Run;
}

/** What the address asks for: `?machine=NAME`, or `?chosen` for what `hydrocrane live` or `view` lays beside the page. */
async function firstRequest(): Promise<First> {
  const shared = await requestOf(location.hash);
  if (shared) return { request: shared };
  const asked = new URLSearchParams(location.search);
  if (asked.has("chosen")) {
    const answer = await fetch("chosen.json");
    if (answer.ok) return chosen((await answer.json()) as Request & { recording?: Recording });
  }
  const machine = asked.get("machine");
  return { request: machine ? { ...USUAL, machine } : USUAL };
}

async function chosen({ recording, ...request }: Request & { recording?: Recording }): Promise<First> {
  if (!recording) return { request: { ...USUAL, ...request } };
  const answer = await fetch("recorded.bin");
  if (!answer.ok) throw new Error(`The run cannot be read: ${answer.status} ${answer.statusText}`);
  return { request, run: { about: recording, table: new Float64Array(await answer.arrayBuffer()) } };
}

keepOffline();
void firstRequest().then(
  ({ request, run }) => new CockpitPage(request, run ?? null),
  (error: Error) => new CockpitPage(USUAL).notice(error.message, "error", 0),
);
