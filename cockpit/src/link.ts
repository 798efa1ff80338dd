/**
 * A drive in the address of the page: its scenario, with the machine file where it is one of somebody's own, compressed,
 * behind the `#`, so that no server ever sees it.
 */

import type { Request } from "./messages";

const MARK = "drive=";
/** Longest address that browsers and mail programs can be trusted with. */
const LONGEST = 60_000;

/** Longest address that is read, letters, and longest text that one unpacks to, bytes: hours of driving. */
const LONGEST_READ = 400_000;
const MOST_TEXT = 8_000_000;

class TooLong extends Error {}

/** What comes out of a stream, at most so many bytes: a little text can unpack to a thousand times its size. */
async function through(
  bytes: Uint8Array<ArrayBuffer>,
  stream: CompressionStream | DecompressionStream,
  most = Infinity,
): Promise<Uint8Array> {
  const reader = new Blob([bytes]).stream().pipeThrough(stream).getReader();
  const parts: Uint8Array<ArrayBuffer>[] = [];
  let length = 0;
  for (let part = await reader.read(); !part.done; part = await reader.read()) {
    length += part.value.length;
    if (length > most) {
      await reader.cancel();
      throw new TooLong();
    }
    parts.push(part.value);
  }
  return new Uint8Array(await new Blob(parts).arrayBuffer());
}

/** The address for a scenario and the file of its machine, if any; an error where it would be too long. */
export async function linkOf(scenario: string, files: Record<string, string>): Promise<string> {
  const alone = !Object.keys(files).length;
  const whole = alone ? scenario : JSON.stringify({ scenario, files });
  const packed = await through(new TextEncoder().encode(whole), new CompressionStream("deflate-raw"));
  let letters = "";
  packed.forEach((byte) => (letters += String.fromCharCode(byte)));
  const text = btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  const address = `${location.origin}${location.pathname}#${MARK}${text}`;
  if (address.length <= LONGEST) return address;
  const [size, most] = [address.length, LONGEST].map((letters) => `${Math.ceil(letters / 1000)} kB`);
  const what = alone ? "The drive is" : "The drive with its machine file is";
  const cure = alone ? "send the file" : "send it with the machine file";
  throw new Error(`${what} too long for a link: ${size}, where ${most} are safe. Save the scenario and ${cure}.`);
}

/** What an address asks for, null where it has no drive; an error where what it has is nonsense. */
export async function requestOf(hash: string): Promise<Request | null> {
  const text = hash.replace(/^#/, "");
  if (!text.startsWith(MARK)) return null;
  const tooLong = "The link is longer than any drive that can be shared: ask for the scenario file and open it with Replay …";
  if (text.length > LONGEST_READ) throw new Error(tooLong);
  try {
    const letters = atob(text.slice(MARK.length).replaceAll("-", "+").replaceAll("_", "/"));
    const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    const whole = new TextDecoder("utf-8", { fatal: true }).decode(await through(packed, new DecompressionStream("deflate-raw"), MOST_TEXT));
    if (!whole.startsWith("{")) return { scenario: whole };
    const both = JSON.parse(whole) as Record<string, unknown>;
    const files = Object.entries(both["files"] as object).map(([name, text]) => [name, String(text)]);
    return { scenario: String(both["scenario"]), files: Object.fromEntries(files) as Record<string, string> };
  } catch (error) {
    if (error instanceof TooLong) throw new Error(tooLong);
    throw new Error("The link holds no drive that can be read; was it cut short?");
  }
}
