/** Files that somebody chooses. */

import { make } from "./elements";

/** Largest file that is read, bytes. */
const LARGEST = 8_000_000;
/** Files that are read at once: a scenario, its machine, its logs. */
const MOST_FILES = 8;

type Files = { name: string; text: string }[];

/** A hidden input that hands on the names and texts of the files that somebody chooses. */
export function fileInput(id: string, act: (files: Files) => void, refuse: (message: string) => void): HTMLInputElement {
  const file = make("input", { type: "file", accept: ".toml", id, hidden: true });
  file.addEventListener("change", () => {
    const chosen = [...(file.files ?? [])].slice(0, MOST_FILES);
    file.value = "";
    const large = chosen.find(({ size }) => size > LARGEST);
    if (large) return refuse(`${large.name} has ${(large.size / 1e6).toFixed(0)} MB: a machine or scenario has ${LARGEST / 1e6} MB at most.`);
    void Promise.all(chosen.map(async (one) => ({ name: one.name, text: await one.text() }))).then(act);
  });
  return file;
}

/** `machine`: text of the machine file that the scenario names, and `logs` those of its logs, where they were chosen with it. */
type Replay = (scenario: string, machine: string | null, logs: Record<string, string>) => void;

/** A hidden input for a scenario to be replayed, with its machine file and its logs. */
export function driveInput(act: Replay, refuse: (message: string) => void): HTMLInputElement {
  const replay = (files: Files): void => {
    const tables = files.filter(({ name }) => /\.toml$/i.test(name));
    const scenario = tables.find(({ text }) => /^\s*\[scenario\]/m.test(text)) ?? tables[0];
    if (!scenario) return refuse("There is no scenario among these files: choose one whose name ends in .toml.");
    const machine = tables.find((other) => other !== scenario);
    const logs = files.filter((file) => !tables.includes(file)).map(({ name, text }): [string, string] => [name, text]);
    act(scenario.text, machine?.text ?? null, Object.fromEntries(logs));
  };
  const file = fileInput("drive-file", replay, refuse);
  file.multiple = true;
  file.accept += ",.csv,.tsv,.txt,.dat,.log";
  return file;
}
