/** What to do first, told until it is done. */

import { make } from "./elements";
import { key } from "./keys";
import { LEVER_KEYS } from "./sticks";

export class Hint {
  private readonly box = make("div", { id: "hint" });

  constructor(room: HTMLElement) {
    this.box.setAttribute("role", "note");
    room.prepend(this.box);
  }

  /** For one stick of the tip, or a lever per cylinder. */
  show(tip: boolean): void {
    const [less, more] = LEVER_KEYS[0]!;
    const which = tip ? ["an arrow key"] : [key("span", more), " or ", key("span", less)];
    const keys = window.matchMedia("(hover: hover)").matches ? [", or hold ", ...which] : [];
    const does = tip ? "The tip of the crane moves where it points." : "Each lever moves one cylinder.";
    this.box.replaceChildren(make("b", {}, `Drag ${tip ? "the stick" : "a lever"}`, ...keys, "."), " ", make("span", {}, does));
  }

  /** Whoever has moved a stick knows. */
  see(axes: number[]): void {
    if (axes.some((axis) => axis !== 0)) this.hide();
  }

  hide(): void {
    this.box.classList.add("done");
    document.body.classList.add("driven");
  }
}
