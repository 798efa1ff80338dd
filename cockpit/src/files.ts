/** Files that somebody chooses, or drops on the page. */

import { make } from "./elements";
import type { Request } from "./messages";

/** Largest file that is read, bytes. */
const LARGEST = 8_000_000;
/** Files that are read at once: a scenario, its machine with what this extends, its logs. */
const MOST_FILES = 16;
/** The table or key that makes a file a scenario. */
const SCENARIO = /^[ \t]*(\[[ \t]*)?["']?scenario["']?[ \t]*[\].=]/m;

type Texts = [name: string, text: string][];

/** What the files of somebody ask for; an error where that is nothing. */
export async function askedBy(files: Iterable<File>): Promise<Request> {
  const chosen = [...files];
  if (chosen.length > MOST_FILES) throw new Error(`${chosen.length} files: choose ${MOST_FILES} at most, a scenario and what it names.`);
  const large = chosen.find(({ size }) => size > LARGEST);
  if (large) throw new Error(`${large.name} has ${(large.size / 1e6).toFixed(0)} MB: a machine or scenario has ${LARGEST / 1e6} MB at most.`);
  return asked(await Promise.all(chosen.map(read)));
}

async function read(file: File): Promise<[string, string]> {
  try {
    return [file.name, /\.toml$/i.test(file.name) ? await file.text() : decoded(await file.arrayBuffer())];
  } catch {
    throw new Error(`${file.name} cannot be read: choose files, not folders.`);
  }
}

/** The text of a log: UTF-8, UTF-16 with its mark, or else the encoding of older loggers. */
function decoded(bytes: ArrayBuffer): string {
  const [first, second] = new Uint8Array(bytes);
  if (first === 0xff && second === 0xfe) return new TextDecoder("utf-16le").decode(bytes);
  if (first === 0xfe && second === 0xff) return new TextDecoder("utf-16be").decode(bytes);
  try {
    return new TextDecoder("utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

function asked(texts: Texts): Request {
  const tables = texts.filter(([name]) => /\.toml$/i.test(name));
  if (!tables.length) throw new Error("There is no machine and no scenario among these files: choose one whose name ends in .toml.");
  const scenarios = tables.filter(([, text]) => SCENARIO.test(text));
  const [scenario] = scenarios;
  if (scenario) {
    if (scenarios.length > 1) throw new Error(`${listed(scenarios)} are scenarios: choose one of them.`);
    return { scenario: scenario[1], "scenario-name": scenario[0], files: others(texts, scenario) };
  }
  // The machine is the file that no other one extends or includes.
  const named = ([name]: [string, string]): boolean => tables.some(([other, text]) => other !== name && names(text, name));
  const machines = tables.filter((table) => !named(table));
  const [machine] = machines;
  if (!machine || machines.length > 1) throw new Error(`${listed(tables)} are machines: choose one, with the files that it extends.`);
  return { machine: machine[0], text: machine[1], files: others(texts, machine) };
}

function names(text: string, name: string): boolean {
  return [`"${name}"`, `/${name}"`, `'${name}'`, `/${name}'`].some((quoted) => text.includes(quoted));
}

function others(texts: Texts, one: [string, string]): Record<string, string> {
  return Object.fromEntries(texts.filter((other) => other !== one));
}

function listed(texts: Texts): string {
  return texts.map(([name]) => name).join(" and ");
}

/** A hidden input for files. */
export function fileInput(id: string, act: (files: Iterable<File>) => void): HTMLInputElement {
  const file = make("input", { type: "file", accept: ".toml,.csv,.tsv,.txt,.dat,.log", id, hidden: true, multiple: true });
  file.addEventListener("change", () => {
    const chosen = [...(file.files ?? [])];
    file.value = "";
    if (chosen.length) act(chosen);
  });
  return file;
}

/** Takes files that are dropped anywhere on the page. */
export function takeDrops(act: (files: Iterable<File>) => void): void {
  const carries = (event: DragEvent): boolean => event.dataTransfer?.types.includes("Files") ?? false;
  // Without this a browser leaves the page for the file.
  window.addEventListener("dragover", (event) => carries(event) && event.preventDefault());
  window.addEventListener("drop", (event) => {
    if (!carries(event)) return;
    event.preventDefault();
    act([...(event.dataTransfer?.files ?? [])]);
  });
}
