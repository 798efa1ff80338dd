/** Small makers of page elements. */

type Children = (Node | string)[];

export function make<K extends keyof HTMLElementTagNameMap>(
  tag: K,
  properties: Partial<HTMLElementTagNameMap[K]> = {},
  ...children: Children
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  Object.assign(element, properties);
  element.append(...children);
  return element;
}

/** A button is called what it shows, with `title` as a further word; one that shows a mark alone is called `title`. */
export function button(text: string, title: string, act: () => void, className = ""): HTMLButtonElement {
  const made = make("button", { type: "button", title, className }, text);
  if (!/\p{Letter}/u.test(text)) made.setAttribute("aria-label", title);
  made.addEventListener("click", ({ detail }) => {
    // Whoever clicks with a pointer steers with the keys afterwards.
    if (detail > 0) made.blur();
    act();
  });
  return made;
}

/** Something to set, which shows another value when it is told one, unless somebody is setting it. */
export interface Knob<T> {
  room: HTMLElement;
  set: (value: T) => void;
}

/** Rest of the keys after which what they have set counts, ms. */
const REST = 250;

/**
 * Acts at once on what a pointer sets and hands the keys back to the sticks. What keys set counts when they rest, and the
 * focus stays, so that the next key does not move the crane. Answers whether something is still to count.
 */
function settle(input: HTMLInputElement | HTMLSelectElement, act: () => void): () => boolean {
  let [byKeys, waits] = [false, 0];
  input.addEventListener("keydown", () => (byKeys = true));
  input.addEventListener("pointerdown", () => (byKeys = false));
  input.addEventListener("change", () => {
    clearTimeout(waits);
    const count = (): void => {
      waits = 0;
      act();
    };
    if (byKeys) waits = window.setTimeout(count, REST);
    else {
      input.blur();
      count();
    }
  });
  return () => waits !== 0;
}

/** `label` is the name by which a knob is found again when others take the place of those around it. */
function field(label: string, input: HTMLInputElement | HTMLSelectElement, ...beside: Children): HTMLElement {
  input.dataset["key"] = label;
  return make("label", { className: "field" }, make("span", {}, label, ...beside), input);
}

export function choice<T extends string>(label: string, options: [T, string][], chosen: T, act: (value: T) => void): Knob<T> {
  const select = make("select");
  options.forEach(([value, text]) => select.add(new Option(text, value, value === chosen, value === chosen)));
  const waits = settle(select, () => act(select.value as T));
  return { room: field(label, select), set: (value) => waits() || (select.value = value) };
}

export interface Range {
  least: number;
  most: number;
  step: number;
  value: number;
  show: (value: number) => string;
}

/** A slider that shows its value while it moves and acts when it rests; it shows a value beyond its ends as it is. */
export function slider(label: string, range: Range, act: (value: number) => void): Knob<number> {
  const output = make("output");
  const input = make("input", { type: "range", min: String(range.least), max: String(range.most), step: String(range.step) });
  const show = (value: number): void => {
    output.textContent = range.show(value);
    input.setAttribute("aria-valuetext", range.show(value));
  };
  const waits = settle(input, () => act(Number(input.value)));
  input.addEventListener("input", () => show(Number(input.value)));
  const set = (value: number): void => {
    if (waits()) return;
    input.value = String(value);
    show(value);
  };
  set(range.value);
  return { room: field(label, input, output), set };
}

/** A number with its unit; what is none is not handed on. */
export function number(label: string, unit: string, value: number, act: (value: number) => void): Knob<number> {
  const input = make("input", { type: "number", step: "any" });
  const waits = settle(input, () => Number.isFinite(input.valueAsNumber) && act(input.valueAsNumber));
  const set = (now: number): void => {
    if (!waits() && document.activeElement !== input) input.value = String(Number(now.toPrecision(6)));
  };
  input.dataset["key"] = label;
  set(value);
  return { room: make("label", { className: "gain" }, make("span", {}, label), input, make("small", {}, unit)), set };
}

/** Offers text as a file. */
export function download(name: string, text: string, type = "text/plain"): void {
  const link = make("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
