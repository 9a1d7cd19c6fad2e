// What is read off an image: the pixel under the pointer, histograms, profiles, figures of a patch.
import { isColour, scaleOf } from "./colours.js";
import { readable } from "./controls.js";
import { crop, drawHistogram, drawProfile, figures, inWords, seesLight, valuesAt } from "./measure.js";
import * as server from "./server.js";
import { $, isScene, query, refuse, session, sides, stage, state } from "./session.js";

/** Pixels that are measured at most; of larger images every few of them. */
const MOST = 1 << 20;

/** Values at the ends of the colours. */
export const scale = () => [+$("low").value, +$("high").value];

const gcd = (a, b) => b ? gcd(b, a % b) : a;

/** The values of a part of a side's image as they are: those that have come, else such as the server is asked for. */
async function sampled(side, part) {
  const { picture } = side, [x0, y0, x1, y1] = part;
  const whole = picture.step === 1 && picture.width === picture.full[0] && picture.height === picture.full[1];
  if (whole) return crop(picture, part);
  // Every filter of a mosaic is met.
  const tile = picture.raw?.tile ?? [], repeats = [tile.length || 1, tile[0]?.length || 1];
  let step = Math.max(1, Math.ceil(Math.sqrt((x1 - x0) * (y1 - y0) / MOST)));
  while (repeats.some(n => gcd(n, step) > 1)) step++;
  const asked = { ...query(side), view: part.join(","), step };
  const key = JSON.stringify([asked, picture.light, picture.trace]);
  if (side.sample?.key !== key) side.sample = { key, picture: await server.picture(asked) };
  return side.sample.picture;
}

/** Measures wait until no image follows: while a slider moves it is the image that counts. */
let waiting = null;
export function measureSoon() {
  clearTimeout(waiting);
  waiting = setTimeout(measure, 120);
}

let isMeasuring = false, wantsMore = false;
/** Measures what is shown, always the newest. */
export async function measure() {
  if (isMeasuring) { wantsMore = true; return; }
  isMeasuring = true;
  try { await measureOnce(); } catch (error) { refuse(error); }
  isMeasuring = false;
  if (wantsMore) { wantsMore = false; measure(); }
}

async function measureOnce() {
  const side = sides[session.edited], { picture } = side;
  if (!picture) return;
  const [width, height] = picture.full, part = stage.patch ? clipped(stage.patch, picture) : seesLight(picture);
  const plot = $("plot").value, found = await sampled(side, part);
  const range = isColour(picture) ? [0, picture.type === "u16" ? 65536 : picture.type === "u8" ? 256 : 1] : $("auto-scale").checked ? scaleOf(found) : scale();
  if (plot === "histogram" || !stage.pixel) drawHistogram($("graph"), found, range);
  else {
    const [x, y] = stage.pixel, isRow = plot === "row";
    if (x >= 0 && y >= 0 && x < width && y < height) drawProfile($("graph"), await sampled(side, isRow ? [0, y, width, y + 1] : [x, 0, x + 1, height]), isRow);
  }
  const rows = figures(found);
  state.figures = rows;
  const name = stage.patch ? `Patch of ${part[2] - part[0]} × ${part[3] - part[1]} pixels at ${part[0]}, ${part[1]}` : "All pixels";
  const few = found.step > 1 ? `, one in ${found.step} × ${found.step} pixels measured` : "";
  $("figures").textContent = `${name}${few}\n${inWords(rows, picture.unit)}`;
  await Promise.all([tellPixel(), tellNoise(side)]);
}

export const clipped = ([x0, y0, x1, y1], { full: [width, height] }) => [Math.max(x0, 0), Math.max(y0, 0), Math.min(x1, width), Math.min(y1, height)];

/** All that is known of the pixel that was picked. */
async function tellPixel() {
  const side = sides[session.edited];
  if (!stage.pixel || !side.picture) return;
  const [x, y] = stage.pixel;
  // Raw images show the pixels that see no light, too.
  const [ax, ay] = side.plane === "raw" && side.picture.raw ? side.picture.raw.active : [0, 0];
  if (x < ax || y < ay) return;
  const found = await server.pixel({ ...query(side), x: x - ax, y: y - ay });
  state.pixel = found;
  const cell = text => Object.assign(document.createElement("td"), { textContent: text });
  const row = (...texts) => { const made = document.createElement("tr"); made.append(...texts.map(cell)); return made; };
  const rows = [row("Pixel", `${x}, ${y}`)];
  for (const [name, mean, sigma] of found.electrons) rows.push(row(`Electrons ${name}`, `${readable(mean)} e⁻`, sigma === null ? "" : `± ${readable(sigma, 2)}`));
  for (const [name, value] of found.raw ?? []) rows.push(row(`Raw ${name}`, `${value} DN`));
  if (found.developed) rows.push(row("Developed", found.developed.map(([, value]) => value).join(", ")));
  $("pixel").replaceChildren(...rows);
}

/** Noise of the light against that of the sensor, as it is exposed now. */
async function tellNoise(side) {
  if (!isScene(side) || !state.status?.light) return;
  const { noise_ratio } = await server.noise(query(side));
  state.noise = noise_ratio;
  $("noise").textContent = noise_ratio === null ? "" : `Monte Carlo noise: ${readable(noise_ratio, 2)} × that of the sensor`;
}

/** Picks a pixel. */
export function pick(pixel) {
  stage.pixel = pixel;
  stage.draw();
  point(pixel, session.edited);
  measure();
}

/** Says what a pixel of a side shows. */
export function point(pixel, i) {
  const { picture } = sides[i];
  const values = picture && valuesAt(picture, pixel);
  if (!values || state.error) return;
  const mean = picture.is_mean ? `  (mean of ${picture.step} × ${picture.step} pixels)` : "";
  $("readout").textContent = `${stage.split === null ? "" : "AB"[i] + "  "}${pixel[0]}, ${pixel[1]}:  ${values.map(([name, value]) => `${name} ${readable(value)}`).join("  ")}${picture.unit && " " + picture.unit}${mean}`;
}
