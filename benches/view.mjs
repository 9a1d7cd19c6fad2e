// How soon the page of `photosite view` answers, by the page's own clock, in headless Chromium.
//
//     node benches/view.mjs PHOTOSITE
//
// Run it where playwright-core is found: in its folder, or with NODE_PATH=FOLDER/node_modules. Two tables come out: the
// time from the input event of a control until what it asks for is on the screen, and that from a move of the camera to the
// first image of the light that is traced anew. The room of the Cornell box is traced with few samples: sensor, development
// and page do not know how long light was traced.
import { resolve } from "node:path";
import { browser, open, photosite, view, folder } from "../tests/view/harness.mjs";

const [, , given] = process.argv;
const program = resolve(given ?? "target/release/photosite");
const capture = resolve(import.meta.dirname, "../scenes/cornell-box/capture.toml");

/** Columns and rows, moves of each control, and the longest median that is good. */
const SIZES = [
  { size: [800, 600], moves: 12, goal_ms: 100 },
  { size: [1600, 1250], moves: 12, goal_ms: 300 },
  { size: [5200, 3900], moves: 4, goal_ms: null },
];
/** Controls, and the value of each move. */
const SLIDERS = {
  "Exposure time": i => -9 + i / 4,
  Gain: i => 1 + i,
  Temperature: i => 20 + i,
  Sharpening: i => 0.1 + i / 10,
  "Colour temperature": i => 4000 + 250 * i,
};
const CHOICES = { Demosaicking: "develop.demosaic", "Tone curve": "develop.tone_curve" };

const sorted = values => [...values].sort((a, b) => a - b);
const part = (values, p) => sorted(values)[Math.min(Math.floor(p * values.length), values.length - 1)];
const ms = value => value.toFixed(0);

/** Acts, and waits for the answer: milliseconds until it is on the screen, and of these in the server. */
async function answered(page, act) {
  const before = await page.evaluate(() => window.state.answers);
  await act();
  await page.waitForFunction(n => window.state.answers > n, before, { timeout: 60_000 });
  return page.evaluate(() => [window.state.latency, 1e3 * window.state.picture.seconds]);
}

/** Times of all moves of a control but the first, which may fill caches that the others find. */
async function control(page, name, moves) {
  const times = [];
  if (SLIDERS[name]) {
    const slider = page.getByRole("slider", { name, exact: true });
    for (let i = 0; i < moves; i++) times.push(await answered(page, () => slider.fill(String(SLIDERS[name](i)))));
  } else {
    const box = page.getByRole("combobox", { name, exact: true });
    const names = await box.locator("option:not([disabled])").evaluateAll(options => options.map(option => option.value));
    for (const option of [...names, ...names].slice(1, moves + 1)) times.push(await answered(page, () => box.selectOption(option)));
  }
  return times.slice(1);
}

const chromium = await browser();
console.log("| image | control | median, ms | 95 %, ms | in the server, ms | goal, ms |\n|---|---|---|---|---|---|");
const here = folder();
let isMet = true;
for (const { size, moves, goal_ms } of SIZES) {
  // Light that lies in a folder leaves the cores to the server and the page.
  const stored = `${here}/${size[0]}`;
  photosite(program, "render", capture, "-o", stored, "--quiet", "--spp", 1, "--size", size.join("x"));
  const server = await view(program, [stored]);
  const { page } = await open(chromium, server.address);
  await page.waitForFunction(() => window.state.pictures > 0, null, { timeout: 120_000 });
  for (const name of [...Object.keys(SLIDERS), ...Object.keys(CHOICES)]) {
    const times = await control(page, name, moves);
    const [all, own] = [0, 1].map(k => times.map(time => time[k]));
    const is = goal_ms === null || part(all, 0.5) <= goal_ms;
    isMet &&= is;
    console.log(`| ${size.join(" × ")} | ${name} | ${ms(part(all, 0.5))} | ${ms(part(all, 0.95))} | ${ms(part(own, 0.5))} | ${goal_ms === null ? "" : `${goal_ms}${is ? "" : ", not reached"}`} |`);
    await answered(page, () => page.getByRole("button", { name: "Reset settings" }).click());
  }
  await page.close();
  await server.end("SIGTERM");
}

console.log("\n| image | camera | median, ms | slowest, ms |\n|---|---|---|---|");
for (const { size } of SIZES.slice(0, 2)) {
  const server = await view(program, [capture, "--spp", 64, "--size", size.join("x")]);
  const { page } = await open(chromium, server.address);
  await page.waitForFunction(() => window.state.pictures > 1, null, { timeout: 120_000 });
  await page.getByRole("combobox", { name: "Tool" }).selectOption("orbit");
  const times = [];
  for (let i = 0; i < 6; i++) {
    // From the key to the first image of another trace.
    times.push(await page.evaluate(async () => {
      const trace = window.state.status.trace, canvas = document.getElementById("view"), begun = performance.now();
      canvas.focus();
      canvas.dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowRight", bubbles: true }));
      while (!(window.state.status.trace > trace && window.state.picture.trace > trace)) await new Promise(requestAnimationFrame);
      await new Promise(done => requestAnimationFrame(() => setTimeout(done)));
      return performance.now() - begun;
    }));
  }
  console.log(`| ${size.join(" × ")} | turned by a key | ${ms(part(times, 0.5))} | ${ms(part(times, 1))} |`);
  await page.close();
  await server.end("SIGTERM");
}
await chromium.close();
process.exit(isMet ? 0 : 1);
