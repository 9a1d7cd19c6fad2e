// The page of photosite view: what its controls, buttons and keys do.
import { drawLegend } from "./colours.js";
import { Controls } from "./controls.js";
import { measure, pick } from "./inspect.js";
import { camera, connect, traceAnew } from "./light.js";
import { lookCloser, needsTrace, refresh, show, showSettings, untold } from "./images.js";
import { approach, fit, markCorner, move, pickByTool, turn, zoom } from "./pointer.js";
import * as server from "./server.js";
import { $, hasOwnLight, query, refuse, session, sides, stage, state } from "./session.js";

// Settings

/** A control has been moved; without a value it is reset. */
function change(key, value) {
  const side = sides[session.edited], { settings } = side;
  session.changedAt ??= performance.now();
  if (side.picture?.anew?.includes(key)) {
    if (value === undefined) delete session.anew[key];
    return traceAnew(value === undefined ? {} : { [key]: value });
  }
  if (value === undefined) delete settings[key];
  else settings[key] = value;
  // A time that is given is no automatic one, and a temperature is one of white.
  if (key === "exposure.time_s" && value !== undefined) delete settings["exposure.auto"];
  if (key === "exposure.auto") {
    if (value === false && side.picture) { settings["exposure.time_s"] = side.picture.settings["exposure.time_s"]; delete settings[key]; } else delete settings["exposure.time_s"];
  }
  if ((key === "develop.temperature_k" || key === "develop.tint") && value !== undefined) {
    settings["develop.white_balance"] = "temperature";
    settings["develop.temperature_k"] ??= 5500;
  }
  if (key === "develop.white_balance" && value !== "temperature") { delete settings["develop.temperature_k"]; delete settings["develop.tint"]; }
  if (key === "develop.white_balance" && value === "temperature") settings["develop.temperature_k"] ??= 5500;
  showSettings(side);
  if (needsTrace(side)) return refuse(new server.Refused(untold(side), 409));
  refresh([session.edited]);
}

function edit(i) {
  session.edited = i;
  const side = sides[i];
  $("side").value = i;
  $("input").value = side.input;
  $("frame").value = hasOwnLight(side) ? state.status.frame : side.frame;
  if (side.picture) show(i);
  refresh([i]);
}

function compare(isOn) {
  if (isOn && !sides[1].picture) {
    // B begins as A is, or shows the second input.
    Object.assign(sides[1], { input: session.inputs.length > 1 ? 1 : sides[0].input, plane: sides[0].plane, frame: sides[0].frame, settings: { ...sides[0].settings } });
  }
  $("compare").checked = isOn;
  stage.split = isOn ? +$("split").value : null;
  if (!isOn && session.edited === 1) edit(0);
  stage.draw();
  refresh();
}

function showPlane(plane) {
  session.changedAt ??= performance.now();
  sides[session.edited].plane = plane;
  refresh([session.edited]);
}

const again = () => { if (sides[session.edited].picture) show(session.edited); };
$("plane").onchange = () => showPlane($("plane").value);
$("frame").oninput = () => {
  if (!$("frame").checkValidity() || $("frame").value === "") return;
  const side = sides[session.edited];
  if (hasOwnLight(side)) return traceAnew();
  session.changedAt ??= performance.now();
  side.frame = +$("frame").value;
  refresh([session.edited]);
};
$("map").onchange = () => { drawLegend($("legend"), $("map").value); again(); };
for (const id of ["low", "high"]) $(id).oninput = () => { $("auto-scale").checked = false; again(); };
$("auto-scale").onchange = again;
$("plot").onchange = measure;
$("compare").onchange = () => compare($("compare").checked);
$("side").onchange = () => { if ($("side").value === "1" && !$("compare").checked) compare(true); edit(+$("side").value); };
$("input").onchange = () => { Object.assign(sides[session.edited], { input: +$("input").value, settings: {} }); refresh([session.edited]); };
$("split").oninput = () => { stage.split = $("compare").checked ? +$("split").value : null; stage.draw(); };
$("zoom-in").onclick = () => zoom(stage.scale * 1.5);
$("zoom-out").onclick = () => zoom(stage.scale / 1.5);
$("fit").onclick = fit;
$("actual").onclick = () => zoom(1);
$("help").onclick = () => $("keys").showModal();
new ResizeObserver(lookCloser).observe($("view"));

