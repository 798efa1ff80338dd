/** The rows of the last minutes, for charts and for data files. */

import type { Signal } from "./messages";

/** Rows kept: two minutes at 100 a second. */
const MOST = 12000;

export class History {
  signals: Signal[] = [];
  private index = new Map<string, number>();
  private rows: Float64Array[] = [];

  begin(signals: Signal[], keep: boolean): void {
    const same = keep && signals.length === this.signals.length && signals.every((s, i) => s.name === this.signals[i]?.name);
    this.signals = signals;
    this.index = new Map(signals.map((signal, i) => [signal.name, i]));
    if (!same) this.rows = [];
  }

  add(rows: Float64Array, width: number): void {
    for (let at = 0; at < rows.length; at += width) this.rows.push(rows.subarray(at, at + width));
    // Dropped many at a time: moving the rest is dear.
    if (this.rows.length > 1.2 * MOST) this.rows.splice(0, this.rows.length - MOST);
  }

  at(name: string): number {
    return this.index.get(name) ?? -1;
  }

  get length(): number {
    return this.rows.length;
  }

  /** Time of the newest row, s. */
  get last(): number {
    return this.rows.at(-1)?.[0] ?? 0;
  }

  /** Columns of signals from time `from` (s) on, every `stride`-th row; null where a signal has no value. */
  columns(names: string[], from: number, stride: number, scales: number[]): (number | null)[][] {
    const places = names.map((name) => this.at(name));
    let first = this.rows.length;
    while (first > 0 && this.rows[first - 1]![0]! >= from) first--;
    const columns: (number | null)[][] = names.map(() => []);
    for (let r = first - (first % stride); r < this.rows.length; r += stride) {
      const row = this.rows[Math.max(r, 0)]!;
      places.forEach((place, c) => {
        const value = (row[place] ?? NaN) * scales[c]!;
        columns[c]!.push(Number.isFinite(value) ? value : null);
      });
    }
    return columns;
  }

  /** Everything that is kept, as a table with units in its head. */
  csv(): string {
    const heads = this.signals.map(({ name, unit }) => (unit ? `${name} [${unit}]` : name));
    const lines = this.rows.map((row) => Array.from(row.subarray(0, this.signals.length)).join(","));
    return [heads.join(","), ...lines, ""].join("\n");
  }
}
