/** What is printed on the keys of the keyboard at hand: keys are told by their place, and layouts print other letters there. */

import { make } from "./elements";

interface Layout {
  get(code: string): string | undefined;
}

const ARROWS: Record<string, string> = { ArrowLeft: "←", ArrowRight: "→", ArrowUp: "↑", ArrowDown: "↓" };
const printed = new Map<string, string>();

export const keyName = (code: string): string => printed.get(code) ?? ARROWS[code] ?? code.replace(/^(Key|Digit)/, "");

/** The name of a key, which changes when more is known of the keyboard. */
export function key<K extends "kbd" | "span">(tag: K, code: string): HTMLElementTagNameMap[K] {
  const made = make(tag, {}, keyName(code));
  made.dataset["code"] = code;
  return made;
}

function learn(code: string, letter: string | undefined): void {
  if (!letter || letter.length !== 1 || !code.startsWith("Key") || printed.get(code) === letter.toUpperCase()) return;
  printed.set(code, letter.toUpperCase());
  document.querySelectorAll<HTMLElement>(`[data-code="${code}"]`).forEach((made) => (made.textContent = keyName(code)));
}

/** Asks the browser for the layout; where it does not tell, each key that is pressed tells its own letter. */
export function learnKeys(codes: string[]): void {
  const board = (navigator as Navigator & { keyboard?: { getLayoutMap?: () => Promise<Layout> } }).keyboard;
  board?.getLayoutMap?.().then(
    (layout) => codes.forEach((code) => learn(code, layout.get(code))),
    () => undefined,
  );
  window.addEventListener("keydown", (event) => {
    if (!event.ctrlKey && !event.altKey && !event.metaKey) learn(event.code, event.key);
  });
}
