/** The compiled core: numbers and texts in and out of its memory. */

import type { Description, News, Point, Problem, Request } from "./messages";

interface Exports extends WebAssembly.Exports {
  memory: WebAssembly.Memory;
  start(): void;
  input(length: number): number;
  text_at(): number;
  text_length(): number;
  panic_at(): number;
  panic_length(): number;
  open(): void;
  steer(axis: number, deflection: number): void;
  go_to(x: number, z: number): void;
  drop_goal(): void;
  precise(share: number): void;
  carry(mass: number): void;
  advance(ticks: number): number;
  frame(): number;
  show(): number;
  frame_at(): number;
  events(): void;
  save(): void;
}

export class Core {
  private constructor(private readonly wasm: Exports) {
    wasm.start();
  }

  static async load(url: string): Promise<Core> {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`the core cannot be loaded: ${answer.status} ${answer.statusText}`);
    const { instance } = await WebAssembly.instantiate(await answer.arrayBuffer(), {});
    return new Core(instance.exports as Exports);
  }

  open(request: Request): Description | { error: Problem } {
    this.give(new TextEncoder().encode(JSON.stringify(request)));
    this.wasm.open();
    return this.json();
  }

  /** `share` of the full speed counts. */
  steer(axes: number[], share: number): void {
    this.wasm.precise(share);
    axes.forEach((deflection, axis) => this.wasm.steer(axis, deflection));
  }

  /** Sends the tip to a place; answers why it cannot go there. */
  goTo([x, z]: Point): Problem | null {
    this.wasm.go_to(x, z);
    return this.wasm.text_length() ? this.json<{ error: Problem }>().error : null;
  }

  dropGoal(): void {
    this.wasm.drop_goal();
  }

  carry(mass: number): void {
    this.wasm.carry(mass);
  }

  /** Whether the drive goes on after so many milliseconds. */
  advance(ticks: number): boolean {
    return this.wasm.advance(ticks) === 1;
  }

  /** A copy of the row of numbers of this instant. */
  frame(): Float64Array {
    return this.row(this.wasm.frame());
  }

  /** The row of a recorded instant: time, payload and the states go in. */
  show(recorded: number[]): Float64Array {
    this.give(new Uint8Array(new Float64Array(recorded).buffer));
    return this.row(this.wasm.show());
  }

  events(): News {
    this.wasm.events();
    return this.json();
  }

  save(): { saved: string } | { error: Problem } {
    this.wasm.save();
    return this.json();
  }

  /** Why the core stopped, where it says so. */
  panic(): string {
    return this.text(this.wasm.panic_at(), this.wasm.panic_length());
  }

  private give(bytes: Uint8Array): void {
    // Asking for room can move the memory.
    const at = this.wasm.input(bytes.length);
    new Uint8Array(this.wasm.memory.buffer, at, bytes.length).set(bytes);
  }

  private row(length: number): Float64Array {
    return new Float64Array(this.wasm.memory.buffer, this.wasm.frame_at(), length).slice();
  }

  private json<T>(): T {
    return JSON.parse(this.text(this.wasm.text_at(), this.wasm.text_length())) as T;
  }

  private text(at: number, length: number): string {
    return new TextDecoder().decode(new Uint8Array(this.wasm.memory.buffer, at, length));
  }
}
