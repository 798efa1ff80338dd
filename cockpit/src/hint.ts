/** What to do first, told until it is done. */

import { make } from "./elements";

export class Hint {
  private readonly box = make("div", { id: "hint" });

  constructor(room: HTMLElement) {
    this.box.setAttribute("role", "note");
    room.append(this.box);
  }

  /** For one stick of the tip, or a lever per cylinder. */
  show(tip: boolean): void {
    const keys = window.matchMedia("(hover: hover)").matches ? `, or hold ${tip ? "an arrow key" : "Q or A"}` : "";
    const what = `Drag ${tip ? "the stick" : "a lever"} below${keys}:`;
    const does = tip ? "the tip of the crane goes where it points." : "each lever moves one cylinder.";
    this.box.replaceChildren(make("b", {}, what), make("span", {}, does));
  }

  /** Whoever has moved a stick knows. */
  see(axes: number[]): void {
    if (axes.some((axis) => axis !== 0)) this.hide();
  }

  hide(): void {
    this.box.remove();
    document.body.classList.add("driven");
  }
}
