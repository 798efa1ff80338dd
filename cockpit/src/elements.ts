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

export function button(text: string, title: string, act: () => void, className = ""): HTMLButtonElement {
  const made = make("button", { type: "button", title, className }, text);
  made.setAttribute("aria-label", title);
  made.addEventListener("click", act);
  return made;
}

export function choice(label: string, options: [string, string][], chosen: string, act: (value: string) => void): HTMLElement {
  const select = make("select");
  options.forEach(([value, text]) => select.add(new Option(text, value, value === chosen, value === chosen)));
  select.addEventListener("change", () => {
    // The keys are the sticks' again.
    select.blur();
    act(select.value);
  });
  return make("label", { className: "field" }, make("span", {}, label), select);
}

export interface Range {
  least: number;
  most: number;
  step: number;
  value: number;
  show: (value: number) => string;
}

/** A slider that shows its value while it moves and acts when it rests. */
export function slider(label: string, range: Range, act: (value: number) => void): HTMLElement {
  const value = make("output", {}, range.show(range.value));
  const input = make("input", {
    type: "range",
    min: String(range.least),
    max: String(range.most),
    step: String(range.step),
    value: String(range.value),
  });
  input.addEventListener("input", () => (value.textContent = range.show(Number(input.value))));
  input.addEventListener("change", () => {
    input.blur();
    act(Number(input.value));
  });
  return make("label", { className: "field" }, make("span", {}, label, value), input);
}

/** Offers text as a file. */
export function download(name: string, text: string, type = "text/plain"): void {
  const link = make("a", { href: URL.createObjectURL(new Blob([text], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
