// Images of the settings as they are: asked for, one at a time, and shown.
import { isColour, isNumbered, scaleOf, toImage } from "./colours.js";
import { readable } from "./controls.js";
import { measureSoon, point, scale } from "./inspect.js";
import * as server from "./server.js";
import { $, isScene, query, refuse, session, sides, stage, state } from "./session.js";
import { tellStatus } from "./status.js";

let isBusy = false;

/** Asks anew for what sides show: one image at a time, always of the newest settings. */
export function refresh(which = [0, 1]) {
  which.forEach(i => { sides[i].wanted = true; });
  if (!isBusy) ask();
}

/** What is seen of an image, and the pixels of the screen that it takes: the server sends that alone, and no finer. */
function windowOf({ picture }) {
  const ratio = window.devicePixelRatio || 1, { clientWidth, clientHeight } = stage.canvas;
  const onScreen = lengths => lengths.map(length => Math.max(Math.round(length * ratio), 1)).join(",");
  if (!picture || stage.isFitted) return { screen: onScreen([clientWidth, clientHeight]) };
  const view = stage.seen(picture.full), size = stage.size;
  const lengths = [0, 1].map(i => (view[i + 2] - view[i]) * size[i] / picture.full[i] * stage.scale);
  return { screen: onScreen(lengths), view: view.join(",") };
}

async function ask() {
  isBusy = true;
  for (;;) {
    const i = [session.edited, 1 - session.edited].find(i => sides[i].wanted && (i === 0 || $("compare").checked));
    if (i === undefined) break;
    const side = sides[i], began = session.changedAt, isEdited = i === session.edited;
    side.wanted = false;
    if (isEdited) session.changedAt = null;
    if (isScene(side) && !state.status?.light || needsTrace(side)) continue;
    try {
      const asked = session.traced;
      side.window = windowOf(side);
      side.picture = { ...await server.picture({ ...query(side), ...side.window }), trace: isScene(side) ? asked : session.traced };
      show(i);
      state.pictures++;
      state.error = null;
      if (isEdited) {
        $("readout").classList.remove("bad");
        if (began !== null) {
          // What is drawn now is on the screen after the next frame.
          requestAnimationFrame(() => setTimeout(() => { state.latency = performance.now() - began; state.answers++; tellStatus(); }));
        }
      }
    } catch (error) {
      refuse(error);
      if (began !== null) state.answers++;
    }
  }
  isBusy = false;
}

/** Of large images more is asked for when the view has moved. */
let looking = null;
export function lookCloser() {
  clearTimeout(looking);
  looking = setTimeout(() => {
    const which = [0, 1].filter(i => {
      const { picture, window } = sides[i];
      if (!picture || picture.step === 1 && picture.width === picture.full[0] && picture.height === picture.full[1]) return false;
      return JSON.stringify(windowOf(sides[i])) !== JSON.stringify(window);
    });
    if (which.length) refresh(which);
  }, 80);
}

/** Why a side does not show the sensor that is chosen, and what can be done about it: light of files cannot be traced anew. */
export const untold = side => isScene(side)
  ? { message: "this sensor responds to light differently from the one that it was traced for", help: "trace again for this sensor, or keep the spectrum, which serves all sensors", needs_trace: true }
  : { message: "this sensor responds to light differently from the one that it was rendered for", help: "view a folder that was rendered with output.irradiance = true, which serves all sensors, or the capture itself", needs_trace: false };

/** Whether the light of a side does not tell what the sensor sees that is chosen. */
export const needsTrace = ({ settings, picture }) => Boolean(settings["sensor.preset"] && picture?.sensors && !picture.sensors.includes(settings["sensor.preset"]) && picture.trace === session.traced);

/** Shows the image of a side: its colours, its settings, its measures. */
export function show(i) {
  const side = sides[i], { picture } = side, isEdited = i === session.edited;
  const isScaled = !isColour(picture) && !isNumbered(picture);
  if (isEdited) {
    state.picture = picture;
    if ($("auto-scale").checked && isScaled) [$("low").value, $("high").value] = scaleOf(picture).map(value => +value.toPrecision(4));
    $("scale-group").hidden = !isScaled;
    showSettings(side);
    session.controls.mark("sensor.preset", false);
    tellPlanes(side, picture.planes);
    tellWarnings(picture.warnings);
    $("view").ariaLabel = `Image: ${picture.plane}, ${picture.full[0]} × ${picture.full[1]} pixels`;
  }
  stage.put(i, toImage(picture, $("map").value, isEdited ? scale() : scaleOf(picture)), picture);
  tellZoom();
  if (isEdited) {
    if (stage.pixel) point(stage.pixel, i);
    measureSoon();
  }
}

/** Shows the settings of a side, and which of them are changed or need light to be traced anew. */
export function showSettings({ picture, settings }) {
  if (!picture) return;
  const anew = picture.anew ?? [];
  for (const key of session.controls.keys()) if (key !== "sensor.preset") session.controls.mark(key, anew.includes(key));
  const traced = Object.fromEntries(Object.entries(session.anew).filter(([key]) => anew.includes(key)));
  session.controls.show(picture.settings, { ...traced, ...settings }, picture.stages);
}

export const tellZoom = () => { $("zoom").value = `${readable(stage.scale * 100, 3)} %`; };

const GROUPS = { developed: "Sensor", raw: "Sensor", electrons: "Mean electrons", sigma: "Uncertainty of electrons", noise: "Noise of the sensor", irradiance: "Spectral irradiance, nm", ideal: "Sensor", truth: "Truth" };
let planesShown = "";
function tellPlanes(side, planes) {
  const text = planes.join(" ");
  if (text !== planesShown) {
    planesShown = text;
    const groups = new Map();
    for (const plane of planes) {
      const [kind, name] = plane.split(":");
      const group = GROUPS[kind] ?? kind;
      if (!groups.has(group)) groups.set(group, Object.assign(document.createElement("optgroup"), { label: group }));
      const words = name ? kind === "electrons" ? `electrons ${name}` : kind === "sigma" ? `σ ${name}` : name.replaceAll("_", " ").replaceAll("-", " ") : plane;
      groups.get(group).append(new Option(words, plane));
    }
    $("plane").replaceChildren(...groups.values());
  }
  $("plane").value = side.plane;
}

function tellWarnings(warnings) {
  $("warnings-group").hidden = !warnings.length;
  $("warnings-group").querySelector("summary").textContent = `Warnings (${warnings.length})`;
  $("warnings").replaceChildren(...warnings.map(text => Object.assign(document.createElement("li"), { textContent: text })));
}
