/** What to do first, told until it is done. */

import { make } from "./elements";
import { key } from "./keys";
import { LEVER_KEYS } from "./sticks";

export class Hint {
  private readonly box = make("div", { id: "hint" });

  constructor(room: HTMLElement) {
    this.box.setAttribute("role", "note");
    room.append(this.box);
  }

  /** For one stick of the tip, or a lever per cylinder. */
  show(tip: boolean): void {
    const [less, more] = LEVER_KEYS[0]!;
    const which = tip ? ["an arrow key"] : [key("span", more), " or ", key("span", less)];
    const keys = window.matchMedia("(hover: hover)").matches ? [", or hold ", ...which] : [];
    const does = tip ? "the tip of the crane goes where it points." : "each lever moves one cylinder.";
    this.box.replaceChildren(
      make("b", {}, `Drag ${tip ? "the stick" : "a lever"} below`, ...keys, ":"),
      make("span", {}, does),
    );
  }

  /** Whoever has moved a stick knows. */
  see(axes: number[]): void {
    if (axes.some((axis) => axis !== 0)) this.hide();
  }

  hide(): void {
    if (!this.box.isConnected) return;
    this.box.remove();
    document.body.classList.add("driven");
  }
}
