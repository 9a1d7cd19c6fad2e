// The image on the screen: one, or two beside each other, where they are and how large.

/** Draws images of sides into a canvas, and knows which pixel is where. */
export class Stage {
  constructor(canvas) {
    this.canvas = canvas;
    this.images = [null, null];
    this.scale = 1;
    this.offset = [0, 0];
    this.isFitted = true;
    this.split = null;
    this.pixel = null;
    this.patch = null;
    new ResizeObserver(() => { if (this.isFitted) this.fit(); else this.draw(); }).observe(canvas);
  }

  /** The image of a side as it is shown: all of it, or what has come of it. */
  put(side, image, { full, at, step }) {
    const kept = this.images[side]?.canvas;
    const canvas = kept?.width === image.width && kept?.height === image.height ? kept : new OffscreenCanvas(image.width, image.height);
    canvas.getContext("2d").putImageData(image, 0, 0);
    this.images[side] = { canvas, full, at, step };
    if (this.isFitted && side === 0) this.fit(); else this.draw();
  }

  /** Columns and rows of the image. */
  get size() {
    return (this.images[0] ?? this.images[1])?.full ?? [1, 1];
  }

  /** The part of an image of that size that is seen, and a quarter more on each side: first columns and rows, and those
   * behind the last. */
  seen(full) {
    const { clientWidth, clientHeight } = this.canvas, size = this.size;
    const ends = [clientWidth, clientHeight].map((length, i) => [-0.25, 1.25].map(end => {
      const at = (end * length - this.offset[i]) / this.scale * full[i] / size[i];
      return Math.min(Math.max(end < 0 ? Math.floor(at) : Math.ceil(at), 0), full[i]);
    }));
    // Of an image that is out of sight a pixel remains.
    const [[x0, x1], [y0, y1]] = ends.map(([low, high], i) => low < high ? [low, high] : [Math.min(low, full[i] - 1), Math.min(low, full[i] - 1) + 1]);
    return [x0, y0, x1, y1];
  }

  /** All of the image, in the middle. */
  fit() {
    const { clientWidth, clientHeight } = this.canvas, [width, height] = this.size;
    this.isFitted = true;
    this.scale = Math.min(clientWidth / width, clientHeight / height) || 1;
    this.offset = [(clientWidth - width * this.scale) / 2, (clientHeight - height * this.scale) / 2];
    this.draw();
  }

  /** Zooms so that what is at a point of the canvas stays there. */
  zoom(scale, [x, y] = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2]) {
    const next = Math.min(Math.max(scale, 0.02), 64);
    this.offset = [x - (x - this.offset[0]) / this.scale * next, y - (y - this.offset[1]) / this.scale * next];
    this.scale = next;
    this.isFitted = false;
    this.draw();
  }

  move(dx, dy) {
    this.offset = [this.offset[0] + dx, this.offset[1] + dy];
    this.isFitted = false;
    this.draw();
  }

  /** The pixel at a point of the canvas, which may lie outside. */
  at([x, y]) {
    return [(x - this.offset[0]) / this.scale, (y - this.offset[1]) / this.scale].map(Math.floor);
  }

  /** The side that a point of the canvas shows. */
  sideAt([x]) {
    return this.split !== null && x >= this.split * this.canvas.clientWidth ? 1 : 0;
  }

  draw() {
    const { canvas, offset: [x, y], scale } = this;
    const ratio = window.devicePixelRatio || 1;
    const [width, height] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== width || canvas.height !== height) [canvas.width, canvas.height] = [width, height];
    const context = canvas.getContext("2d");
    context.setTransform(1, 0, 0, 1, 0, 0);
    context.clearRect(0, 0, width, height);
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    // Pixels are to be seen as such.
    context.imageSmoothingEnabled = scale < 1;
    const paint = (image, from, to) => {
      if (!image) return;
      context.save();
      context.beginPath();
      context.rect(from, 0, to - from, canvas.clientHeight);
      context.clip();
      // Another number of pixels shows the same view.
      const [fx, fy] = this.size.map((length, i) => length / image.full[i] * scale), { at, step, canvas: drawn } = image;
      context.drawImage(drawn, x + at[0] * fx, y + at[1] * fy, drawn.width * step * fx, drawn.height * step * fy);
      context.restore();
    };
    const middle = this.split === null ? canvas.clientWidth : this.split * canvas.clientWidth;
    paint(this.images[0], 0, middle);
    if (this.split !== null) {
      paint(this.images[1], middle, canvas.clientWidth);
      context.fillStyle = "#fff";
      context.fillRect(middle - 1, 0, 2, canvas.clientHeight);
      context.font = "600 14px system-ui, sans-serif";
      context.shadowColor = "#000";
      context.shadowBlur = 4;
      context.textAlign = "right";
      context.fillText("A", middle - 8, 20);
      context.textAlign = "left";
      context.fillText("B", middle + 8, 20);
      context.shadowBlur = 0;
    }
    const frame = ([x0, y0, x1, y1]) => {
      for (const [colour, wide] of [["#000", 3], ["#fff", 1]]) {
        context.strokeStyle = colour;
        context.lineWidth = wide;
        context.strokeRect(x + x0 * scale, y + y0 * scale, (x1 - x0) * scale, (y1 - y0) * scale);
      }
    };
    if (this.patch) frame(this.patch);
    if (this.pixel) {
      const [px, py] = this.pixel, margin = scale < 6 ? 3 / scale : 0;
      frame([px - margin, py - margin, px + 1 + margin, py + 1 + margin]);
    }
  }
}
