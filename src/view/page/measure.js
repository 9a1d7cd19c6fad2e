// Histograms, profiles and figures of patches.
import { readable } from "./controls.js";

const INKS = { R: "#e5484d", G: "#30a46c", B: "#3e7bfa", W: "#a0a3a8", Y: "#a0a3a8" };
const ink = (name, i) => INKS[name[0]] ?? ["#8e4ec6", "#12a594", "#f76b15", "#0090ff"][i % 4];

/** The names of a picture's channels, and what gives `visit(channel, value)` all finite values of a part: those of a mosaic
 * by its filters. */
function channels(picture, [x0, y0, x1, y1]) {
  const { width, values, channels: names, raw } = picture;
  const tile = picture.plane === "raw" && raw?.tile.length ? raw.tile : null;
  const all = tile ? [...new Set(tile.flat())] : names;
  const places = tile?.map(row => row.map(name => all.indexOf(name)));
  const n = names.length;
  const each = visit => {
    for (let y = y0; y < y1; y++) {
      const row = places?.[y % places.length];
      for (let x = x0, i = (y * width + x0) * n; x < x1; x++) {
        for (let c = 0; c < n; c++, i++) if (Number.isFinite(values[i])) visit(row ? row[x % row.length] : c, values[i]);
      }
    }
  };
  return [all, each];
}

/** All of a picture but, of a raw one, the pixels that see no light. */
export function area(picture) {
  const { width, height, raw, plane } = picture;
  if (plane !== "raw" || !raw) return [0, 0, width, height];
  const [x, y, w, h] = raw.active;
  return [x, y, x + w, y + h];
}

/** Mean, standard deviation and signal-to-noise ratio of each channel of a patch. */
export function figures(picture, patch) {
  const black = picture.plane === "raw" && picture.raw ? picture.raw.black_dn : 0;
  const [names, each] = channels(picture, patch);
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

/** Draws the histogram of a part of a picture, with a logarithmic scale of counts. */
export function drawHistogram(canvas, picture, patch, [low, high]) {
  const BINS = 256;
  const [names, each] = channels(picture, patch);
  const counts = names.map(() => new Array(BINS).fill(0));
  const factor = BINS / (high - low || 1);
  each((c, v) => { counts[c][Math.min(Math.max(Math.floor((v - low) * factor), 0), BINS - 1)]++; });
  const curves = names.map((name, index) => ({ name, index, points: counts[index].map(count => Math.log10(1 + count)) }));
  const most = Math.max(...curves.flatMap(curve => curve.points));
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
  const range = curves.flatMap(curve => curve.points).reduce(([low, high], v) => [Math.min(low, v), Math.max(high, v)], [Infinity, -Infinity]);
  plot(canvas, curves, `${isRow ? `row ${py}` : `column ${px}`}: ${readable(range[0])} … ${readable(range[1])} ${picture.unit}`, "0", String(length - 1), range);
  canvas.ariaLabel = `Values of ${isRow ? `row ${py}` : `column ${px}`}, from ${readable(range[0])} to ${readable(range[1])}`;
}
