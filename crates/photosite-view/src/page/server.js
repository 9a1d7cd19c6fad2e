// What the server is asked, and what it answers.

/** An answer that is an error: its message, what to do, and whether tracing anew would help. */
export class Refused extends Error {
  constructor({ message, help, needs_trace }, status) {
    super(message);
    this.help = help;
    this.needsTrace = Boolean(needs_trace);
    this.status = status;
  }
}

async function asked(path, options) {
  const answer = await fetch(path, options);
  if (answer.ok) return answer;
  const text = await answer.text();
  let error = { message: text.trim() || `the server answers with ${answer.status}` };
  try { error = JSON.parse(text); } catch { /* words alone */ }
  throw new Refused(error, answer.status);
}

export const about = async () => (await asked("about")).json();
export const pixel = async query => (await asked("pixel?" + new URLSearchParams(query))).json();
export const noise = async query => (await asked("noise?" + new URLSearchParams(query))).json();
export const capture = async query => (await asked("capture?" + new URLSearchParams(query))).text();

/** Pauses, continues, stops tracing, or starts it with changes to the capture, of a frame. */
export const order = (what, changes, frame) => asked("trace", {
  method: "POST",
  headers: { "content-type": "application/json" },
  body: JSON.stringify(changes ? { do: what, changes, frame } : { do: what }),
});

export const sheet = async () => (await asked("sheet")).json();
export const overlays = async number => (await asked(`overlays?input=${number}`)).json();

/** An image of a contact sheet, whole or of one of its widths. */
export async function image(number, width) {
  const answer = await asked(`image?input=${number}${width ? `&width=${width}` : ""}`);
  return createImageBitmap(await answer.blob(), { colorSpaceConversion: "none" });
}

const KINDS = { u8: Uint8Array, u16: Uint16Array, f32: Float32Array };

/** An image: its description with its `values`, row by row, the channels of a pixel together. */
export async function picture(query) {
  const bytes = await (await asked("picture?" + new URLSearchParams(query))).arrayBuffer();
  const length = new DataView(bytes).getUint32(0, true);
  const description = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const Kind = KINDS[description.type];
  const count = description.width * description.height * description.channels.length;
  return { ...description, values: new Kind(bytes, 4 + length, count) };
}
