/** The simulation beside the page: steps of 1 ms that follow the clock on the wall, whatever the page draws. */

import chainsUrl from "./chains.wasm?url";
import coreUrl from "./core.wasm?url";
import { Core } from "./core";
import type { Description, FromWorker, Pace, Request, ToWorker } from "./messages";
import { Tape } from "./tape";

/** Time between two turns, ms. */
const TURN = 4;
/** Time between two messages, ms. */
const FRAME = 15;
/** Simulated time between two rows of the charts, ms. */
const ROW = 10;
/** Longest computing in one turn, ms. */
const BUDGET = 30;
/** Time that can be made up for, ms; what is owed beyond it is given up. */
const PATIENCE = 200;
/** What is shown of a run before the place where somebody jumps to, s, and rows of it at most. */
const BEFORE = 20;
const BEFORE_ROWS = 2000;
/** Time between two signs of life, ms. */
const ALIVE = 500;
/** Rows of a run in one turn at most: of more, some are left out. */
const TURN_ROWS = 200;
/** Share of its speed below which the clock is late, and share of the time above which computing is why. */
const LATE = 0.95;
const BUSY = 0.5;
/** Silence of the page after which nobody holds the sticks, ms. */
const SILENCE = 400;

const post = (message: FromWorker, transfer: Transferable[] = []): void => self.postMessage(message, { transfer });

class Clockwork {
  private open = false;
  /** The run that is looked at in place of a drive, and how far it is played, s. */
  private tape: Tape | null = null;
  private played = 0;
  /** Whether the rows to come stand alone. */
  private anew = false;
  private speed = 1;
  private paused = false;
  /** The drive has ended. */
  private over = false;
  private endSent = false;
  /** Whether there is something that the page has not been told. */
  private news = false;
  private clock = performance.now();
  private owed = 0;
  /** Ticks since the drive began. */
  private ticks = 0;
  private rows: Float64Array[] = [];
  /** Simulated time of the last row, s. */
  private lastRow = 0;
  private posted = 0;
  private heard = 0;
  private held = false;
  private lost = 0;
  private window = this.newWindow();

  constructor(private core: Core) {
    setInterval(() => this.guarded(() => this.turn()), TURN);
  }

  receive(message: ToWorker): void {
    this.guarded(() => this.obey(message));
  }

  private obey(message: ToWorker): void {
    switch (message.do) {
      case "open":
        return this.enter(message.request, (description) => {
          this.tape = null;
          this.ticks = 0;
          if (description.continued) this.keepRow();
          else [this.rows, this.lastRow, this.lost] = [[], 0, 0];
          this.over = false;
          this.restartClock();
          post({ tell: "opened", description, fresh: !description.continued });
        });
      case "view":
        return this.enter(message.request, (description) => {
          this.tape = new Tape(this.core, description, message.columns, message.table);
          post({ tell: "opened", description: { ...description, "replay-until": this.tape.end }, fresh: true });
          this.seek(this.tape.time(0));
        });
      case "seek":
        return this.seek(message.time);
      case "steer":
        this.heard = performance.now();
        this.held = message.axes.some((axis) => axis !== 0);
        return this.core.steer(message.axes, message.share);
      case "go": {
        const problem = this.core.goTo(message.place);
        if (problem) post({ tell: "refused", problem });
        return;
      }
      case "drop":
        return this.core.dropGoal();
      case "carry":
        return this.core.carry(message.mass);
      case "pace":
        this.speed = message.speed;
        this.paused = message.paused;
        return this.restartClock();
      case "save": {
        const answer = this.core.save();
        if ("error" in answer) return post({ tell: "refused", problem: answer.error });
        return post({ tell: "saved", text: answer.saved, share: message.share });
      }
    }
  }

  /** Opens what is asked for, with the larger core where the one at hand has no laws for so many joints. */
  private enter(request: Request, begin: (description: Description) => void, core = this.core): void {
    const answer = core.open(request);
    if (!("error" in answer)) {
      [this.core, this.open] = [core, true];
      return begin(answer);
    }
    if (answer.error.slug !== "chain" || core !== this.core) return post({ tell: "refused", problem: answer.error });
    Core.load(chainsUrl).then(
      (larger) => this.guarded(() => this.enter(request, begin, larger)),
      (error: Error) => post({ tell: "refused", problem: { message: `${answer.error.message}; ${error.message}` } }),
    );
  }

