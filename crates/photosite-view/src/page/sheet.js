// The contact sheet of a data set: images that pass the filters, what is drawn over them, one of them large.
// `window.state` is for tests: numbers of the images that pass, how many are drawn, errors, the one that is large.
import { readable } from "./controls.js";
import { draw } from "./overlays.js";
import * as server from "./server.js";

const $ = id => document.getElementById(id);
const state = { shown: [], drawn: 0, error: null, large: null, overlays: null };
window.state = state;

/** Requests that are under way at the same time. */
const TOGETHER = 4;
let pictures = [], columns = new Map(), widths = [];
const filters = new Map(), cells = new Map(), kept = new Map();
const wanted = () => new Set([...$("overlays").querySelectorAll(":checked")].map(box => box.value));

// Requests, those of what is seen first

const waiting = [];
let running = 0;
function soon(work) { waiting.push(work); next(); }
async function next() {
  if (running >= TOGETHER || !waiting.length) return;
  running++;
  try { await waiting.shift()(); } catch (error) { state.error = error.message; tell(error); }
  running--;
  next();
}

function tell(error) {
  if (error instanceof server.Refused) return;
  $("lost").hidden = false;
  $("lost").textContent = "The connection is lost: photosite view may have ended. Reload the page when it is back.";
}

/** What is drawn over an image, asked for once; of the last few hundred. */
async function overlaysOf(number) {
  if (!kept.has(number)) {
    if (kept.size > 500) kept.delete(kept.keys().next().value);
    kept.set(number, server.overlays(number).catch(error => {
      if (!(error instanceof server.Refused)) { kept.delete(number); throw error; }
      return { refused: [error.message, error.help].filter(Boolean).join(": ") };
    }));
  }
  return kept.get(number);
}

/** Draws an image with what is wanted over it; says why something is missing. */
async function paint(canvas, number, width) {
  const names = wanted();
  const [bitmap, overlays] = await Promise.all([server.image(number, width), names.size ? overlaysOf(number) : null]);
  // What is drawn over few pixels needs more of them.
  const times = width ? 1 : Math.max(1, Math.floor(960 / bitmap.width));
  [canvas.width, canvas.height] = [times * bitmap.width, times * bitmap.height];
  const context = canvas.getContext("2d");
  context.imageSmoothingEnabled = false;
  context.drawImage(bitmap, 0, 0, canvas.width, canvas.height);
  bitmap.close();
  if (overlays && !overlays.refused) draw(canvas, overlays, names);
  return overlays;
}

// Cells

const seen = new IntersectionObserver(entries => {
  for (const entry of entries) if (entry.isIntersecting) show(+entry.target.dataset.number);
}, { root: null, rootMargin: "300px" });

const smallWidth = () => widths.find(width => width >= +$("size").value * Math.min(devicePixelRatio, 2)) ?? widths.at(-1);

function show(number) {
  const cell = cells.get(number), look = `${smallWidth()} ${[...wanted()]}`;
  if (cell.look === look) return;
  cell.look = look;
  soon(async () => {
    if (cell.look !== look || !cell.root.isConnected) return;
    try {
      await paint(cell.canvas, number, smallWidth());
      state.drawn++;
    } catch (error) {
      if (!(error instanceof server.Refused)) { cell.look = null; throw error; }
      if (error.status === 503) {
        // Others ask for images, too.
        cell.look = null;
        setTimeout(() => show(number), 500);
        return;
      }
      cell.caption.textContent = `${nameOf(pictures[number])}: ${error.message}`;
      cell.caption.classList.add("bad");
    }
  });
}

const nameOf = ({ camera, frame }) => `${camera} ${frame}`;

function cell(number) {
  const root = document.createElement("li"), button = document.createElement("button"), canvas = document.createElement("canvas"), caption = document.createElement("span");
  const name = nameOf(pictures[number]);
  Object.assign(canvas, { width: 160, height: 120, ariaHidden: "true" });
  Object.assign(caption, { className: "caption", textContent: name });
  button.ariaLabel = name;
  button.onclick = () => enlarge(number);
  root.dataset.number = number;
  button.append(canvas, caption);
  root.append(button);
  seen.observe(root);
  return { root, button, canvas, caption, look: null };
}

/** All cells that are seen are drawn anew. */
function redraw() {
  const bottom = $("sheet").getBoundingClientRect().bottom + 300;
  for (const number of state.shown) {
    const { top, height } = cells.get(number).root.getBoundingClientRect();
    cells.get(number).look = null;
    if (top < bottom && top + height > -300) show(number);
    else { seen.unobserve(cells.get(number).root); seen.observe(cells.get(number).root); }
  }
  if (state.large !== null) enlarge(state.large);
}

// Filters

/** Numbers and words by which images differ; of vectors their components. */
function flat(facts) {
  const found = {};
  for (const [key, value] of Object.entries(facts)) {
    if (Array.isArray(value) && value.length <= 4 && value.every(x => typeof x === "number")) value.forEach((x, i) => { found[`${key}[${i}]`] = x; });
    else found[key] = typeof value === "number" ? value : typeof value === "string" ? value : JSON.stringify(value);
  }
  return found;
}

