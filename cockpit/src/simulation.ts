/** The worker that simulates, watched: one that does not answer is ended, and another takes its place. */

import type { FromWorker, ToWorker } from "./messages";

/** Time between two looks at the worker, ms, and looks without a sign of life after which it is ended. A page that sleeps looks
 * seldom, so that it never ends a worker that sleeps with it. */
const LOOK = 500;
const PATIENCE = 16;

export class Simulation {
  private worker: Worker;
  private silent = 0;

  constructor(
    private readonly hear: (message: Exclude<FromWorker, { tell: "alive" | "broken" }>) => void,
    /** Told why a worker was ended; the one after it has no drive yet. */
    private readonly ended: (reason: string) => void,
  ) {
    this.worker = this.begin();
    setInterval(() => this.look(), LOOK);
  }

  send(message: ToWorker, transfer: Transferable[] = []): void {
    this.worker.postMessage(message, transfer);
  }

  private begin(): Worker {
    const worker = new Worker(new URL("./worker.ts", import.meta.url), { type: "module" });
    worker.onmessage = ({ data }: MessageEvent<FromWorker>) => {
      this.silent = 0;
      if (data.tell === "broken") this.renew(data.message);
      else if (data.tell !== "alive") this.hear(data);
    };
    worker.onerror = (event) => this.renew(event.message || "it cannot run here");
    this.silent = 0;
    return worker;
  }

  private look(): void {
    if (++this.silent > PATIENCE) this.renew(`it has not answered for ${(PATIENCE * LOOK) / 1000} s`);
  }

  private renew(reason: string): void {
    this.worker.terminate();
    this.worker.onmessage = this.worker.onerror = null;
    this.worker = this.begin();
    this.ended(reason);
  }
}
