/** A drive in the address of the page: its scenario, compressed, behind the `#`, so that no server ever sees it. */

const MARK = "drive=";
/** Longest address that browsers and mail programs can be trusted with. */
const LONGEST = 60_000;

async function through(bytes: Uint8Array<ArrayBuffer>, stream: CompressionStream | DecompressionStream): Promise<Uint8Array> {
  const flow = new Blob([bytes]).stream().pipeThrough(stream);
  return new Uint8Array(await new Response(flow).arrayBuffer());
}

/** The address for a scenario, or null where it would be too long. */
export async function linkOf(scenario: string): Promise<string | null> {
  const packed = await through(new TextEncoder().encode(scenario), new CompressionStream("deflate-raw"));
  let letters = "";
  packed.forEach((byte) => (letters += String.fromCharCode(byte)));
  const text = btoa(letters).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
  const address = `${location.origin}${location.pathname}#${MARK}${text}`;
  return address.length > LONGEST ? null : address;
}

/** The scenario of an address, null where it has none; an error where what it has is nonsense. */
export async function scenarioOf(hash: string): Promise<string | null> {
  const text = hash.replace(/^#/, "");
  if (!text.startsWith(MARK)) return null;
  try {
    const letters = atob(text.slice(MARK.length).replaceAll("-", "+").replaceAll("_", "/"));
    const packed = Uint8Array.from(letters, (letter) => letter.charCodeAt(0));
    return new TextDecoder("utf-8", { fatal: true }).decode(await through(packed, new DecompressionStream("deflate-raw")));
  } catch {
    throw new Error("The link holds no drive that can be read; was it cut short?");
  }
}