  private seek(time: number): void {
    if (!this.tape) return;
    this.played = time;
    this.rows = this.tape.seek(time, BEFORE, BEFORE_ROWS);
    this.anew = true;
    this.restartClock();
  }

  /** The row of the instant: changes wait for the next sample, which the clock has then passed. */
  private keepRow(): void {
    const row = this.core.frame();
    if (row[0]! > this.lastRow) this.rows.push(row);
    this.lastRow = row[0]!;
  }

  private restartClock(): void {
    this.clock = performance.now();
    this.owed = 0;
    this.window = this.newWindow();
    this.news = true;
  }

  private newWindow(): { began: number; ticks: number; busy: number; pace: Omit<Pace, "lost"> } {
    return { began: performance.now(), ticks: 0, busy: 0, pace: { factor: null, slow: false, load: 0 } };
  }

  private turn(): void {
    const now = performance.now();
    const passed = now - this.clock;
    this.clock = now;
    if (!this.open) return;
    if (this.held && now - this.heard > SILENCE) this.letGo();
    const goes = !this.paused && !this.over;
    if (goes && this.tape) this.play(this.tape, passed * this.speed);
    else if (goes) this.catchUp(passed * this.speed, now);
    if (this.news && now - this.posted >= FRAME) this.report(now);
  }

  /** Nobody holds the sticks any more: they spring back. */
  private letGo(): void {
    this.held = false;
    this.core.steer(Array<number>(8).fill(0), 1);
  }

  private play(tape: Tape, passed: number): void {
    const before = this.played;
    this.played = Math.min(before + passed / 1000, tape.end);
    const rows = tape.play(this.played, TURN_ROWS);
    this.rows.push(...rows);
    this.news ||= this.played > before;
    this.window.ticks += 1000 * (this.played - before);
  }

  private catchUp(passed: number, now: number): void {
    this.owed += passed;
    if (this.owed > PATIENCE) {
      this.lost += (this.owed - PATIENCE) / 1000;
      this.owed = PATIENCE;
    }
    while (this.owed >= 1 && performance.now() - now < BUDGET) {
      const ticks = Math.min(Math.floor(this.owed), ROW - (this.ticks % ROW));
      this.news = true;
      this.over = !this.core.advance(ticks);
      if (this.over) break;
      this.ticks += ticks;
      this.owed -= ticks;
      this.window.ticks += ticks;
      if (this.ticks % ROW === 0) this.keepRow();
    }
    this.window.busy += performance.now() - now;
  }

  private report(now: number): void {
    this.posted = now;
    this.news = false;
    const latest = this.tape ? this.tape.frame() : this.core.frame();
    const width = latest.length;
    const history = new Float64Array(this.rows.length * width);
    this.rows.forEach((row, i) => history.set(row, i * width));
    this.rows = [];
    const pace = { ...this.measurePace(now), lost: this.lost };
    const { events, ended, replaying, changed } = this.core.events();
    if (changed) post({ tell: "opened", description: changed, fresh: false });
    const anew = this.anew;
    this.anew = false;
    post({ tell: "rows", latest, history, width, pace, replaying, anew }, [latest.buffer, history.buffer]);
    const end = this.endSent ? null : ended;
    this.endSent = ended !== null;
    if (events.length || end) post({ tell: "happened", events, ended: end });
  }

  private measurePace(now: number): Omit<Pace, "lost"> {
    const span = now - this.window.began;
    if (span > 1000) {
      const [factor, load] = [this.window.ticks / span, this.window.busy / span];
      const slow = factor < LATE * this.speed && load > BUSY;
      this.window = { ...this.newWindow(), pace: { factor, slow, load } };
    }
    return this.window.pace;
  }

  /** A trap of the core is a message too. */
  private guarded(act: () => void): void {
    try {
      act();
    } catch (error) {
      this.open = false;
      const reason = this.core.panic() || (error instanceof Error ? error.message : String(error));
      post({ tell: "broken", message: reason });
    }
  }
}

setInterval(() => post({ tell: "alive" }), ALIVE);
const waiting: ToWorker[] = [];
let clockwork: Clockwork | null = null;
self.onmessage = (event: MessageEvent<ToWorker>) => (clockwork ? clockwork.receive(event.data) : waiting.push(event.data));

Core.load(coreUrl).then(
  (core) => {
    clockwork = new Clockwork(core);
    waiting.forEach((message) => clockwork?.receive(message));
  },
  (error: unknown) => post({ tell: "broken", message: error instanceof Error ? error.message : String(error) }),
);
