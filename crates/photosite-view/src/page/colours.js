// From values to the colours of the screen.

// A few points of each map, between which colours are linear.
const POINTS = {
  grey: ["000000", "ffffff"],
  viridis: ["440154", "472d7b", "3b528b", "2c728e", "21918c", "28ae80", "5ec962", "addc30", "fde725"],
  turbo: ["30123b", "4454c4", "4490fe", "1fc8de", "29efa2", "7dff56", "c1f334", "f1cb3a", "fe932a", "ea4e0d", "be2102", "7a0403"],
  balance: ["053061", "2f79b5", "9bc9e0", "f7f7f7", "f4a886", "c13639", "67001f"],
};

const number = hex => [0, 2, 4].map(i => parseInt(hex.slice(i, i + 2), 16));
const LEVELS = 1024;

/** The colours of a map, red, green and blue for each level. */
const tables = new Map();
function table(name) {
  if (!tables.has(name)) {
    const points = POINTS[name].map(number);
    const colours = new Uint8Array(LEVELS * 3);
    for (let level = 0; level < LEVELS; level++) {
      const at = level / (LEVELS - 1) * (points.length - 1);
      const i = Math.min(Math.floor(at), points.length - 2);
      for (let c = 0; c < 3; c++) colours[3 * level + c] = Math.round(points[i][c] + (at - i) * (points[i + 1][c] - points[i][c]));
    }
    tables.set(name, colours);
  }
  return tables.get(name);
}

/** The colour of a level between 0 and 1, for CSS. */
export function colourOf(name, level) {
  const colours = table(name), i = 3 * Math.round(level * (LEVELS - 1));
  return `rgb(${colours[i]}, ${colours[i + 1]}, ${colours[i + 2]})`;
}

/** Whether an image is shown as it is, rather than by a scale. */
export const isColour = picture => picture.type !== "f32" && picture.plane === "developed" || picture.plane === "ideal";
export const isNumbered = picture => /^truth:(instance|material)$/.test(picture.plane);
const isDirection = picture => /^truth:(shading-)?normal$/.test(picture.plane);

/** Values between which most of an image lies. */
export function scaleOf(picture) {
  if (picture.plane === "raw" && picture.raw) return [Math.min(picture.raw.black_dn, picture.raw.white_dn), picture.raw.white_dn];
  if (isDirection(picture)) return [-1, 1];
  const { values } = picture;
  const step = Math.max(1, Math.floor(values.length / 50000));
  const some = [];
  for (let i = 0; i < values.length; i += step) if (Number.isFinite(values[i])) some.push(values[i]);
  if (!some.length) return [0, 1];
  some.sort((a, b) => a - b);
  let [low, high] = [some[Math.floor(0.002 * (some.length - 1))], some[Math.ceil(0.998 * (some.length - 1))]];
  // What lies on both sides of 0 is shown alike on both.
  if (low < 0 && high > 0) { high = Math.max(-low, high); low = -high; }
  return low === high ? [low, low + (Math.abs(low) || 1)] : [low, high];
}

/** The pixels of the screen for an image. `scale` are the values of the ends of the map. */
export function toImage(picture, map, [low, high]) {
  const { width, height, values, channels, type } = picture;
  const image = new ImageData(width, height);
  const out = new Uint32Array(image.data.buffer);
  const count = width * height, n = channels.length;
  const rgb = (r, g, b) => (255 << 24 | b << 16 | g << 8 | r) >>> 0;
  if (type !== "f32" && picture.plane === "developed") {
    const shift = type === "u16" ? 8 : 0;
    if (n === 3) for (let i = 0, j = 0; i < count; i++, j += 3) out[i] = rgb(values[j] >> shift, values[j + 1] >> shift, values[j + 2] >> shift);
    else for (let i = 0; i < count; i++) { const v = values[i] >> shift; out[i] = rgb(v, v, v); }
    return image;
  }
  if (picture.plane === "ideal") {
    const code = v => Math.round(255 * Math.min(Math.max(v <= 0.0031308 ? 12.92 * v : 1.055 * v ** (1 / 2.4) - 0.055, 0), 1));
    for (let i = 0; i < count; i++) out[i] = n === 3 ? rgb(code(values[3 * i]), code(values[3 * i + 1]), code(values[3 * i + 2])) : rgb(code(values[i]), code(values[i]), code(values[i]));
    return image;
  }
  if (isNumbered(picture)) {
    for (let i = 0; i < count; i++) {
      const h = Math.imul(values[i * n], 0x9e3779b1) >>> 0;
      out[i] = values[i * n] > 0 ? rgb(64 + (h >>> 24 & 127) * 1.4, 64 + (h >>> 16 & 127) * 1.4, 64 + (h >>> 8 & 127) * 1.4) : rgb(24, 24, 24);
    }
    return image;
  }
  const factor = 1 / (high - low || 1);
  if (n >= 3) {
    const code = v => Math.round(255 * Math.min(Math.max((v - low) * factor, 0), 1)) || 0;
    for (let i = 0, j = 0; i < count; i++, j += n) out[i] = rgb(code(values[j]), code(values[j + 1]), code(values[j + 2]));
    return image;
  }
  const colours = table(map);
  for (let i = 0, j = 0; i < count; i++, j += n) {
    const v = values[j];
    // What is not a number has a colour that no map has.
    if (Number.isNaN(v)) { out[i] = rgb(255, 0, 255); continue; }
    const level = 3 * Math.round(Math.min(Math.max((v - low) * factor, 0), 1) * (LEVELS - 1));
    out[i] = rgb(colours[level], colours[level + 1], colours[level + 2]);
  }
  return image;
}

/** Draws the legend of a map. */
export function drawLegend(canvas, map) {
  const context = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x++) {
    context.fillStyle = colourOf(map, x / (canvas.width - 1));
    context.fillRect(x, 0, 1, canvas.height);
  }
}
