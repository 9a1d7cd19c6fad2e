// What is drawn over an image of a data set. Places are pixels of the camera, with whole numbers at the edges of pixels.

/** Colours of numbered things, around the circle of hues. */
export const hue = (number, count) => `hsl(${360 * number / Math.max(count, 1)}deg 100% 55%)`;
const rgb = (number, count) => {
  const at = 6 * number / Math.max(count, 1);
  return [5, 3, 1].map(n => { const k = (n + at) % 6; return Math.round(255 * (1 - Math.min(Math.max(Math.min(k, 4 - k), 0), 1))); });
};

/** The pixels of a mask in runs down its columns, in a colour. */
function mask({ size: [height, width], counts }, colour) {
  const image = new ImageData(width, height), pixels = new Uint32Array(image.data.buffer);
  const ink = new Uint32Array(new Uint8ClampedArray([...colour, 90]).buffer)[0];
  let at = 0, isInside = false;
  for (const count of counts) {
    if (isInside) {
      for (let i = at; i < at + count; i++) pixels[(i % height) * width + Math.floor(i / height)] = ink;
    }
    at += count;
    isInside = !isInside;
  }
  const canvas = new OffscreenCanvas(width, height);
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}

/** The edges of a box in space: numbers of its corners that differ in one bit. */
const EDGES = [...Array(8).keys()].flatMap(a => [1, 2, 4].filter(bit => !(a & bit)).map(bit => [a, a | bit]));

/** Draws what is wanted, of `corners`, `boxes`, `masks` and `epipolar`, over an image that fills a canvas. */
export function draw(canvas, overlays, wanted) {
  const context = canvas.getContext("2d");
  const [width, height] = overlays.size_px, [sx, sy] = [canvas.width / width, canvas.height / height];
  const line = Math.max(1, Math.round(canvas.width / 400));
  const path = points => { context.beginPath(); points.forEach(([x, y], i) => (i ? context.lineTo(x * sx, y * sy) : context.moveTo(x * sx, y * sy))); context.stroke(); };
  context.save();
  context.lineWidth = line;
  const { objects } = overlays;
  if (wanted.has("masks")) {
    context.imageSmoothingEnabled = false;
    objects.forEach((object, i) => context.drawImage(mask(object.mask, rgb(i, objects.length)), 0, 0, canvas.width, canvas.height));
  }
  if (wanted.has("boxes")) {
    context.font = `600 ${Math.max(10, canvas.width / 60)}px system-ui, sans-serif`;
    objects.forEach((object, i) => {
      context.strokeStyle = context.fillStyle = hue(i, objects.length);
      const frame = ([x, y, w, h]) => context.strokeRect(x * sx, y * sy, w * sx, h * sy);
      frame(object.box_px);
      if (object.amodal_box_px) { context.setLineDash([4 * line, 3 * line]); frame(object.amodal_box_px); context.setLineDash([]); }
      for (const [a, b] of object.corners_px.length ? EDGES : []) {
        const ends = [object.corners_px[a], object.corners_px[b]];
        if (ends.every(Boolean)) path(ends);
      }
      if (canvas.width >= 400) context.fillText(object.name, object.box_px[0] * sx + 2, object.box_px[1] * sy - 3);
    });
  }
  if (wanted.has("epipolar") && overlays.epipolar) {
    const { lines } = overlays.epipolar;
    lines.forEach((pieces, i) => { context.strokeStyle = hue(i, lines.length); pieces.forEach(path); });
  }
  if (wanted.has("corners")) {
    for (const { px: [x, y], is_visible } of overlays.corners) {
      const size = Math.max(2, canvas.width / 150);
      context.strokeStyle = is_visible ? "#00ff40" : "#ff3030";
      path([[x - size / sx, y], [x + size / sx, y]]);
      path([[x, y - size / sy], [x, y + size / sy]]);
    }
  }
  context.restore();
}
