// Where the camera stands, and how it turns.

const add = (a, b) => a.map((x, i) => x + b[i]);
const times = (a, s) => a.map(x => x * s);
const length = a => Math.hypot(...a);
const unit = a => times(a, 1 / length(a));
const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const dot = (a, b) => a.reduce((sum, x, i) => sum + x * b[i], 0);
const UP = [0, 1, 0];
const rounded = a => a.map(x => +x.toPrecision(7));

/** Turns a vector around an axis. */
function turned(v, axis, angle) {
  const [c, s] = [Math.cos(angle), Math.sin(angle)];
  return add(add(times(v, c), times(cross(axis, v), s)), times(axis, dot(axis, v) * (1 - c)));
}

/** A camera that turns around what it looks at. */
export class Orbit {
  /** From what the server says of the camera. */
  constructor({ position_m, forward, pivot_m }) {
    this.distance = pivot_m;
    this.pivot = add(position_m, times(forward, pivot_m));
    this.back = times(forward, -1);
  }

  /** Turns by angles, to the right and up. */
  turn(right, up) {
    const next = turned(this.back, UP, -right);
    const side = cross(UP, next);
    // Above and below it would tip over.
    if (length(side) > 1e-6) {
      const lifted = turned(next, unit(side), -up);
      this.back = Math.abs(lifted[1]) < 0.998 ? unit(lifted) : unit(next);
    }
  }

  /** Moves sideways, in parts of the distance. */
  move(right, up) {
    const side = unit(cross(UP, this.back));
    const above = cross(this.back, side);
    this.pivot = add(this.pivot, add(times(side, right * this.distance), times(above, up * this.distance)));
  }

  /** Comes nearer or goes away. */
  approach(factor) {
    this.distance *= factor;
  }

  /** As keys of a capture. */
  changes() {
    return { "camera.position_m": rounded(add(this.pivot, times(this.back, this.distance))), "camera.look_at_m": rounded(this.pivot), "camera.up": UP };
  }
}
