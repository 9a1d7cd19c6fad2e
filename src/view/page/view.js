// The page of photosite view: asks for pictures of the settings as they are, and shows them.
// `window.state` is for tests: pictures that came, the last one, the status, errors, and milliseconds from a control to
// the screen.
import { Orbit } from "./camera.js";
import { drawLegend, isColour, isNumbered, scaleOf, toImage } from "./colours.js";
import { Controls, inQuery, readable } from "./controls.js";
import { area, drawHistogram, drawProfile, figures, inWords } from "./measure.js";
import * as server from "./server.js";
import { Stage } from "./stage.js";

const $ = id => document.getElementById(id);
const stage = new Stage($("view"));
const state = { pictures: 0, picture: null, status: null, error: null, latency: null, answers: 0, isLost: false };
window.state = state;

/** What a side shows: its input, plane, frame and changed settings; the picture that came last, and that of its key. */
const sides = [0, 1].map(() => ({ input: 0, plane: "developed", frame: 0, settings: {}, picture: null, seen: null, wanted: false }));
let edited = 0;
let inputs = [];
let controls = null;
let light = -1;
let isBusy = false;
let changedAt = null;

const query = side => ({
  plane: side.plane, input: side.input, ...(side.frame ? { frame: side.frame } : {}),
  ...Object.fromEntries(Object.entries(side.settings).map(([key, value]) => [key, inQuery(value)])),
});

/** Asks anew for what sides show: one picture at a time, always of the newest settings. */
function refresh(which = [0, 1]) {
  which.forEach(i => { sides[i].wanted = true; });
  if (!isBusy) ask();
}

