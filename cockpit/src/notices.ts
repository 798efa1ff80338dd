/** Messages over the picture: what happened, what is doubtful, what went wrong. */

import { button, make } from "./elements";
import type { Occurrence } from "./messages";

/** Messages on the screen at once. */
const MOST = 4;
/** Time that what happened is shown, ms. */
const LIFE = 6000;

type Kind = "info" | "warning" | "error";

export class Notices {
  constructor(private readonly room: HTMLElement) {}

  /** `life`: ms, or 0 until somebody closes it. */
  tell(text: string, kind: Kind, life: number): HTMLElement {
    const box = make("div", { className: `notice ${kind}` }, make("pre", {}, text));
    box.append(button("×", "Close this message", () => box.remove()));
    this.room.append(box);
    while (this.room.childElementCount > MOST) this.room.firstElementChild?.remove();
    if (life) setTimeout(() => box.remove(), life);
    return box;
  }

  /** What has happened on a drive. A warning stays until it is closed, once per kind. */
  happened(events: Occurrence[]): void {
    for (const event of events.slice(-MOST)) {
      const { time, text, warning, cure } = event;
      if (!warning) {
        this.tell(`${time.toFixed(2)} s: ${text}`, "info", LIFE);
        continue;
      }
      [...this.room.children].find((box) => box.getAttribute("data-warning") === warning)?.remove();
      const box = this.tell(`${time.toFixed(2)} s: ${text}${cure ? `\n${cure}` : ""}`, "warning", 0);
      box.dataset["warning"] = warning;
      box.querySelector("pre")!.prepend(make("b", {}, "⚠ Warning"), " ");
    }
  }

  /** Warnings stay on a drive that goes on. */
  clear(fresh: boolean): void {
    [...this.room.children].forEach((box) => (fresh || !box.classList.contains("warning")) && box.remove());
  }
}
