// What all parts of the page share: what is looked at, by which settings, and what went wrong.
// `window.state` is for tests: images that came, the last one, the status, errors, and milliseconds from a control to the
// screen.
import { inQuery } from "./controls.js";
import * as server from "./server.js";
import { Stage } from "./stage.js";

export const $ = id => document.getElementById(id);
export const stage = new Stage($("view"));
export const state = { pictures: 0, picture: null, status: null, error: null, latency: null, answers: 0, isLost: false };
window.state = state;

/** What a side shows: its input, plane, frame and changed settings; the image that came last, and what it is measured by. */
export const sides = [0, 1].map(() => ({ input: 0, plane: "developed", frame: 0, settings: {}, picture: null, sample: null, wanted: false }));

/** The side whose settings are shown; inputs; controls; the trace that runs; when a control was moved; changes for which
 * light is traced anew. */
export const session = { edited: 0, inputs: [], controls: null, traced: 0, changedAt: null, anew: {} };

export const isScene = side => session.inputs[side.input]?.kind === "scene";

/** Whether each frame of a side has light of its own, of which that of one is traced. */
export const hasOwnLight = side => isScene(side) && (state.status?.frame ?? null) !== null;

/** What the server is asked with. */
export const query = side => ({
  plane: side.plane, input: side.input, ...(side.frame && !hasOwnLight(side) ? { frame: side.frame } : {}),
  ...Object.fromEntries(Object.entries(side.settings).map(([key, value]) => [key, inQuery(value)])),
});

/** Says why something is not done. */
export function refuse(error) {
  state.error = error.message;
  if (!(error instanceof server.Refused)) return lose();
  const sentence = words => words ? `${words[0].toUpperCase()}${words.slice(1)}. ` : "";
  $("readout").textContent = sentence(error.message) + sentence(error.help);
  $("readout").classList.add("bad");
  session.controls?.mark("sensor.preset", error.needsTrace);
}

/** Says that the server is away. */
export function lose() {
  if (state.isLost) return;
  state.isLost = true;
  $("lost").hidden = false;
  $("lost").textContent = "The connection is lost: photosite view may have ended. This page continues when it is back at this address.";
}
