// The light on the server: what is heard of it, and the orders to trace it anew.
import { Orbit } from "./camera.js";
import { valuesAt } from "./measure.js";
import { refresh } from "./images.js";
import * as server from "./server.js";
import { $, hasOwnLight, lose, query, refuse, session, sides, state } from "./session.js";
import { tellStatus } from "./status.js";

/** Where the camera stands, as far as the page knows. */
export const camera = { orbit: null };
let light = -1, isOrdered = false, wantsOrder = false;

function hear(status) {
  state.status = status;
  if (status.trace !== session.traced) {
    session.traced = status.trace;
    light = -1;
  }
  // While it is being moved the page knows better where it is.
  if (status.camera && status.phase !== "preparing" && !camera.orbit?.isHeld && !wantsOrder && !isOrdered) {
    camera.orbit = new Orbit(status.camera);
    for (const [id, value] of [["focal", status.camera.focal_length_mm], ["focus", status.camera.focus_distance_m]]) {
      if (document.activeElement !== $(id)) $(id).value = value === null ? "" : +value.toPrecision(5);
    }
    if (status.frame !== null && hasOwnLight(sides[session.edited]) && document.activeElement !== $("frame")) $("frame").value = status.frame;
  }
  tellStatus();
  sendOrder();
  if (status.light !== light) {
    light = status.light;
    refresh();
  }
}

/** Traces anew with changes beside those before: one order at a time, the newest. */
export function traceAnew(changes = {}) {
  Object.assign(session.anew, changes);
  wantsOrder = true;
  sendOrder();
}

async function sendOrder() {
  // The next order waits until something of the one before can be seen.
  if (!wantsOrder || isOrdered) return;
  wantsOrder = false;
  isOrdered = true;
  const before = state.status?.light ?? 0;
  try {
    await server.order("start", session.anew, state.status?.frame === null ? 0 : +$("frame").value);
    state.error = null;
    for (let i = 0; i < 100 && (state.status?.light ?? 0) === before && state.status?.phase !== "failed"; i++) await new Promise(done => setTimeout(done, 20));
  } catch (error) { refuse(error); }
  isOrdered = false;
  sendOrder();
}

/** Listens to the server, and finds it again. */
export function connect() {
  const events = new EventSource("events");
  events.onmessage = ({ data }) => {
    if (state.isLost) {
      state.isLost = false;
      $("lost").hidden = true;
      light = -1;
    }
    hear(JSON.parse(data));
  };
  events.onerror = () => {
    lose();
    // Some browsers give up on a server that is away.
    if (events.readyState === EventSource.CLOSED) setTimeout(connect, 1000);
  };
}

/** Focuses on what a pixel of the image shows. */
export async function focusOn(pixel) {
  const side = sides[session.edited], [x, y] = pixel;
  if (!side.picture || x < 0 || y < 0 || x >= side.picture.full[0] || y >= side.picture.full[1]) return;
  try {
    const depth = await server.picture({ ...query(side), plane: "truth:depth", view: `${x},${y},${x + 1},${y + 1}` });
    const [, metres] = valuesAt(depth, pixel)?.[0] ?? [];
    if (metres > 0 && Number.isFinite(metres)) traceAnew({ "lens.focus_distance_m": +metres.toPrecision(6) });
    else $("readout").textContent = `${x}, ${y}: there is nothing to focus on`;
  } catch (error) { refuse(error); }
}
