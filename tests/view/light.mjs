// Drives the page of `photosite view` in headless Chromium through what changes the light: the f-number, the frames of what
// moves, captures that are saved, planes of folders, and images that are too large to be sent whole.
//
//     node tests/view/light.mjs PHOTOSITE [SCREENSHOTS]
//
// Run it in a folder with playwright-core. The page must show the bytes that `photosite render` writes for the same keys,
// and a capture that it saves must render to the bytes that it showed; noise of light is that of the report; means of large
// images, and figures of patches of them, are those of all pixels of the files.
import { readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { browser, check, difference, folder, open, photosite, readNpy, readPng, view } from "./harness.mjs";

const [, , given, pictures] = process.argv;
const program = resolve(given);
const here = folder();
const room = resolve(import.meta.dirname, "room.toml"), box = resolve(import.meta.dirname, "../../scenes/cornell-box/capture.toml");
const sets = keys => keys.flatMap(key => ["--set", key]);
const render = (input, to, ...keys) => photosite(program, "render", input, "-o", join(here, to), "--quiet", ...sets(keys));
const png = (...path) => readPng(join(here, ...path)).values;
const values = page => page.evaluate(() => [...window.state.picture.values]);
const same = (found, wanted, words) => { const differs = difference(found, wanted); check(!differs, `${words}: ${differs}`); };

/** Light of another level differs by the rounding of single precision, 6e-8, which moves a draw of photons in one of a million
 * pixels, and a digital number where it lies between two: few values, by the least that they can differ. */
function near(found, wanted, words) {
  check(found.length === wanted.length, `${words}: ${found.length} and ${wanted.length} values`);
  const others = found.map((value, i) => Math.abs(value - wanted[i])).filter(by => by > 0);
  check(others.length <= found.length / 1000 && Math.max(0, ...others) <= 2, `${words}: ${others.length} values differ, by up to ${Math.max(...others)}`);
}

const settled = page => page.waitForFunction(() => {
  const { status, picture } = window.state;
  return ["done", "stored"].includes(status?.phase) && picture && (status.phase === "stored" || picture.light === status.light && picture.trace === status.trace);
}, null, { timeout: 120_000 });

/** Acts, and waits for the answer. */
async function answered(page, act) {
  const before = await page.evaluate(() => window.state.answers);
  await act();
  await page.waitForFunction(before => window.state.answers > before, before, { timeout: 30_000 });
  check(!await page.evaluate(() => window.state.error), await page.evaluate(() => window.state.error));
}

/** Acts, and waits until light is traced anew. */
async function tracedAnew(page, act) {
  const { trace } = await page.evaluate(() => window.state.status);
  await act();
  await page.waitForFunction(trace => window.state.status.trace > trace, trace, { timeout: 30_000 });
  await settled(page);
}

const slider = (page, name) => page.getByRole("slider", { name, exact: true });
const frame = page => page.getByRole("spinbutton", { name: "Frame" });

/** What is saved renders to what is shown. */
async function saves(page, words, compare = same) {
  const shown = await values(page);
  await page.evaluate(() => { window.state.saved = null; });
  await page.getByRole("button", { name: "Save as a capture file" }).click();
  await page.waitForFunction(() => window.state.saved, null, { timeout: 30_000 });
  const text = await page.evaluate(() => window.state.saved), file = join(here, "saved.toml");
  writeFileSync(file, text);
  photosite(program, "render", file, "-o", join(here, "of-saved"), "--force", "--quiet");
  compare(shown, png("of-saved", "image.png"), `${words}, saved and rendered`);
  return text;
}

async function withPage(chromium, words, act) {
  const server = await view(program, words);
  const { page, errors } = await open(chromium, server.address);
  await settled(page);
  await act(page, server);
  check(!errors.length, `the console says:\n${errors.join("\n")}`);
  check(!server.log().includes("panicked"), server.log());
  await page.close();
  await server.end("SIGTERM");
}

/** A pinhole answers at once. */
async function pinhole(chromium) {
  render(room, "f8", "lens.f_number=8");
  await withPage(chromium, [room], async page => {
    const { trace } = await page.evaluate(() => window.state.status);
    check(!await page.locator(".control").filter({ has: slider(page, "f-number") }).getByText("traces again").isVisible(), "f-numbers of a pinhole are marked");
    await answered(page, () => slider(page, "f-number").fill("3"));
    near(await values(page), png("f8", "image.png"), "a pinhole at f/8");
    await answered(page, () => slider(page, "Exposure time").fill("-5"));
    const time_s = await page.evaluate(() => window.state.picture.settings["exposure.time_s"]);
    render(room, "f8-slow", "lens.f_number=8", `exposure.time_s=${time_s}`);
    near(await values(page), png("f8-slow", "image.png"), "a pinhole at f/8, exposed for longer");
    const { noise_ratio } = JSON.parse(readFileSync(join(here, "f8-slow/capture.json"))).render;
    await page.waitForFunction(wanted => Math.abs(window.state.noise / wanted - 1) < 1e-6, noise_ratio, { timeout: 10_000 });
    check((await page.evaluate(() => window.state.status)).trace === trace, "light of a pinhole is traced anew");
    const text = await saves(page, "a pinhole", near);
    check(text.includes("#   lens.f_number = 8.0") && text.includes(`#   exposure.time_s = ${time_s}`), text.slice(0, 400));
  });
  console.log("f-numbers of a pinhole and other exposures answer with the images of photosite render, and its noise of light");
}

/** Light goes through a lens anew. */
async function lens(chromium) {
  const keys = ["sensor.resolution_px=[160,120]", "render.samples_per_pixel=8"];
  await withPage(chromium, [box, ...sets(keys)], async page => {
    check(await page.locator(".control").filter({ has: slider(page, "f-number") }).getByText("traces again").isVisible(), "f-numbers of a lens are not marked");
    await tracedAnew(page, () => slider(page, "f-number").fill("2.5"));
    const n = await page.evaluate(() => window.state.picture.settings["lens.f_number"]);
    check(Math.abs(n - 2 ** 2.5) < 1e-4, `f/${n}`);
    render(box, "through", ...keys, `lens.f_number=${n}`);
    same(await values(page), png("through", "image.png"), `f/${n}`);
    await answered(page, () => slider(page, "Gain").fill("6"));
    await answered(page, () => page.getByRole("combobox", { name: "Tone curve", exact: true }).selectOption("filmic"));
    const text = await saves(page, "a lens");
    check(text.includes(`#   lens.f_number = ${n}`) && text.includes("#   exposure.gain_db = 6"), text.slice(0, 400));
  });
  console.log("light through a lens is traced anew; a capture that is saved renders to what was shown");
}

/** Each frame of what moves has light of its own. */
async function frames(chromium) {
  const keys = ["exposure.frames=3", "exposure.frame_interval_s=0.1", "camera.motion.velocity_m_per_s=[0.3,0,0]"];
  render(room, "frames", ...keys);
  await withPage(chromium, [room, ...sets(keys)], async page => {
    same(await values(page), png("frames", "image-0000.png"), "frame 0");
    await tracedAnew(page, () => frame(page).fill("2"));
    same(await values(page), png("frames", "image-0002.png"), "frame 2");
    await answered(page, () => page.getByRole("combobox", { name: "Show", exact: true }).selectOption("truth:depth"));
    same(await page.evaluate(() => [...new Set(window.state.picture.channels)]), ["depth"], "channels of depth");
    await answered(page, () => page.getByRole("combobox", { name: "Show", exact: true }).selectOption("developed"));
    await tracedAnew(page, () => frame(page).fill("0"));
    same(await values(page), png("frames", "image-0000.png"), "frame 0 again");
  });
  console.log("frames of a camera that moves have the bytes of photosite render");
}

/** Planes that a folder holds beside its light. */
async function stored(chromium) {
  render(room, "stored", "output.irradiance=true", "output.ideal=true", 'output.truth=["depth","normal","instance"]', 'output.truth_formats=["exr","npy"]');
  await withPage(chromium, [join(here, "stored")], async page => {
    const show = page.getByRole("combobox", { name: "Show", exact: true });
    const names = await show.locator("option").evaluateAll(options => options.map(option => option.value));
    for (const name of ["ideal", "truth:depth", "truth:normal", "truth:instance"]) check(names.includes(name), `${name} is none of ${names}`);
    for (const name of names.filter(name => /^(truth|ideal|irradiance)/.test(name))) {
      await answered(page, () => show.selectOption(name));
      check(await page.evaluate(() => window.state.picture.plane) === name, name);
      if (!name.startsWith("truth")) continue;
      const found = await page.evaluate(() => window.state.picture.values.map(value => value).join(" "));
      const wanted = readNpy(join(here, `stored/truth-${name.slice(6)}.npy`)).join(" ");
      check(found === wanted, `${name} is another than that of the file`);
    }
    check(names.some(name => name.startsWith("irradiance:")), "there are no bands");
    await answered(page, () => show.selectOption("developed"));
    await answered(page, () => slider(page, "Gain").fill("6"));
    await saves(page, "a folder");
  });
  console.log("folders show their ground truth, irradiance and ideal image; a capture of them is saved whole");
}

/** Of large images only what is seen is sent. */
async function large(chromium) {
  const size = [1600, 1200];
  render(box, "large", `sensor.resolution_px=[${size}]`, "render.samples_per_pixel=1", 'output.raw=["dng","npy"]');
  const whole = png("large", "image.png"), raw = readNpy(join(here, "large/raw.npy"));
  await withPage(chromium, [join(here, "large")], async page => {
    const sent = () => page.evaluate(() => { const { width, height, full, at, step, is_mean } = window.state.picture; return { width, height, full, at, step, is_mean }; });
    const first = await sent();
    check(first.is_mean && first.step === 2 && first.width === 800 && first.height === 600, JSON.stringify(first));
    same(first.full, size, "columns and rows of all");
    const at = (x, y, c) => whole[(y * size[0] + x) * 3 + c];
    const means = [];
    for (let y = 0; y < 600; y++) for (let x = 0; x < 800; x++) for (let c = 0; c < 3; c++) means.push(Math.round((at(2 * x, 2 * y, c) + at(2 * x + 1, 2 * y, c) + at(2 * x, 2 * y + 1, c) + at(2 * x + 1, 2 * y + 1, c)) / 4));
    same(await values(page), means, "means of four pixels");
    // One to one the pixels are those of the file.
    const count = await page.evaluate(() => window.state.pictures);
    await page.getByRole("button", { name: "1:1" }).click();
    await page.waitForFunction(count => window.state.pictures > count, count, { timeout: 30_000 });
    const part = await sent();
    check(part.step === 1 && part.width < size[0] && part.at[0] > 0, JSON.stringify(part));
    const found = await values(page), crop = [];
    for (let y = 0; y < part.height; y++) crop.push(...whole.subarray(((part.at[1] + y) * size[0] + part.at[0]) * 3, ((part.at[1] + y) * size[0] + part.at[0] + part.width) * 3));
    same(found, crop, "pixels of a part");
    // A patch is measured by all of its pixels, whatever the screen shows of them.
    await page.getByRole("button", { name: "Fit" }).click();
    await answered(page, () => page.getByRole("combobox", { name: "Show", exact: true }).selectOption("raw"));
    await page.getByRole("combobox", { name: "Tool" }).selectOption("patch");
    const corner = await page.evaluate(() => { const box = document.getElementById("view").getBoundingClientRect(); return [box.left + box.width / 2, box.top + box.height / 2]; });
    await page.mouse.move(...corner);
    await page.mouse.down();
    await page.mouse.move(corner[0] + 60, corner[1] + 40, { steps: 4 });
    await page.mouse.up();
    await page.waitForFunction(() => /^Patch of/.test(document.getElementById("figures").textContent), null, { timeout: 10_000 });
    // Words and figures of the same moment: a patch that is still being drawn may have been measured, too.
    const [words, figures, tile] = await page.evaluate(() => [document.getElementById("figures").textContent, window.state.figures, window.state.picture.raw.tile]);
    const [, w, h, x0, y0] = words.match(/Patch of (\d+) × (\d+) pixels at (\d+), (\d+)/).map(Number);
    for (const { name, mean, sd, count } of figures) {
      const all = [];
      for (let y = y0; y < y0 + h; y++) for (let x = x0; x < x0 + w; x++) if (tile[y % tile.length][x % tile[0].length] === name) all.push(raw[y * size[0] + x]);
      const wanted = all.reduce((sum, v) => sum + v, 0) / all.length, square = all.reduce((sum, v) => sum + (v - wanted) ** 2, 0) / (all.length - 1);
      check(count === all.length && Math.abs(mean / wanted - 1) < 1e-9 && Math.abs(sd / Math.sqrt(square) - 1) < 1e-6, `${name}: ${count} pixels of ${mean} ± ${sd}, and ${all.length} of ${wanted} ± ${Math.sqrt(square)}`);
    }
    if (pictures) await page.screenshot({ path: join(pictures, "light-large.png") });
  });
  console.log("large images are sent as fine as the screen, and measured by all of their pixels");
}

const chromium = await browser();
try {
  for (const part of [pinhole, lens, frames, stored, large]) await part(chromium);
} finally {
  await chromium.close();
}
process.exit(0);
