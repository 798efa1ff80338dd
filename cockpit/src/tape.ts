/** A recorded run as rows of the page: what it recorded, and around it what the core draws. */

import type { Core } from "./core";
import type { Description } from "./messages";

export class Tape {
  readonly length: number;
  private readonly width: number;
  /** Columns of time, payload and the states. */
  private readonly inputs: number[];
  /** Column and signal of everything that was recorded and is shown. */
  private readonly shown: [number, number][];
  private at = 0;

  constructor(
    private readonly core: Core,
    description: Description,
    columns: string[],
    private readonly table: Float64Array,
  ) {
    this.width = columns.length;
    this.length = Math.floor(table.length / this.width);
    const names = ["time", "payload", ...description.states];
    this.inputs = names.map((name) => columns.indexOf(name));
    const lost = names.find((_, i) => this.inputs[i]! < 0);
    if (lost !== undefined || !this.length) throw new Error(`The run has no ${lost ?? "rows"}, so that it cannot be drawn.`);
    const signals = description.signals.map(({ name }) => name);
    const places = columns.map((name, column): [number, number] => [column, signals.indexOf(name)]);
    this.shown = places.filter(([, signal]) => signal >= 0);
  }

  get end(): number {
    return this.time(this.length - 1);
  }

  time(row: number): number {
    return this.table[row * this.width]!;
  }

  /** The row at hand, as the page takes it. */
  frame(row = this.at): Float64Array {
    const recorded = this.table.subarray(row * this.width, (row + 1) * this.width);
    const frame = this.core.show(this.inputs.map((column) => recorded[column]!));
    for (const [column, signal] of this.shown) frame[signal] = recorded[column]!;
    return frame;
  }

  /** Goes on to a time (s) and tells the rows on the way, at most so many. */
  play(until: number, most: number): Float64Array[] {
    const first = this.at + 1;
    while (this.at + 1 < this.length && this.time(this.at + 1) <= until) this.at++;
    return this.between(first, most);
  }

  private between(first: number, most: number): Float64Array[] {
    if (first > this.at) return [];
    const stride = Math.max(1, Math.ceil((this.at - first) / most));
    const rows: Float64Array[] = [];
    for (let row = first; row < this.at; row += stride) rows.push(this.frame(row));
    return [...rows, this.frame()];
  }

  /** Goes to a time (s) and tells the rows of the `span` (s) before it, at most so many. */
  seek(time: number, span: number, most: number): Float64Array[] {
    this.at = 0;
    while (this.at + 1 < this.length && this.time(this.at + 1) <= time) this.at++;
    let first = this.at;
    while (first > 0 && this.time(first - 1) >= time - span) first--;
    return this.between(first, most);
  }
}