async function ask() {
  isBusy = true;
  for (;;) {
    const i = [edited, 1 - edited].find(i => sides[i].wanted && (i === 0 || $("compare").checked));
    if (i === undefined) break;
    const side = sides[i], began = changedAt;
    side.wanted = false;
    if (i === edited) changedAt = null;
    const isScene = inputs[side.input]?.kind === "scene";
    if (isScene && !state.status?.light || needsTrace(side)) continue;
    try {
      const asked = traced;
      side.picture = { ...await server.picture(query(side)), trace: isScene ? asked : traced };
      show(i);
      state.pictures++;
      state.error = null;
      if (i === edited) {
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

function refuse(error) {
  state.error = error.message;
  if (!(error instanceof server.Refused)) return lose();
  const sentence = words => words ? `${words[0].toUpperCase()}${words.slice(1)}. ` : "";
  $("readout").textContent = sentence(error.message) + sentence(error.help);
  $("readout").classList.add("bad");
  controls?.mark("sensor.preset", error.needsTrace);
}

/** Shows the picture of a side: its colours, its settings, its measures. */
function show(i) {
  const side = sides[i], { picture } = side;
  const isScaled = !isColour(picture) && !isNumbered(picture);
  if (i === edited) {
    state.picture = picture;
    if ($("auto-scale").checked && isScaled) [$("low").value, $("high").value] = scaleOf(picture).map(value => +value.toPrecision(4));
    $("scale-group").hidden = !isScaled;
    controls.show(picture.settings, side.settings);
    controls.mark("sensor.preset", false);
    tellPlanes(side, picture.planes);
    tellWarnings(picture.warnings);
    $("view").ariaLabel = `Picture: ${picture.plane}, ${picture.width} × ${picture.height} pixels`;
  }
  stage.put(i, toImage(picture, $("map").value, i === edited ? scale() : scaleOf(picture)));
  $("zoom").value = `${readable(stage.scale * 100, 3)} %`;
  if (i === edited) {
    if (stage.pixel) point(stage.pixel, i);
    measureSoon();
  }
}

const scale = () => [+$("low").value, +$("high").value];

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

// Light

const PHASES = { preparing: "Building the scene", tracing: "Tracing", paused: "Paused", stopped: "Stopped", done: "Traced", failed: "Cannot be traced", stored: "Light of files" };
const clock = s => s >= 3600 ? `${Math.floor(s / 3600)} h ${Math.floor(s / 60 % 60)} min` : s >= 60 ? `${Math.floor(s / 60)} min ${Math.floor(s % 60)} s` : `${readable(s, s < 10 ? 2 : 3)} s`;

function tellStatus() {
  const { status } = state;
  if (!status) return;
  const lines = [PHASES[status.phase]];
  if (status.phase !== "stored") {
    lines.push(`${readable(status.samples_per_pixel, 4)} samples a pixel, ${clock(status.elapsed_s)}${["tracing", "paused"].includes(status.phase) && status.left_s !== null ? `, ${clock(status.left_s)} left` : ""}`);
    if (status.noise_ratio !== null) lines.push(`Noise of the light: ${readable(status.noise_ratio, 2)} × that of the sensor`);
  }
  if (status.message) lines.push(status.message);
  if (state.latency !== null) lines.push(`Answer within ${state.latency.toFixed(0)} ms`);
  $("status").textContent = lines.join("\n");
  $("progress").hidden = status.phase === "stored";
  $("progress").value = status.expected_paths ? Math.min(status.paths / status.expected_paths, 1) : 0;
  const isTraced = ["tracing", "paused"].includes(status.phase);
  $("pause").textContent = status.phase === "paused" ? "Continue" : "Pause";
  $("pause").disabled = $("stop").disabled = !isTraced;
  $("trace-buttons").hidden = $("camera-group").hidden = status.phase === "stored";
  for (const tool of ["focus", "orbit"]) [...$("tool").options].find(option => option.value === tool).disabled = !status.camera || status.camera.moves;
}

let traced = 0, orbit = null;
const camera = {};
function hear(status) {
  state.status = status;
  if (status.trace !== traced) {
    traced = status.trace;
    light = -1;
  }
  // While it is being moved the page knows better where it is.
  if (status.camera && status.phase !== "preparing" && !orbit?.isHeld && !wantsOrder && !isOrdered) {
    orbit = new Orbit(status.camera);
    for (const [id, value] of [["focal", status.camera.focal_length_mm], ["stop-number", status.camera.f_number], ["focus", status.camera.focus_distance_m]]) {
      if (document.activeElement !== $(id)) $(id).value = value === null ? "" : +value.toPrecision(5);
    }
  }
  tellStatus();
  sendCamera();
  if (status.light !== light) {
    light = status.light;
    refresh();
  }
}

/** Traces anew with the camera as it is set: one order at a time, the newest. */
let isOrdered = false, wantsOrder = false;
function moveCamera(changes) {
  Object.assign(camera, changes);
  wantsOrder = true;
  sendCamera();
}

async function sendCamera() {
  // The next order waits until something of the one before can be seen.
  if (!wantsOrder || isOrdered) return;
  wantsOrder = false;
  isOrdered = true;
  const before = state.status?.light ?? 0;
  try {
    await server.order("start", camera);
    state.error = null;
    for (let i = 0; i < 100 && (state.status?.light ?? 0) === before && state.status?.phase !== "failed"; i++) await new Promise(done => setTimeout(done, 20));
  } catch (error) { refuse(error); }
  isOrdered = false;
  sendCamera();
}

function lose() {
  if (!state.isLost) {
    state.isLost = true;
    $("lost").hidden = false;
    $("lost").textContent = "The connection is lost: photosite view may have ended. This page goes on when it is back at this address.";
  }
}

let events = null;
function connect() {
  events = new EventSource("events");
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

// Measures

/** Measures wait until no picture follows: while a slider moves it is the picture that counts. */
let measuring = null;
function measureSoon() {
  clearTimeout(measuring);
  measuring = setTimeout(measure, 120);
}

function measure() {
  const { picture } = sides[edited];
  if (!picture) return;
  const part = stage.patch ? clipped(stage.patch, picture) : area(picture);
  const plot = $("plot").value;
  const range = isColour(picture) ? [0, picture.type === "u16" ? 65536 : picture.type === "u8" ? 256 : 1] : scale();
  if (plot === "histogram" || !stage.pixel) drawHistogram($("graph"), picture, part, range);
  else drawProfile($("graph"), picture, stage.pixel, plot === "row");
  const rows = figures(picture, part);
  state.figures = rows;
  const name = stage.patch ? `Patch of ${part[2] - part[0]} × ${part[3] - part[1]} pixels at ${part[0]}, ${part[1]}` : "All pixels";
  $("figures").textContent = `${name}\n${inWords(rows, picture.unit)}`;
  tellPixel();
}

const clipped = ([x0, y0, x1, y1], { width, height }) => [Math.max(x0, 0), Math.max(y0, 0), Math.min(x1, width), Math.min(y1, height)];

function valuesAt(picture, [x, y]) {
  if (x < 0 || y < 0 || x >= picture.width || y >= picture.height) return null;
  const n = picture.channels.length, first = (y * picture.width + x) * n;
  return picture.channels.map((name, c) => [name, picture.values[first + c]]);
}

let asksPixel = false, nextPixel = false;
async function tellPixel() {
  if (!stage.pixel || !sides[edited].picture) return;
  if (asksPixel) { nextPixel = true; return; }
  asksPixel = true;
  const side = sides[edited], [x, y] = stage.pixel;
  // Raw pictures show the pixels that see no light, too.
  const [ax, ay] = side.plane === "raw" && side.picture.raw ? side.picture.raw.active : [0, 0];
  try {
    if (x >= ax && y >= ay) {
      const found = await server.pixel({ ...query(side), x: x - ax, y: y - ay });
      state.pixel = found;
      const cells = (...texts) => texts.map(text => Object.assign(document.createElement("td"), { textContent: text }));
      const row = (...texts) => { const made = document.createElement("tr"); made.append(...cells(...texts)); return made; };
      const rows = [row("Pixel", `${x}, ${y}`)];
      for (const [name, mean, sigma] of found.electrons) rows.push(row(`Electrons ${name}`, `${readable(mean)} e⁻`, sigma === null ? "" : `± ${readable(sigma, 2)}`));
      for (const [name, value] of found.raw ?? []) rows.push(row(`Raw ${name}`, `${value} DN`));
      if (found.developed) rows.push(row("Developed", found.developed.map(([, value]) => value).join(", ")));
      $("pixel").replaceChildren(...rows);
    }
  } catch (error) { refuse(error); }
  asksPixel = false;
  if (nextPixel) { nextPixel = false; tellPixel(); }
}

/** Focuses on what a pixel of the picture shows. */
async function focusOn(pixel) {
  const side = sides[edited];
  try {
    const depth = await server.picture({ ...query(side), plane: "truth:depth", frame: 0 });
    const [, metres] = valuesAt(depth, pixel)?.[0] ?? [];
    if (metres > 0 && Number.isFinite(metres)) moveCamera({ "lens.focus_distance_m": +metres.toPrecision(6) });
    else $("readout").textContent = `${pixel[0]}, ${pixel[1]}: there is nothing to focus on`;
  } catch (error) { refuse(error); }
}

function pick(pixel) {
  stage.pixel = pixel;
  stage.draw();
  point(pixel, edited);
  measure();
}

function point(pixel, side) {
  const { picture } = sides[side];
  const values = picture && valuesAt(picture, pixel);
  if (!values || state.error) return;
  $("readout").textContent = `${stage.split === null ? "" : "AB"[side] + "  "}${pixel[0]}, ${pixel[1]}:  ${values.map(([name, value]) => `${name} ${readable(value)}`).join("  ")}${picture.unit && " " + picture.unit}`;
}

// The pointer

let drag = null;
const place = event => { const box = $("view").getBoundingClientRect(); return [event.clientX - box.left, event.clientY - box.top]; };
const pointers = new Map();

$("view").onpointerdown = event => {
  $("view").setPointerCapture(event.pointerId);
  pointers.set(event.pointerId, place(event));
  drag = { from: place(event), last: place(event), hasMoved: false };
  if ($("tool").value === "orbit" && orbit) orbit.isHeld = true;
};
$("view").onpointermove = event => {
  const at = place(event);
  if (pointers.size === 2 && pointers.has(event.pointerId)) {
    // Two fingers zoom.
    const spread = () => { const [a, b] = [...pointers.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
    const before = spread();
    pointers.set(event.pointerId, at);
    const [a, b] = [...pointers.values()];
    zoom(stage.scale * spread() / before, [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2]);
    drag.hasMoved = true;
    return;
  }
  if (!drag) return point(stage.at(at), stage.sideAt(at));
  pointers.set(event.pointerId, at);
  const [dx, dy] = [at[0] - drag.last[0], at[1] - drag.last[1]];
  if (Math.hypot(at[0] - drag.from[0], at[1] - drag.from[1]) > 3) drag.hasMoved = true;
  drag.last = at;
  const tool = $("tool").value;
  if (tool === "patch") {
    const [a, b] = [stage.at(drag.from), stage.at(at)];
    stage.patch = clipped([Math.min(a[0], b[0]), Math.min(a[1], b[1]), Math.max(a[0], b[0]) + 1, Math.max(a[1], b[1]) + 1], sides[edited].picture ?? { width: 1, height: 1 });
    stage.draw();
  } else if (tool === "orbit" && orbit) {
    if (event.shiftKey) orbit.move(-dx / $("view").clientHeight, dy / $("view").clientHeight);
    else orbit.turn(dx / 200, dy / 200);
    moveCamera(orbit.changes());
  } else if (drag.hasMoved) stage.move(dx, dy);
};
$("view").onpointerup = event => {
  pointers.delete(event.pointerId);
  if (!drag || pointers.size) return;
  const { hasMoved, from } = drag, tool = $("tool").value;
  drag = null;
  if (orbit) orbit.isHeld = false;
  if (tool === "patch") {
    if (!hasMoved) stage.patch = null;
    measure();
    stage.draw();
  } else if (!hasMoved && tool === "focus") focusOn(stage.at(from));
  else if (!hasMoved) pick(stage.at(from));
};
$("view").onpointercancel = event => { pointers.delete(event.pointerId); drag = null; if (orbit) orbit.isHeld = false; };
$("view").addEventListener("wheel", event => {
  event.preventDefault();
  if ($("tool").value === "orbit" && orbit) { orbit.approach(1.1 ** Math.sign(event.deltaY)); moveCamera(orbit.changes()); }
  else zoom(stage.scale * 1.2 ** -Math.sign(event.deltaY), place(event));
}, { passive: false });

function zoom(scale, at) {
  stage.zoom(scale, at);
  $("zoom").value = `${readable(stage.scale * 100, 3)} %`;
}
function fit() { stage.fit(); $("zoom").value = `${readable(stage.scale * 100, 3)} %`; }

// Controls

function change(key, value) {
  const side = sides[edited];
  changedAt ??= performance.now();
  if (value === undefined) delete side.settings[key];
  else side.settings[key] = value;
  // A time that is given is no automatic one, and a temperature is one of white.
  if (key === "exposure.time_s" && value !== undefined) delete side.settings["exposure.auto"];
  if (key === "exposure.auto") { if (value === false && side.picture) { side.settings["exposure.time_s"] = side.picture.settings["exposure.time_s"]; delete side.settings[key]; } else delete side.settings["exposure.time_s"]; }
  if ((key === "develop.temperature_k" || key === "develop.tint") && value !== undefined) {
    side.settings["develop.white_balance"] = "temperature";
    side.settings["develop.temperature_k"] ??= 5500;
  }
  if (key === "develop.white_balance" && value !== "temperature") { delete side.settings["develop.temperature_k"]; delete side.settings["develop.tint"]; }
  if (key === "develop.white_balance" && value === "temperature") side.settings["develop.temperature_k"] ??= 5500;
  if (side.picture) controls.show(side.picture.settings, side.settings);
  if (needsTrace(side)) return refuse(new server.Refused({ ...UNTOLD, needs_trace: true }, 409));
  refresh([edited]);
}

const UNTOLD = { message: "this sensor sees light in another way than the one that it was traced for", help: "trace again for this sensor, or keep the spectrum, which serves all" };

/** Whether the light of a side does not tell what the sensor sees that is chosen. */
const needsTrace = ({ settings, picture }) => Boolean(settings["sensor.preset"] && picture?.sensors && !picture.sensors.includes(settings["sensor.preset"]) && picture.trace === traced);

function edit(i) {
  edited = i;
  const side = sides[i];
  $("side").value = i;
  $("input").value = side.input;
  $("frame").value = side.frame;
  if (side.picture) show(i);
  refresh([i]);
}

function compare(isOn) {
  if (isOn && !sides[1].picture) {
    // B begins as A is, or shows the second input.
    Object.assign(sides[1], { input: inputs.length > 1 ? 1 : sides[0].input, plane: sides[0].plane, frame: sides[0].frame, settings: { ...sides[0].settings } });
  }
  $("compare").checked = isOn;
  stage.split = isOn ? +$("split").value : null;
  if (!isOn && edited === 1) edit(0);
  stage.draw();
  refresh();
}

function showPlane(plane) {
  changedAt ??= performance.now();
  sides[edited].plane = plane;
  refresh([edited]);
}

$("plane").onchange = () => showPlane($("plane").value);
$("frame").oninput = () => { if ($("frame").checkValidity()) { changedAt ??= performance.now(); sides[edited].frame = +$("frame").value; refresh([edited]); } };
$("map").onchange = () => { drawLegend($("legend"), $("map").value); if (sides[edited].picture) show(edited); };
for (const id of ["low", "high"]) $(id).oninput = () => { $("auto-scale").checked = false; if (sides[edited].picture) show(edited); };
$("auto-scale").onchange = () => { if (sides[edited].picture) show(edited); };
$("plot").onchange = measure;
$("compare").onchange = () => compare($("compare").checked);
$("side").onchange = () => { if ($("side").value === "1" && !$("compare").checked) compare(true); edit(+$("side").value); };
$("input").onchange = () => { sides[edited].input = +$("input").value; sides[edited].settings = {}; refresh([edited]); };
$("split").oninput = () => { stage.split = $("compare").checked ? +$("split").value : null; stage.draw(); };
$("zoom-in").onclick = () => zoom(stage.scale * 1.5);
$("zoom-out").onclick = () => zoom(stage.scale / 1.5);
$("fit").onclick = fit;
$("actual").onclick = () => zoom(1);
$("help").onclick = () => $("keys").showModal();
$("pause").onclick = () => server.order(state.status?.phase === "paused" ? "continue" : "pause").catch(refuse);
$("stop").onclick = () => server.order("stop").catch(refuse);
$("again").onclick = () => {
  // A sensor that this light does not serve becomes the one that light is traced for.
  const { settings, picture } = sides[edited];
  if (settings["sensor.preset"]) {
    const size = picture?.raw ? picture.raw.active.slice(2) : null;
    Object.assign(camera, { "sensor.preset": settings["sensor.preset"], ...(size ? { "sensor.resolution_px": size } : {}) });
    delete settings["sensor.preset"];
  }
  wantsOrder = true;
  sendCamera();
};
const typed = (id, key) => { $(id).onchange = () => { if (+$(id).value > 0) moveCamera({ [key]: +$(id).value }); }; };
typed("focal", "lens.focal_length_mm");
typed("stop-number", "lens.f_number");
typed("focus", "lens.focus_distance_m");
$("keep-irradiance").onchange = () => moveCamera({ "output.irradiance": $("keep-irradiance").checked });
$("keep-ideal").onchange = () => moveCamera({ "output.ideal": $("keep-ideal").checked });
$("camera-reset").onclick = () => {
  for (const key of Object.keys(camera)) if (/^(camera|lens)\./.test(key)) delete camera[key];
  moveCamera({});
};
$("reset").onclick = () => { changedAt ??= performance.now(); sides[edited].settings = {}; if (sides[edited].picture) controls.show(sides[edited].picture.settings, {}); refresh([edited]); };
$("save").onclick = async () => {
  try {
    const text = await server.changes(query(sides[edited]));
    state.saved = text;
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([text], { type: "application/toml" })), download: "changes.toml" });
    link.click();
    URL.revokeObjectURL(link.href);
  } catch (error) { refuse(error); }
};

document.addEventListener("keydown", event => {
  if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open || /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "checkbox") return;
  const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  const tool = name => () => { const option = [...$("tool").options].find(option => option.value === name); if (!option.disabled) $("tool").value = name; };
  const actions = {
    "+": () => zoom(stage.scale * 1.5), "=": () => zoom(stage.scale * 1.5), "-": () => zoom(stage.scale / 1.5), 0: fit, 1: () => zoom(1),
    d: () => showPlane("developed"), r: () => showPlane("raw"),
    e: () => { const plane = sides[edited].picture?.planes.find(plane => plane.startsWith("electrons:")); if (plane) showPlane(plane); },
    c: () => compare(!$("compare").checked), p: () => { if (!$("pause").disabled) $("pause").click(); },
    l: tool("pan"), m: tool("patch"), f: tool("focus"), o: tool("orbit"), "?": () => $("keys").showModal(),
  };
  if (event.target === $("view") && arrows[event.key]) {
    const [dx, dy] = arrows[event.key];
    if ($("tool").value === "orbit" && orbit) { orbit.turn(dx / 20, -dy / 20); moveCamera(orbit.changes()); }
    else if (event.shiftKey) stage.move(-40 * dx, -40 * dy);
    else { const [w, h] = stage.size, [x, y] = stage.pixel ?? [w >> 1, h >> 1]; pick([Math.min(Math.max(x + dx, 0), w - 1), Math.min(Math.max(y + dy, 0), h - 1)]); }
  } else if (actions[event.key]) actions[event.key]();
  else return;
  event.preventDefault();
});

try {
  const about = await server.about();
  inputs = about.inputs;
  // Of the pictures of a data set the address names one.
  $("to-sheet").hidden = !about.has_sheet;
  sides[0].input = sides[1].input = Math.min(+(new URLSearchParams(location.search).get("input") ?? 0) || 0, inputs.length - 1);
  const names = about.has_sheet ? [`${about.name}/${inputs[sides[0].input].name}`] : inputs.map(input => input.name);
  // The end of a path tells more than its beginning.
  const short = name => name.length > 32 ? "…" + name.slice(-31) : name;
  document.title = `${names.join(", ")} – photosite`;
  $("name").textContent = names.map(short).join(" and ");
  $("name").title = names.join(" and ");
  $("input").replaceChildren(...inputs.map((input, i) => new Option(input.name, i)));
  $("input").value = sides[0].input;
  $("input-field").hidden = inputs.length < 2;
  controls = new Controls($("controls"), about.controls, change);
  drawLegend($("legend"), $("map").value);
  connect();
} catch (error) { refuse(error); }
