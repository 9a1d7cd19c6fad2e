// Histograms, profiles and figures of patches.
import { readable } from "./controls.js";

const INKS = { R: "#e5484d", G: "#30a46c", B: "#3e7bfa", W: "#a0a3a8", Y: "#a0a3a8" };
const ink = (name, i) => INKS[name[0]] ?? ["#8e4ec6", "#12a594", "#f76b15", "#0090ff"][i % 4];

/** The values of a picture by channel: those of a mosaic by its filters, without the pixels that see no light. */
function channels(picture, [x0, y0, x1, y1]) {
  const { width, values, channels: names, raw } = picture;
  const tile = picture.plane === "raw" && raw ? raw.tile : [];
  const found = new Map();
  const n = names.length;
  for (let y = y0; y < y1; y++) {
    for (let x = x0; x < x1; x++) {
      for (let c = 0; c < n; c++) {
        const name = tile.length ? tile[y % tile.length][x % tile[0].length] : names[c];
        if (!found.has(name)) found.set(name, []);
        const value = values[(y * width + x) * n + c];
        if (Number.isFinite(value)) found.get(name).push(value);
      }
    }
  }
  return found;
}

/** All of a picture but, of a raw one, the pixels that see no light. */
export function area(picture) {
  const { width, height, raw, plane } = picture;
  if (plane !== "raw" || !raw) return [0, 0, width, height];
  const [x, y, w, h] = raw.active;
  return [x, y, x + w, y + h];
}

function moments(values) {
  let sum = 0;
  for (const v of values) sum += v;
  const mean = sum / values.length;
  let squares = 0;
  for (const v of values) squares += (v - mean) ** 2;
  return [mean, Math.sqrt(squares / Math.max(values.length - 1, 1))];
}

/** Mean, standard deviation and signal-to-noise ratio of each channel of a patch. */
export function figures(picture, patch) {
  const black = picture.plane === "raw" && picture.raw ? picture.raw.black_dn : 0;
  const rows = [];
  for (const [name, values] of channels(picture, patch)) {
    if (!values.length) continue;
    const [mean, sd] = moments(values);
    let min = Infinity, max = -Infinity;
    for (const v of values) { if (v < min) min = v; if (v > max) max = v; }
    rows.push({ name, mean, sd, min, max, snr: sd > 0 ? (mean - black) / sd : Infinity, count: values.length });
  }
  return rows;
}

/** The same in words. */
export function inWords(rows, unit) {
  return rows.map(({ name, mean, sd, snr, min, max }) =>
    `${name}: mean ${readable(mean)}${unit && " " + unit}, σ ${readable(sd)}, SNR ${Number.isFinite(snr) ? readable(snr, 3) + ` (${readable(20 * Math.log10(Math.abs(snr)), 3)} dB)` : "∞"}, ${readable(min)} … ${readable(max)}`).join("\n");
}

function plot(canvas, curves, labels, low, high, range) {
  const context = canvas.getContext("2d");
  const ratio = window.devicePixelRatio || 1, [width, height] = [canvas.clientWidth, canvas.clientHeight];
  [canvas.width, canvas.height] = [width * ratio, height * ratio];
  context.scale(ratio, ratio);
  const style = getComputedStyle(canvas);
  for (const { name, points, index } of curves) {
    context.strokeStyle = ink(name, index);
    context.lineWidth = 1.5;
    context.beginPath();
    points.forEach((value, i) => {
      const x = i / Math.max(points.length - 1, 1) * (width - 1), y = height - 16 - (value - range[0]) / (range[1] - range[0] || 1) * (height - 22);
      if (i) context.lineTo(x, y); else context.moveTo(x, y);
    });
    context.stroke();
  }
  context.fillStyle = style.color;
  context.font = "11px system-ui, sans-serif";
  context.textAlign = "left";
  context.fillText(low, 2, height - 3);
  context.textAlign = "right";
  context.fillText(high, width - 2, height - 3);
  context.textAlign = "center";
  context.fillText(labels, width / 2, height - 3);
}

/** Draws the histogram of a part of a picture, with a logarithmic scale of counts. */
export function drawHistogram(canvas, picture, patch, [low, high]) {
  const BINS = 256;
  const curves = [];
  let most = 0;
  let index = 0;
  for (const [name, values] of channels(picture, patch)) {
    const counts = new Array(BINS).fill(0);
    for (const v of values) counts[Math.min(Math.max(Math.floor((v - low) / (high - low) * BINS), 0), BINS - 1)]++;
    const points = counts.map(count => Math.log10(1 + count));
    most = Math.max(most, ...points);
    curves.push({ name, points, index: index++ });
  }
  plot(canvas, curves, `${picture.unit || "code"}, counts logarithmic`, readable(low), readable(high), [0, most]);
  canvas.ariaLabel = `Histogram from ${readable(low)} to ${readable(high)} of ${curves.map(curve => curve.name).join(", ")}`;
}

/** Draws the values along the row or the column of a pixel. */
export function drawProfile(canvas, picture, [px, py], isRow) {
  const { width, height, values, channels: names } = picture;
  const n = names.length, length = isRow ? width : height;
  const curves = names.slice(0, 4).map((name, c) => ({
    name, index: c, points: Array.from({ length }, (_, i) => values[((isRow ? py : i) * width + (isRow ? i : px)) * n + c]).map(v => Number.isFinite(v) ? v : 0),
  }));
  const all = curves.flatMap(curve => curve.points);
  const range = [Math.min(...all), Math.max(...all)];
  plot(canvas, curves, `${isRow ? `row ${py}` : `column ${px}`}: ${readable(range[0])} … ${readable(range[1])} ${picture.unit}`, "0", String(length - 1), range);
  canvas.ariaLabel = `Values of ${isRow ? `row ${py}` : `column ${px}`}, from ${readable(range[0])} to ${readable(range[1])}`;
}
