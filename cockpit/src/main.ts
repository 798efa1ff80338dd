/** The cockpit: joins simulation, picture, sticks, charts and knobs. */

import "./style.css";
import { addDriveButtons, addViewButtons, Bar, showLegend, showScale, type Clock, type Switches } from "./bar";
import { drawable } from "./bounds";
import { Charts } from "./charts";
import { download } from "./elements";
import { askedBy, fileInput, takeDrops } from "./files";
import { firstRequest, type Run } from "./first";
import type { Action } from "./gamepad";
import { Ghosts } from "./ghost";
import { Hint } from "./hint";
import { History } from "./history";
import { linkOf, requestOf } from "./link";
import { Logs, LogTask } from "./logs";
import type { Description, Ended, FromWorker, Mode, Occurrence, Overrides, Pace, Point, Recording, Request, ToWorker } from "./messages";
import { Notices } from "./notices";
import { keepOffline, servedLive } from "./offline";
import { dark } from "./palette";
import { Panel, type Place } from "./panel";
import { Picture } from "./picture";
import { groundNote, showReadout } from "./readout";
import { Simulation } from "./simulation";
import { Sticks } from "./sticks";
import { Task, type TaskName } from "./tasks";
import { aboutRun, Timeline } from "./timeline";
import { clickedPlaces, steerView } from "./view";

/** Time between two drawings of the charts, ms. */
const CHARTS = 100;
/** Rows of the charts between two points of the trail. */
const TRAIL = 4;
/** Size of tasks as a share of the reach. */
const TASK_SIZE = 0.15;
/** Where a drive begins unless the address says otherwise: comfortable sticks, ground that carries. */
const COMFORT: Partial<Request> = { "dead-zone": 0.02, ramp: 0.15, ground: true };
const USUAL: Request = { machine: "rottne-f9-lab", controller: "tip", ...COMFORT };

const part = <T extends HTMLElement>(id: string): T => document.getElementById(id) as T;

class CockpitPage {
  private readonly simulation = new Simulation((message) => this.hear(message), (reason) => this.stopped(reason));
  private readonly notices = new Notices(part("notices"));
  private readonly history = new History();
  private readonly ghosts = new Ghosts();
  private readonly canvas = part<HTMLCanvasElement>("picture");
  private readonly picture = new Picture(this.canvas);
  private readonly sticks = new Sticks(part("levers"), part("guide"), (action) => this.do(action));
  private readonly hint = new Hint(part("guide"));
  private readonly charts = new Charts(part("charts"), this.history);
  private readonly bar: Bar;
  private readonly panel: Panel;
  private description: Description | null = null;
  private request: Request = USUAL;
  /** What the crane at hand was opened by: `request` without what has been changed since and is not answered yet. */
  private granted: Request = USUAL;
  /** What was asked for last. */
  private asked: Request = USUAL;
  private row: Float64Array | null = null;
  private pace: Pace = { factor: null, slow: false, load: 0, lost: 0 };
  private speed = 1;
  private paused = false;
  private over = false;
  private replaying = false;
  private task: TaskName | null = null;
  /** What there is to do, once a fresh start has come that it begins with. */
  private todo: Task | LogTask | null = null;
  private taskWaits = false;
  private logs: Logs | null = null;
  private timeline: Timeline | null = null;
  /** Whether readout and charts show less than is known. */
  private fresh = false;
  private drawnCharts = 0;
  private sinceTrail = 0;
  private readonly switches: Switches;
  /** Whether the next click sends the tip there. */
  private aiming = false;
  private sentSticks = "";
  private sentAt = 0;

