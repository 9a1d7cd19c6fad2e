// The pointer, the wheel and fingers on the picture, by the tool that is chosen.
import { clipped, measure, pick, point } from "./inspect.js";
import { camera, focusOn, traceAnew } from "./light.js";
import { lookCloser, tellZoom } from "./pictures.js";
import { $, session, sides, stage } from "./session.js";

/** Zooms, at a point of the canvas that stays, or fits the picture. */
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

/** Moves the picture. */
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
    const [a, b] = [stage.at(drag.from), stage.at(at)];
    stage.patch = clipped([Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]) + 1, Math.max(a[1], b[1]) + 1], sides[session.edited].picture ?? { full: [1, 1] });
    // Beside the picture there is nothing to measure.
    if (stage.patch[0] >= stage.patch[2] || stage.patch[1] >= stage.patch[3]) stage.patch = null;
    stage.draw();
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
  if ($("tool").value === "orbit" && camera.orbit) {
    camera.orbit.approach(1.1 ** Math.sign(event.deltaY));
    traceAnew(camera.orbit.changes());
  } else zoom(stage.scale * 1.2 ** -Math.sign(event.deltaY), place(event));
}, { passive: false });
