// Histograms, profiles and figures of patches.
import { readable } from "./controls.js";

const INKS = { R: "#e5484d", G: "#30a46c", B: "#3e7bfa", W: "#a0a3a8", Y: "#a0a3a8" };
const ink = (name, i) => INKS[name[0]] ?? ["#8e4ec6", "#12a594", "#f76b15", "#0090ff"][i % 4];

/** The values of a pixel of an image with the names of its channels, if they have come. */
export function valuesAt({ width, height, at, step, values, channels }, [x, y]) {
  const [column, row] = [Math.floor((x - at[0]) / step), Math.floor((y - at[1]) / step)];
  if (column < 0 || row < 0 || column >= width || row >= height) return null;
  const n = channels.length, first = (row * width + column) * n;
  return channels.map((name, c) => [name, values[first + c]]);
}

/** A part of an image that is there as a whole. */
export function crop(picture, [x0, y0, x1, y1]) {
  const { width, height, values, channels } = picture, n = channels.length;
  if (x0 === 0 && y0 === 0 && x1 === width && y1 === height) return picture;
  const part = new values.constructor((x1 - x0) * (y1 - y0) * n);
  for (let y = y0; y < y1; y++) part.set(values.subarray((y * width + x0) * n, (y * width + x1) * n), (y - y0) * (x1 - x0) * n);
  return { ...picture, values: part, at: [x0, y0], width: x1 - x0, height: y1 - y0 };
}

/** The names of an image's channels, and what gives `visit(channel, value)` all finite values: those of a mosaic by its
 * filters. */
function channels(picture) {
  const { width, height, at: [x0, y0], step, values, channels: names, raw } = picture;
  const tile = picture.plane === "raw" && raw?.tile.length ? raw.tile : null;
  const all = tile ? [...new Set(tile.flat())] : names;
  const places = tile?.map(row => row.map(name => all.indexOf(name)));
  const n = names.length;
  const each = visit => {
    for (let y = 0, i = 0; y < height; y++) {
      const row = places?.[(y0 + y * step) % places.length];
      for (let x = 0; x < width; x++) {
        for (let c = 0; c < n; c++, i++) if (Number.isFinite(values[i])) visit(row ? row[(x0 + x * step) % row.length] : c, values[i]);
      }
    }
  };
  return [all, each];
}

/** The part of an image that sees light: of a raw one not all. */
export function seesLight({ full: [width, height], raw, plane }) {
  if (plane !== "raw" || !raw) return [0, 0, width, height];
  const [x, y, w, h] = raw.active;
  return [x, y, x + w, y + h];
}

/** Mean, standard deviation and signal-to-noise ratio of each channel. */
export function figures(picture) {
  const black = picture.plane === "raw" && picture.raw ? picture.raw.black_dn : 0;
  const [names, each] = channels(picture);
  const found = names.map(name => ({ name, count: 0, mean: 0, squares: 0, min: Infinity, max: -Infinity }));
  // Running means lose no digits, however large the values are.
  each((c, v) => {
    const one = found[c], before = v - one.mean;
    one.mean += before / ++one.count;
    one.squares += before * (v - one.mean);
    if (v < one.min) one.min = v;
    if (v > one.max) one.max = v;
  });
  return found.filter(one => one.count).map(({ squares, ...one }) => {
    const sd = Math.sqrt(squares / Math.max(one.count - 1, 1));
    return { ...one, sd, snr: sd > 0 ? (one.mean - black) / sd : Infinity };
  });
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

/** Draws the histogram of an image, with a logarithmic scale of counts. */
export function drawHistogram(canvas, picture, [low, high]) {
  const BINS = 256;
  const [names, each] = channels(picture);
  const counts = names.map(() => new Array(BINS).fill(0));
  const factor = BINS / (high - low || 1);
  each((c, v) => { counts[c][Math.min(Math.max(Math.floor((v - low) * factor), 0), BINS - 1)]++; });
  const curves = names.map((name, index) => ({ name, index, points: counts[index].map(count => Math.log10(1 + count)) }));
  const most = Math.max(...curves.flatMap(curve => curve.points));
  plot(canvas, curves, `${picture.unit || "code"}, logarithmic counts`, readable(low), readable(high), [0, most]);
  canvas.ariaLabel = `Histogram from ${readable(low)} to ${readable(high)} of ${curves.map(curve => curve.name).join(", ")}`;
}

/** Draws the values of an image of one row or one column. */
export function drawProfile(canvas, picture, isRow) {
  const { width, height, at: [x0, y0], values, channels: names } = picture;
  const n = names.length, length = isRow ? width : height, where = isRow ? `row ${y0}` : `column ${x0}`;
  const curves = names.slice(0, 4).map((name, c) => ({
    name, index: c, points: Array.from({ length }, (_, i) => values[i * n + c]).map(v => Number.isFinite(v) ? v : 0),
  }));
  const range = curves.flatMap(curve => curve.points).reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
  plot(canvas, curves, `${where}: ${readable(range[0])} … ${readable(range[1])} ${picture.unit}`, "0", String(length - 1), range);
  canvas.ariaLabel = `Values of ${where}, from ${readable(range[0])} to ${readable(range[1])}`;
}
