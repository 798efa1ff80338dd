// The compiled core without a page: numbers and texts in and out of its memory.
import { readFileSync } from "node:fs";

/** Loads the core from a file. */
export async function load(path) {
  const { instance } = await WebAssembly.instantiate(readFileSync(path), {});
  const core = instance.exports;
  core.start();
  const text = () =>
    JSON.parse(new TextDecoder().decode(new Uint8Array(core.memory.buffer, core.text_at(), core.text_length())));
  /** The numbers of the instant. */
  const row = () => {
    const length = core.frame();
    return new Float64Array(core.memory.buffer, core.frame_at(), length).slice();
  };
  /** Begins a drive, or goes on under other settings; what there is to see, or the error. */
  const open = (request) => {
    const bytes = new TextEncoder().encode(JSON.stringify(request));
    // Asking for room can move the memory.
    const room = core.input(bytes.length);
    new Uint8Array(core.memory.buffer, room, bytes.length).set(bytes);
    core.open();
    return text();
  };
  return { core, text, row, open };
}