// Light

const order = what => server.order(what).catch(refuse);
$("pause").onclick = () => order(state.status?.phase === "paused" ? "continue" : "pause");
$("stop").onclick = () => order("stop");
$("again").onclick = () => {
  // A sensor that this light does not serve becomes the one that light is traced for.
  const { settings, picture } = sides[session.edited];
  const preset = settings["sensor.preset"];
  delete settings["sensor.preset"];
  const size = picture?.raw ? picture.raw.active.slice(2) : null;
  traceAnew(preset ? { "sensor.preset": preset, ...(size ? { "sensor.resolution_px": size } : {}) } : {});
};
const typed = (id, key) => { $(id).onchange = () => { if (+$(id).value > 0) traceAnew({ [key]: +$(id).value }); }; };
typed("focal", "lens.focal_length_mm");
typed("focus", "lens.focus_distance_m");
$("keep-irradiance").onchange = () => traceAnew({ "output.irradiance": $("keep-irradiance").checked });
$("keep-ideal").onchange = () => traceAnew({ "output.ideal": $("keep-ideal").checked });
$("camera-reset").onclick = () => {
  for (const key of Object.keys(session.anew)) if (/^(camera|lens)\./.test(key)) delete session.anew[key];
  traceAnew();
};

// All settings

$("reset").onclick = () => {
  session.changedAt ??= performance.now();
  sides[session.edited].settings = {};
  showSettings(sides[session.edited]);
  refresh([session.edited]);
};
$("save").onclick = async () => {
  try {
    const text = await server.capture(query(sides[session.edited]));
    state.saved = text;
    const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(new Blob([text], { type: "application/toml" })), download: "capture.toml" });
    link.click();
    URL.revokeObjectURL(link.href);
  } catch (error) { refuse(error); }
};

// Keys

const ARROWS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
const tool = name => () => { const option = [...$("tool").options].find(option => option.value === name); if (!option.disabled) $("tool").value = name; };
const KEYS = {
  "+": () => zoom(stage.scale * 1.5), "=": () => zoom(stage.scale * 1.5), "-": () => zoom(stage.scale / 1.5), 0: fit, 1: () => zoom(1),
  d: () => showPlane("developed"), r: () => showPlane("raw"),
  e: () => { const plane = sides[session.edited].picture?.planes.find(plane => plane.startsWith("electrons:")); if (plane) showPlane(plane); },
  c: () => compare(!$("compare").checked), p: () => { if (!$("pause").disabled) $("pause").click(); },
  l: tool("pan"), m: tool("patch"), f: tool("focus"), o: tool("orbit"), "?": () => $("keys").showModal(),
};

function arrow([dx, dy], isShifted) {
  if ($("tool").value === "orbit" && camera.orbit) return turn(dx / 20, -dy / 20, isShifted);
  if (isShifted) return move(-40 * dx, -40 * dy);
  const [w, h] = stage.size, [x, y] = stage.pixel ?? [w >> 1, h >> 1];
  const pixel = [Math.min(Math.max(x + dx, 0), w - 1), Math.min(Math.max(y + dy, 0), h - 1)];
  markCorner(pixel);
  pick(pixel);
}

/** Keys of the image itself. */
const ON_PICTURE = { Enter: () => { if (stage.pixel) pickByTool(stage.pixel); }, PageUp: () => approach(-1), PageDown: () => approach(1), Escape: () => pickByTool(null) };

document.addEventListener("keydown", event => {
  const isTyped = /^(INPUT|SELECT|TEXTAREA)$/.test(event.target.tagName) && event.target.type !== "checkbox";
  if (event.ctrlKey || event.metaKey || event.altKey || $("keys").open || isTyped) return;
  if (event.target === $("view") && ARROWS[event.key]) arrow(ARROWS[event.key], event.shiftKey);
  else if (event.target === $("view") && ON_PICTURE[event.key]) ON_PICTURE[event.key]();
  else if (KEYS[event.key]) KEYS[event.key]();
  else return;
  event.preventDefault();
});

try {
  const about = await server.about(), { inputs } = about;
  session.inputs = inputs;
  // Of the images of a data set the address names one.
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
  session.controls = new Controls($("controls"), about.controls, change);
  drawLegend($("legend"), $("map").value);
  connect();
} catch (error) { refuse(error); }
