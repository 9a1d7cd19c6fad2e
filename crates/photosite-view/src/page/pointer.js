// The pointer, the wheel and fingers on the image, by the tool that is chosen.
import { clipped, measure, pick, point } from "./inspect.js";
import { camera, focusOn, traceAnew } from "./light.js";
import { lookCloser, tellZoom } from "./images.js";
import { $, session, sides, stage } from "./session.js";

/** Zooms, at a point of the canvas that stays, or fits the image. */
export function zoom(scale, at) {
  stage.zoom(scale, at);
  tellZoom();
  lookCloser();
}

export function fit() {
  stage.fit();
  tellZoom();
  lookCloser();
}

/** Moves the image. */
export function move(dx, dy) {
  stage.move(dx, dy);
  lookCloser();
}

/** Turns the camera by angles to the right and up, or moves it sideways. */
export function turn(right, up, isSideways) {
  if (isSideways) camera.orbit.move(right, up);
  else camera.orbit.turn(right, up);
  traceAnew(camera.orbit.changes());
}

/** Goes nearer to what the camera looks at, or away from it, by steps. */
export function approach(steps) {
  if ($("tool").value !== "orbit" || !camera.orbit) return;
  camera.orbit.approach(1.1 ** steps);
  traceAnew(camera.orbit.changes());
}

/** Marks the patch between two pixels; what of it lies beside the image is left out. */
function mark(a, b) {
  const corners = [Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]) + 1, Math.max(a[1], b[1]) + 1];
  stage.patch = clipped(corners, sides[session.edited].picture ?? { full: [1, 1] });
  // Beside the image there is nothing to measure.
  if (stage.patch[0] >= stage.patch[2] || stage.patch[1] >= stage.patch[3]) stage.patch = null;
  stage.draw();
}

/** The pixel at which a patch was begun by keys. */
let corner = null;

/** The other corner of a patch that is being marked by keys. */
export function markCorner(pixel) {
  if (corner) mark(corner, pixel);
}

/** Does with a pixel what a click of the tool would do: begins and ends a patch, or focuses. Without a pixel a patch goes
 * away. */
export function pickByTool(pixel) {
  const tool = $("tool").value;
  if (tool === "patch" && pixel) {
    corner = corner ? null : pixel;
    if (corner) mark(pixel, pixel);
    measure();
  } else if (tool === "patch") {
    corner = stage.patch = null;
    stage.draw();
    measure();
  } else if (tool === "focus" && pixel) focusOn(pixel);
}

const view = $("view"), pointers = new Map();
const place = event => { const box = view.getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
let drag = null;

view.onpointerdown = event => {
  view.setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, place(event));
  drag = { from: place(event), last: place(event), hasMoved: false };
  if ($("tool").value === "orbit" && camera.orbit) camera.orbit.isHeld = true;
};

view.onpointermove = event => {
  const at = place(event);
  if (pointers.size === 2 && pointers.has(event.pointerId)) return pinch(event.pointerId, at);
  if (!drag) return point(stage.at(at), stage.sideAt(at));
  pointers.set(event.pointerId, at);
  const [dx, dy] = [at[0] - drag.last[0], at[1] - drag.last[1]];
  if (Math.hypot(at[0] - drag.from[0], at[1] - drag.from[1]) > 3) drag.hasMoved = true;
  drag.last = at;
  const tool = $("tool").value;
  if (tool === "patch") {
    corner = null;
    mark(stage.at(drag.from), stage.at(at));
  } else if (tool === "orbit" && camera.orbit) {
    if (event.shiftKey) turn(-dx / view.clientHeight, dy / view.clientHeight, true);
    else turn(dx / 200, dy / 200, false);
  } else if (drag.hasMoved) move(dx, dy);
};

/** Two fingers zoom. */
function pinch(id, at) {
  const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  const before = spread();
  pointers.set(id, at);
  const [a, b] = [...pointers.values()];
  zoom(stage.scale * spread() / before, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]);
  drag.hasMoved = true;
}

view.onpointerup = event => {
  pointers.delete(event.pointerId);
  if (!drag || pointers.size) return;
  const { hasMoved, from } = drag, tool = $("tool").value;
  drag = null;
  if (camera.orbit) camera.orbit.isHeld = false;
  if (tool === "patch") {
    if (!hasMoved) stage.patch = null;
    measure();
    stage.draw();
  } else if (!hasMoved && tool === "focus") focusOn(stage.at(from));
  else if (!hasMoved) pick(stage.at(from));
};

view.onpointercancel = event => { pointers.delete(event.pointerId); drag = null; if (camera.orbit) camera.orbit.isHeld = false; };

view.addEventListener("wheel", event => {
  event.preventDefault();
  if ($("tool").value === "orbit" && camera.orbit) approach(Math.sign(event.deltaY));
  else zoom(stage.scale * 1.2 ** -Math.sign(event.deltaY), place(event));
}, { passive: false });