  constructor(
    first: Request,
    private readonly run: Run | null = null,
  ) {
    this.panel = this.newPanel();
    this.bar = this.newBar(run !== null);
    addViewButtons(part("view-buttons"), this.picture.view);
    const act = { grip: () => this.grip(), aim: () => this.aim(!this.aiming), precise: () => this.bePrecise(!this.sticks.precise) };
    this.switches = addDriveButtons(part("drive-buttons"), act);
    this.aim(false);
    this.bePrecise(false);
    showLegend(part("legend"), this.picture.view.scale);
    this.listen();
    if (this.run) this.view(first, this.run);
    else this.open(first);
    const frame = (now: number): void => {
      this.frame(now);
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  private newPanel(): Panel {
    return new Panel(part("panel"), {
      change: (changes) => this.change(changes),
      open: (request) => this.drive(request),
      weigh: (mass) => this.weigh(mass),
      load: (mass) => this.load(mass),
      share: () => this.send({ do: "save", share: true }),
      task: (task) => this.setTask(task),
      ghost: (ghost) => {
        this.ghosts.chosen = ghost;
        this.picture.stale = true;
      },
      data: () => this.data(),
      files: (files) => void this.take(files),
    });
  }

  private newBar(looks: boolean): Bar {
    const act = {
      mode: (controller: Mode) => this.change({ controller }),
      pause: () => this.pause(!this.paused),
      reset: () => this.reset(),
      speed: (speed: number) => this.keepTime(speed, this.paused),
      save: () => this.send({ do: "save", share: false }),
      replay: () => chosen.click(),
      theme: () => this.switchTheme(),
    };
    const chosen = fileInput("drive-file", (files) => void this.take(files));
    document.body.append(chosen);
    return new Bar(part("bar"), act, looks);
  }

  private listen(): void {
    steerView(this.canvas, this.picture.view);
    clickedPlaces(this.canvas, this.picture.view, (place) => this.goTo(place));
    window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.recolour());
    window.addEventListener("keydown", (event) => this.shortcut(event));
    // A crane does not go on by itself while nobody watches.
    document.addEventListener("visibilitychange", () => document.hidden && this.dropGoal());
    window.addEventListener("hashchange", () => void this.follow());
    takeDrops((files) => void this.take(files));
    for (const change of ["gamepadconnected", "gamepaddisconnected"]) {
      window.addEventListener(change, () => this.run || this.panel.plugged());
    }
  }

  private send(message: ToWorker): void {
    this.simulation.send(message);
  }

  /** Whether the next click in the picture sends the tip there. */
  private aim(aiming: boolean): void {
    this.aiming = aiming && this.description?.controller === "tip" && !this.run;
    this.switches.aim.setAttribute("aria-pressed", String(this.aiming));
    this.canvas.classList.toggle("aiming", this.aiming);
  }

  private goTo(place: Point): void {
    if (!this.aiming) return;
    this.aim(false);
    this.setGoal(place);
    this.send({ do: "go", place });
  }

  private setGoal(place: Point | null): void {
    this.picture.stale ||= this.picture.goal !== place;
    this.picture.goal = place;
  }

  private dropGoal(): void {
    if (!this.picture.goal) return;
    this.setGoal(null);
    this.send({ do: "drop" });
  }

  private bePrecise(precise: boolean): void {
    this.sticks.precise = precise;
    this.switches.precise.setAttribute("aria-pressed", String(precise));
  }

  /** A run in place of a drive. */
  private view(request: Request, { about, table }: Run): void {
    document.body.classList.add("viewing");
    this.simulation.send({ do: "view", request, columns: about.columns, table }, [table.buffer]);
  }

  private seek(time: number): void {
    this.send({ do: "seek", time });
  }

  /** A fresh start, with the clock running. */
  private open(request: Request): void {
    this.asked = request;
    // What is changed before the answer comes adds to this. A scenario's machine is known by the answer alone.
    if (!request.scenario) this.request = request;
    if (this.paused) this.keepTime(this.speed, false);
    this.send({ do: "open", request: { ...request, "keep-state": false } });
  }

  /** Another machine, driven as the one before. */
  private drive(request: Request): void {
    this.open({ ...COMFORT, controller: this.asked.controller ?? this.request.controller ?? "tip", ...request });
  }

  /** A machine or a scenario of somebody's own. The machine at hand is there for a scenario that names it. */
  private async take(files: Iterable<File>): Promise<void> {
    if (this.run) return this.tell("A run is shown here: `hydrocrane live` drives machines and replays scenarios.");
    try {
      const request = await askedBy(files);
      if (request.scenario) this.open({ ...request, files: { ...this.ownFile(this.request), ...request.files } });
      else this.drive(request);
    } catch (error) {
      this.refuse((error as Error).message);
    }
  }

  /** The machine file of a request, where it has one. */
  private ownFile({ machine, text }: Request): Record<string, string> {
    return machine && text ? { [machine]: text } : {};
  }

  /** A fresh start with a load at the tip, kg, in place of what the machine's own would be. */
  private load(payload: number): void {
    const { "payload.mass": _, ...overrides } = this.request.overrides ?? {};
    this.open({ ...this.request, overrides, payload });
  }

  /** Other settings for the crane as it moves. */
  private change(changes: Partial<Request>): void {
    const overrides = { ...this.request.overrides, ...changes.overrides };
    this.request = this.asked = { ...this.request, ...changes, overrides };
    this.send({ do: "open", request: { ...this.asked, "keep-state": true } });
  }

  /** A drive that somebody has pasted into the address of the page. */
  private async follow(): Promise<void> {
    try {
      const request = await requestOf(location.hash);
      if (request && !this.run) this.open(request);
    } catch (error) {
      this.refuse((error as Error).message);
    }
  }

  private reset(): void {
    if (!this.run) return this.open(this.request);
    if (this.paused) this.keepTime(this.speed, false);
    this.seek(0);
  }

  private pause(paused: boolean): void {
    if (!this.over) this.keepTime(this.speed, paused);
  }

  private keepTime(speed: number, paused: boolean): void {
    [this.speed, this.paused] = [speed, paused];
    this.send({ do: "pace", speed, paused });
    this.showClock();
  }

  private showClock(): void {
    const state: Clock = this.over ? "ended" : this.paused ? "paused" : "runs";
    const until = this.description?.["replay-until"]?.toFixed(1);
    this.bar.clock(state);
    this.bar.pace(this.pace, state, this.replaying ? `replay until ${until} s; move a stick to take over · ` : "");
  }

  private hear(message: Exclude<FromWorker, { tell: "alive" | "broken" }>): void {
    switch (message.tell) {
      case "opened":
        return this.begin(drawable(message.description), message.fresh);
      case "rows":
        this.replaying = message.replaying;
        if (message.anew) this.clearWay();
        return this.see(message.latest, message.history, message.width, message.pace);
      case "refused":
        this.setGoal(null);
        this.request = this.granted;
        this.refuse(message.problem.message);
        // Where the very first request fails, the usual crane takes its place.
        if (this.description) this.showPanel(this.description);
        else if (!this.run) this.open(USUAL);
        return;
      case "happened":
        return this.happened(message.events, message.ended);
      case "saved":
        return message.share ? void this.shared(message.text) : this.saved(message.text);
    }
  }

  /** The simulation was ended: the usual crane takes the place of what it could not do, unless it is that. */
  private stopped(reason: string): void {
    const usual = this.asked === USUAL || this.run !== null;
    const cure = usual ? "Press Reset to try again." : "The default crane was loaded instead.";
    this.refuse(`The simulation was stopped: ${reason}. ${cure}`);
    this.keepTime(this.speed, false);
    if (!usual) this.open(USUAL);
  }

  refuse(message: string): void {
    this.notices.tell(message, "error", 0);
  }

  private tell(text: string, life = 8000): void {
    this.notices.tell(text, "info", life);
  }

  private begin(description: Description, fresh: boolean): void {
    const axes = this.description?.axes.join();
    // What stands in keeps the message why.
    if (this.description && this.asked !== USUAL) this.notices.clear(fresh);
    this.description = description;
    const { scenario: _, ...request } = description.request;
    this.request = this.granted = request;
    this.warnOfDifferences(description);
    this.history.begin(description.signals, !fresh);
    this.picture.show(description, !fresh);
    if (fresh) this.beginAnew(description);
    if (this.run) this.showRun(this.run.about, description);
    else this.showControls(description, axes);
    this.charts.rebuild(description);
    this.bar.machine(description);
    this.showClock();
  }

  private beginAnew(description: Description): void {
    this.over = this.taskWaits = false;
    this.ghosts.begin(description.machine.name);
    this.todo = this.picture.task = null;
    this.setGoal(null);
    this.setLogs(this.run ? new Logs(description) : Logs.free(description, this.panel.mass));
  }

  private setLogs(logs: Logs): void {
    this.logs = this.picture.logs = logs;
  }

  private showControls(description: Description, axesBefore: string | undefined): void {
    if (axesBefore !== description.axes.join()) this.sticks.show(description.axes);
    if (description["replay-until"] === null) this.hint.show(description.axes.length === 2 && description.axes[0] === "x");
    else this.hint.hide();
    this.sentSticks = "";
    this.switches.aim.hidden = description.controller !== "tip";
    this.aim(this.aiming);
    this.showPanel(description);
  }

  private showPanel(description: Description): void {
    const plane = description.controllers.includes("tip");
    const logs: TaskName[] = LogTask.keys(description) ? ["logs"] : [];
    const place: Place = {
      ground: this.logs?.somewhere(this.panel.mass) != null,
      tasks: plane ? ["line", "square", "circle", ...logs] : [],
    };
    this.panel.show(description, this.request, place);
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
    this.todo = this.picture.task = null;
    this.taskWaits = task !== null;
    const overrides = LogTask.without(this.request.overrides ?? {});
    if (task === "logs") this.beginLogs(overrides);
    else if (task || this.logs?.bunk) this.open({ ...this.request, overrides });
    this.picture.stale = true;
  }

  /** The logs of the task lie on the ground when it begins, and a bunk stands there. */
  private beginLogs({ "payload.mass": _, ...overrides }: Overrides): void {
    const bunk = this.description && LogTask.keys(this.description);
    if (bunk) return this.open({ ...this.request, ground: true, overrides: { ...overrides, ...bunk }, payload: 0 });
    this.refuse("The tip of this crane cannot reach logs and a bunk on the ground.");
    this.setTask(null);
  }

  /** The path begins where the tip is at rest after a fresh start. */
  private followTask(row: Float64Array): void {
    if (!this.task || this.taskWaits || !this.description) return;
    // Another machine has no bunk yet.
    if (this.task === "logs" && !this.logs?.bunk) return this.setTask("logs");
    const read = (name: string): number => row[this.history.at(name)]!;
    const tip: Point = [read("tip.x"), read("tip.z")];
    const task = (this.todo ??= this.newTask(this.task, tip, this.description));
    if (!task) return;
    const mode = this.description.controller;
    const score = task.over ? null : task.follow(read("time"), tip, read("ledger.supply"), mode);
    if (score) {
      this.panel.score(score);
      this.ghosts.done(score.task, score.time);
      this.tell("Done. Press Reset to repeat the task and race against this drive; press 2 first to use the levers.");
    }
  }

  private newTask(name: TaskName, tip: Point, description: Description): Task | LogTask | null {
    if (name !== "logs") {
      const reach = this.logs?.ground.reach ?? 0;
      return (this.picture.task = new Task(name, tip, TASK_SIZE * reach));
    }
    const task = LogTask.within(description, tip);
    if (task) {
      this.setLogs(task);
      this.tell("Move the tip to a ring and press Grip (Space). Move the log over the bunk and press Let go (Space).", 10000);
    }
    return task;
  }

  /** The grapple closes or opens where the tip is. */
  private grip(): void {
    if (!this.row || !this.logs || this.over) return;
    const done = this.logs.grip([this.row[this.history.at("tip.x")]!, this.row[this.history.at("tip.z")]!]);
    if (typeof done === "number") this.send({ do: "carry", mass: done });
    else this.tell(done, 4000);
    this.picture.stale = true;
  }

  private showGrip(logs: Logs | null): void {
    const text = logs?.holds ? "Let go" : "Grip";
    if (this.switches.grip.textContent !== text) this.switches.grip.textContent = text;
    this.switches.grip.hidden = !logs || !(logs.holds || logs.lying.length);
  }

  private weigh(mass: number): void {
    if (!this.logs || this.logs instanceof LogTask) return;
    this.logs.weigh(mass);
    this.picture.stale = true;
  }

  private warnOfDifferences({ version, controller, ...description }: Description): void {
    const from = description["recorded-by"];
    if (from && from !== version) this.tell(`Recorded with version ${from}, replayed with ${version}: the drive may differ.`, 0);
    const wanted = this.asked.scenario ? undefined : this.asked.controller;
    if (wanted && wanted !== USUAL.controller && wanted !== controller && !description.controllers.includes(wanted) && !this.run) {
      this.tell(`${description.machine.name} has no mode ${wanted}; it has ${description.controllers.join(", ")}.`);
    }
  }

  private see(latest: Float64Array, history: Float64Array, width: number, pace: Pace): void {
    // Rows of the drive before, still on their way.
    if (!this.description || width < this.description.signals.length) return;
    this.row = latest;
    this.fresh = this.picture.stale = true;
    this.history.add(history, width);
    const [x, z] = [this.history.at("tip.x"), this.history.at("tip.z")];
    for (let at = 0; at < history.length; at += width) {
      const row = history.subarray(at, at + width);
      this.followTask(row);
      this.ghosts.see(row[0]!, [row[x]!, row[z]!], this.description.controller, row.subarray(this.description.signals.length));
      if (this.sinceTrail++ % TRAIL === 0) this.picture.follow([history[at + x]!, history[at + z]!]);
    }
    if (this.replaying || this.run) this.logs?.see(latest[this.history.at("payload")]!, [latest[x]!, latest[z]!]);
    this.pace = pace;
    this.showClock();
  }

  private happened(events: Occurrence[], ended: Ended | null): void {
    this.notices.happened(events);
    if (!ended) return;
    this.over = true;
    this.refuse(`The drive ended at ${ended.time.toFixed(2)} s (${ended.kind}): ${ended.message}. Press Reset to start again.`);
    this.showClock();
  }

  private data(): void {
    download("drive.csv", this.history.csv(), "text/csv");
  }

  private saved(text: string): void {
    download("drive.toml", text, "application/toml");
    const own = this.granted.text ? ` Keep it in the same folder as ${this.granted.machine}.` : "";
    this.tell(`Saved as drive.toml. \`hydrocrane simulate drive.toml\` repeats the drive.${own}`);
  }

  private async shared(text: string): Promise<void> {
    let address: string;
    try {
      address = await linkOf(text, this.ownFile(this.granted));
    } catch (error) {
      return this.refuse((error as Error).message);
    }
    const copied = await navigator.clipboard?.writeText(address).then(
      () => true,
      () => false,
    );
    history.replaceState(null, "", address);
    const where = servedLive()
      ? " It works only on this computer and while this program runs. For others, save the scenario."
      : "";
    this.tell(`${copied ? "Copied" : "In the address bar"}: an address that replays the drive.${where}`, where ? 15000 : 8000);
  }

  private frame(now: number): void {
    const axes = this.sticks.read();
    const share = this.sticks.share;
    const text = [...axes, share].join();
    this.hint.see(axes);
    if (axes.some((axis) => axis !== 0)) this.setGoal(null);
    // Told again now and then, so that the simulation knows that somebody is there.
    if (this.description && !this.run && (text !== this.sentSticks || now - this.sentAt > 100)) {
      this.send({ do: "steer", axes, share });
      this.sentSticks = text;
      this.sentAt = now;
    }
    if (!this.row || !this.description) return;
    const row = this.row;
    const read = (name: string): number => row[this.history.at(name)] ?? NaN;
    if (this.picture.stale) {
      this.picture.ghost = this.run ? null : this.ghosts.at(read("time"), this.task);
      this.picture.draw(row, read);
      showScale(this.picture.view.scale);
    }
    if (!this.fresh || now - this.drawnCharts < CHARTS) return;
    this.fresh = false;
    this.drawnCharts = now;
    this.timeline?.show(read("time"));
    this.charts.draw(!this.paused);
    showReadout(part("readout"), this.description, read, this.sticks.pads.map(({ name }) => name));
    this.showGrip(this.logs);
    const note = this.logs ? groundNote(this.logs, read) : "";
    if (part("stage-note").textContent !== note) part("stage-note").textContent = note;
  }

  private switchTheme(): void {
    document.documentElement.dataset["theme"] = dark() ? "light" : "dark";
    this.recolour();
  }

  private recolour(): void {
    if (this.description) this.charts.rebuild(this.description);
    this.picture.stale = true;
    showLegend(part("legend"), this.picture.view.scale);
  }

  /** What a button of a gamepad is for. */
  private do(action: Action): void {
    if (!this.description || this.run) return;
    const { controllers, controller } = this.description;
    const modes = (["tip", "lever", "height"] as Mode[]).filter((mode) => controllers.includes(mode));
    if (action === "grip") this.grip();
    else if (action === "pause") this.pause(!this.paused);
    else if (action === "reset") this.reset();
    else if (action === "mode") this.change({ controller: modes[(modes.indexOf(controller) + 1) % modes.length] ?? controller });
  }

  private shortcut(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.repeat || event.ctrlKey || event.metaKey || event.altKey || /^(INPUT|SELECT|TEXTAREA)$/.test(target.tagName)) return;
    const modes: Record<string, Mode> = { Digit1: "tip", Digit2: "lever", Digit3: "height" };
    const mode = modes[event.code];
    if (event.code === "KeyP") this.pause(!this.paused);
    else if (event.code === "Digit0") this.reset();
    else if (this.run) return;
    else if (event.code === "KeyX") this.bePrecise(!this.sticks.precise);
    else if (event.code === "KeyG" && this.description?.controller === "tip") this.aim(!this.aiming);
    else if (event.code === "Escape") this.aiming ? this.aim(false) : this.dropGoal();
    else if (mode) this.description?.controllers.includes(mode) && this.change({ controller: mode });
    else if (event.code === "Space" && !/^(BUTTON|SUMMARY)$/.test(target.tagName)) {
      event.preventDefault();
      this.grip();
    }
  }
}

keepOffline();
void firstRequest(USUAL).then(
  ({ request, run }) => new CockpitPage(request, run ?? null),
  (error: Error) => new CockpitPage(USUAL).refuse(error.message),
);