function makeFilters() {
  for (const picture of pictures) for (const [key, value] of Object.entries(picture.flat)) {
    if (!columns.has(key)) columns.set(key, new Set());
    columns.get(key).add(value);
  }
  for (const [key, values] of columns) if (values.size < 2) columns.delete(key);
  for (const [key, values] of columns) {
    const box = document.createElement("fieldset"), legend = Object.assign(document.createElement("legend"), { textContent: key });
    box.append(legend);
    if ([...values].every(value => typeof value === "number")) {
      const ends = [Math.min(...values), Math.max(...values)], range = Object.assign(document.createElement("div"), { className: "range" });
      const inputs = ends.map((end, i) => Object.assign(document.createElement("input"), { type: "number", step: "any", placeholder: readable(end), ariaLabel: `${key} ${i ? "to" : "from"}`, oninput: filter }));
      range.append(inputs[0], "to", inputs[1]);
      box.append(range);
      filters.set(key, value => typeof value === "number" && inputs.every(({ value: limit }, i) => limit === "" || (i ? value <= +limit : value >= +limit)));
    } else {
      const words = [...values].map(String).sort();
      const select = Object.assign(document.createElement("select"), { ariaLabel: key, onchange: filter });
      select.append(new Option("any", ""), ...words.map(word => new Option(word, `=${word}`)));
      box.append(select);
      filters.set(key, value => select.value === "" || select.value === `=${value}`);
    }
    $("filters").append(box);
    $("sort").append(new Option(key, key));
  }
}

function filter() {
  const camera = $("camera").value, key = $("sort").value;
  const passes = picture => (!camera || picture.camera === camera) && [...filters].every(([key, test]) => test(picture.flat[key]));
  const order = (a, b) => {
    const [x, y] = [pictures[a].flat[key], pictures[b].flat[key]];
    return !key ? 0 : typeof x === "number" && typeof y === "number" ? x - y : String(x).localeCompare(String(y));
  };
  state.shown = pictures.map((_, number) => number).filter(number => passes(pictures[number])).sort(order);
  for (const number of state.shown) if (!cells.has(number)) cells.set(number, cell(number));
  $("sheet").replaceChildren(...state.shown.map(number => cells.get(number).root));
  $("count").textContent = `${state.shown.length} of ${pictures.length} images`;
}

// One image large

async function enlarge(number) {
  state.large = number;
  state.overlays = null;
  const picture = pictures[number], place = state.shown.indexOf(number);
  $("large-name").textContent = nameOf(picture);
  $("picture").ariaLabel = `Image of ${nameOf(picture)}`;
  $("open").href = `frame?input=${number}`;
  $("before").disabled = place <= 0;
  $("after").disabled = place < 0 || place + 1 >= state.shown.length;
  $("facts").replaceChildren(...[["frame", picture.frame], ["camera", picture.camera], ["time", picture.time_s === null ? "" : `${readable(picture.time_s)} s`], ...Object.entries(picture.flat)].filter(([, value]) => value !== "").map(([key, value]) => {
    const row = document.createElement("tr");
    row.append(...[key, readable(value, 6)].map(text => Object.assign(document.createElement("td"), { textContent: text })));
    return row;
  }));
  if (!$("large").open) $("large").showModal();
  try {
    const overlays = await paint($("picture"), number);
    if (state.large !== number) return enlarge(state.large);
    const notes = overlays?.refused ? [overlays.refused] : overlays?.notes ?? [];
    $("notes").replaceChildren(...notes.map(text => Object.assign(document.createElement("p"), { textContent: text })));
    state.overlays = overlays ?? {};
  } catch (error) {
    state.error = error.message;
    $("notes").textContent = error.message;
    tell(error);
  }
}

function step(by) {
  const place = state.shown.indexOf(state.large) + by;
  if (place >= 0 && place < state.shown.length) enlarge(state.shown[place]);
}

function focus(number) {
  const found = cells.get(number);
  found?.root.scrollIntoView({ block: "nearest" });
  found?.button.focus();
}

$("before").onclick = () => step(-1);
$("after").onclick = () => step(1);
$("close").onclick = () => $("large").close();
$("large").onclose = () => { const number = state.large; state.large = null; focus(number); };
$("large").addEventListener("keydown", event => {
  const by = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
  if (by) { step(by); event.preventDefault(); }
});
$("sheet").addEventListener("keydown", event => {
  const number = +event.target.closest("li")?.dataset.number, place = state.shown.indexOf(number);
  const across = Math.max(1, state.shown.findIndex((other, i) => i > 0 && cells.get(other).root.offsetTop > cells.get(state.shown[0]).root.offsetTop));
  const to = { ArrowLeft: place - 1, ArrowRight: place + 1, ArrowUp: place - across, ArrowDown: place + across, Home: 0, End: state.shown.length - 1 }[event.key];
  if (place < 0 || to === undefined) return;
  if (to in state.shown) focus(state.shown[to]);
  event.preventDefault();
});
$("camera").onchange = filter;
$("sort").onchange = filter;
$("size").oninput = () => { $("sheet").style.setProperty("--size", `${$("size").value}px`); };
$("size").onchange = redraw;
$("overlays").onchange = redraw;
$("goto").onchange = () => {
  const frame = +$("goto").value, found = state.shown.find(number => pictures[number].frame === frame);
  if (found === undefined) $("count").textContent = `${state.shown.length} of ${pictures.length} images; frame ${frame} is not among them`;
  else focus(found);
};
$("reset").onclick = () => {
  for (const input of $("filters").querySelectorAll("input, select")) input.value = "";
  $("camera").value = $("sort").value = "";
  filter();
};

try {
  const [about, sheet] = [await server.about(), await server.sheet()];
  document.title = `${about.name} – photosite`;
  $("name").textContent = $("name").title = about.name;
  widths = sheet.widths;
  pictures = sheet.pictures.map(picture => ({ ...picture, flat: flat(picture.facts) }));
  $("camera").append(...sheet.cameras.map(name => new Option(name, name)));
  $("goto").max = sheet.frames - 1;
  makeFilters();
  filter();
} catch (error) {
  state.error = error.message;
  $("count").textContent = error.message;
  tell(error);
}
