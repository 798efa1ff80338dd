/** What the page opens first: what its address asks for, else the usual crane. */

import { requestOf } from "./link";
import type { Recording, Request } from "./messages";

/** A run to be looked at. */
export interface Run {
  about: Recording;
  table: Float64Array<ArrayBuffer>;
}

/** What the page is to open. */
export interface First {
  request: Request;
  run?: Run;
}

/** What the address asks for: `?machine=NAME`, or `?chosen` for what `hydrocrane live` or `view` lays beside the page. */
export async function firstRequest(usual: Request): Promise<First> {
  const shared = await requestOf(location.hash);
  if (shared) return { request: shared };
  const asked = new URLSearchParams(location.search);
  if (asked.has("chosen")) {
    const answer = await fetch("chosen.json");
    if (answer.ok) return chosen(usual, (await answer.json()) as Request & { recording?: Recording });
  }
  const machine = asked.get("machine");
  return { request: machine ? { ...usual, machine } : usual };
}

async function chosen(usual: Request, { recording, ...request }: Request & { recording?: Recording }): Promise<First> {
  if (!recording) return { request: { ...usual, ...request } };
  const answer = await fetch("recorded.bin");
  if (!answer.ok) throw new Error(`The run cannot be read: ${answer.status} ${answer.statusText}`);
  return { request, run: { about: recording, table: new Float64Array(await answer.arrayBuffer()) } };
}
