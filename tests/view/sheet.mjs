// Drives the contact sheet of a data set in headless Chromium.
//
//     node tests/view/sheet.mjs PHOTOSITE [SCREENSHOTS]
//
// Run it in a folder with playwright-core. Filters must leave the images that the manifest says; corners and boxes must
// stand where the reports have them; points of one number on the epipolar lines of both cameras must lie in one plane
// with both lenses, by the poses and the distortion of `capture.json`; the image that the live view shows must have
// the bytes of `image.png`.
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { browser, check, difference, folder, nameless, open, photosite, readPng, view } from "./harness.mjs";

const [, , given, pictures] = process.argv;
const program = resolve(given);
const set = join(folder(), "rig");
photosite(program, "dataset", resolve(import.meta.dirname, "rig.toml"), "-o", set, "--quiet");
const lines = readFileSync(join(set, "manifest.jsonl"), "utf8").trim().split("\n").map(line => JSON.parse(line));
const report = number => JSON.parse(readFileSync(join(set, lines[number].folder, "capture.json")));
const near = (a, b, tolerance) => Math.abs(a - b) <= tolerance;

/** The pixel values of the images that pass. */
const shown = page => page.evaluate(() => window.state.shown);
const numbers = passes => lines.map((_, number) => number).filter(number => passes(lines[number]));
const same = (found, wanted, words) => { const differs = difference(found, wanted); check(!differs, `${words}: ${found} in place of ${wanted}`); };

async function filters(page) {
  const RED = "materials.left-ball.reflectance", TIME = "exposure.time_s";
  await page.getByRole("combobox", { name: "Camera" }).selectOption("right");
  same(await shown(page), numbers(line => line.camera === "right"), "of the right camera");
  const colour = page.getByRole("combobox", { name: RED, exact: true });
  await colour.selectOption("=cornell/red");
  same(await shown(page), numbers(line => line.camera === "right" && line.varied[RED] === "cornell/red"), "and red");
  await page.getByRole("combobox", { name: "Camera" }).selectOption("");
  const from = page.getByRole("spinbutton", { name: `${TIME} from` }), to = page.getByRole("spinbutton", { name: `${TIME} to` });
  await from.fill("0.0025");
  same(await shown(page), numbers(line => line.varied[RED] === "cornell/red" && line.varied[TIME] >= 0.0025), "exposed for long, and red");
  await page.getByRole("button", { name: "Reset filters" }).click();
  same(await shown(page), numbers(() => true), "without filters");
  await to.fill("0.001");
  same(await shown(page), numbers(line => line.varied[TIME] <= 0.001), "exposed for a short time");
  const words = await page.getByRole("status").innerText();
  check(words === `${numbers(line => line.varied[TIME] <= 0.001).length} of ${lines.length} images`, words);
  await page.getByRole("button", { name: "Reset filters" }).click();
  await page.getByRole("combobox", { name: "Sort by" }).selectOption(RED);
  const sorted = (await shown(page)).map(number => lines[number].varied[RED]);
  same(sorted, [...sorted].sort(), "sorted");
  await page.getByRole("button", { name: "Reset filters" }).click();
  await page.getByRole("spinbutton", { name: "Go to frame" }).fill("2");
  await page.keyboard.press("Enter");
  const focused = () => page.evaluate(() => document.activeElement.ariaLabel);
  check(await focused() === "left 2", `at ${await focused()}, and not at frame 2`);
  await page.keyboard.press("Home");
  await page.keyboard.press("ArrowRight");
  check(await focused() === "right 0", `at ${await focused()} after an arrow`);
  console.log("filters, order and jumps to a frame are those of the manifest");
}

/** The image of that number, large, with what is drawn over it. */
async function enlarged(page, number) {
  await page.getByRole("button", { name: `${lines[number].camera} ${lines[number].frame}`, exact: true }).click();
  await page.waitForFunction(number => window.state.large === number && window.state.overlays, number);
  return page.evaluate(() => window.state.overlays);
}

/** What is drawn at a point of the image that is large, in its pixels. */
const drawnAt = (page, [x, y], width) => page.evaluate(([x, y, width]) => {
  const canvas = document.getElementById("picture"), times = canvas.width / width;
  return [...canvas.getContext("2d").getImageData(Math.floor(x * times), Math.floor(y * times), 1, 1).data].slice(0, 3);
}, [x, y, width]);

/** The direction that a pixel looks at, in the camera's coordinates, by OpenCV's model. */
function direction([x, y], { camera_matrix: [[fx, skew, cx], [, fy, cy]], distortion: [k1, k2, p1, p2, k3] }) {
  const v = (y - 0.5 - cy) / fy, u = (x - 0.5 - cx - skew * v) / fx;
  let [a, b] = [u, v];
  for (let i = 0; i < 200; i++) {
    const r = a * a + b * b, radial = 1 + r * (k1 + r * (k2 + r * k3));
    [a, b] = [(u - 2 * p1 * a * b - p2 * (r + 2 * a * a)) / radial, (v - p1 * (r + 2 * b * b) - 2 * p2 * a * b) / radial];
  }
  const length = Math.hypot(a, b, 1);
  return [a / length, b / length, 1 / length];
}

const cross = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const dot = (a, b) => a.reduce((sum, value, i) => sum + value * b[i], 0);
/** R of x_camera = R·x + t, the other way. */
const back = (R, v) => [0, 1, 2].map(i => dot(R.map(row => row[i]), v));

async function epipolar(page) {
  const [left, right] = [0, 1].map(number => report(number).camera);
  const all = [];
  for (const number of [0, 1]) {
    all.push((await enlarged(page, number)).epipolar);
    await page.keyboard.press("Escape");
  }
  check(all[0].partner === "right" && all[1].partner === "left", JSON.stringify(all.map(one => one.partner)));
  check(all.every(one => one.lines.length === 12), "there are not twelve lines");
  const centres = [left, right].map(camera => back(camera.rotation, camera.translation_m.map(t => -t)));
  const baseline = centres[1].map((x, i) => x - centres[0][i]);
  let pairs = 0, worst = 0;
  for (let line = 0; line < 12; line++) {
    const seen = [left, right].map((camera, i) => all[i].lines[line].flat().map(px => back(camera.rotation, direction(px, camera))));
    if (!seen[0].length || !seen[1].length) continue;
    const plane = cross(baseline, seen[0][seen[0].length >> 1]), size = Math.hypot(...plane);
    for (const ray of seen.flat()) { worst = Math.max(worst, Math.abs(dot(plane, ray)) / size); pairs++; }
  }
  // 1e-9 m of poses that were rounded, over a baseline of 0.12 m, and the last of 200 steps.
  check(pairs > 100 && worst < 1e-7, `${pairs} points, ${worst} rad out of their planes`);
  console.log(`${pairs} points of epipolar lines lie in their planes to ${worst.toExponential(1)} rad`);
}

async function overlays(page) {
  const boxes = Object.fromEntries(["Corners", "Boxes", "Masks", "Epipolar lines"].map(name => [name, page.getByRole("checkbox", { name })]));
  await boxes.Corners.check();
  const found = await enlarged(page, 0), plain = readPng(join(set, lines[0].folder, "image.png"));
  const wanted = report(0).targets.flatMap(target => target.points_px.map((px, i) => [px, target.points_visible[i]])).filter(([px]) => px);
  check(found.corners.length === wanted.length && wanted.length === 40, `${found.corners.length} corners, ${wanted.length} in capture.json`);
  for (const [i, [[x, y], visible]] of wanted.entries()) {
    const { px, is_visible } = found.corners[i];
    check(near(px[0], x + 0.5, 1e-9) && near(px[1], y + 0.5, 1e-9) && is_visible === visible, `corner ${i}: ${px}, ${x} ${y} in capture.json`);
    if (!visible) continue;
    // A cross is green where it meets its point.
    const [r, g, b] = await drawnAt(page, px, plain.width);
    check(g > 100 && g > r + 50 && g > b + 20, `corner ${i} at ${px} is drawn as ${[r, g, b]}`);
  }
  // Far from all corners the image stays what it is.
  const far = wanted.every(([[x, y]]) => Math.hypot(x - 5, y - 90) > 10) ? 90 * plain.width + 5 : null;
  check(far !== null && !difference(await drawnAt(page, [5.5, 90.5], plain.width), [...plain.values.slice(3 * far, 3 * far + 3)]), "the image is not that of image.png");
  await page.keyboard.press("Escape");

  await boxes.Boxes.check();
  await boxes.Masks.check();
  const { objects } = JSON.parse(readFileSync(join(set, lines[1].folder, "objects.json")));
  const seen = (await enlarged(page, 1)).objects;
  const visible = objects.filter(object => object.visible.box_px);
  check(seen.length === visible.length, `${seen.length} objects, ${visible.length} in objects.json`);
  visible.forEach((object, i) => {
    same(seen[i].box_px, object.visible.box_px, object.name);
    same(seen[i].mask.counts, object.visible.mask.counts, `the mask of ${object.name}`);
  });
  if (pictures) await page.screenshot({ path: join(pictures, "sheet-large.png") });
  await page.keyboard.press("ArrowRight");
  await page.waitForFunction(() => window.state.large === 2 && window.state.overlays);
  await page.getByRole("button", { name: "Close" }).click();
  await boxes["Epipolar lines"].check();
  console.log(`${wanted.length} corners and ${seen.length} objects stand where the reports have them`);
}

/** The live view of one image, and back. */
async function oneOfThem(page) {
  await enlarged(page, 3);
  await page.getByRole("link", { name: "Open in the live view" }).click();
  await page.waitForFunction(() => window.state?.pictures > 0, null, { timeout: 60_000 });
  const values = await page.evaluate(() => [...window.state.picture.values]);
  const differs = difference(values, readPng(join(set, lines[3].folder, "image.png")).values);
  check(!differs, `the live view of ${lines[3].folder}: ${differs}`);
  await page.getByRole("slider", { name: "Gain", exact: true }).fill("6");
  await page.waitForFunction(() => window.state.answers > 0);
  check(!await page.evaluate(() => window.state.error), "its light cannot be exposed");
  await page.getByRole("link", { name: "All images" }).click();
  await page.waitForFunction(() => window.state?.shown?.length > 0);
  console.log("an image of the set can be opened in the live view");
}

/** What no page asks for. */
async function strangers(address) {
  const status = async path => (await fetch(new URL(path, address))).status;
  for (const [path, wanted] of [["image?input=6", 404], ["image?input=0&width=161", 400], ["image?input=../../etc", 400], ["image?input=-1", 400],
    ["overlays?input=6", 404], ["overlays?input=x", 400], ["picture?input=6", 404], ["left/000000/capture.json", 404], ["manifest.jsonl", 404], ["..%2fmanifest.jsonl", 404]]) {
    check(await status(path) === wanted, `${path}: ${await status(path)} in place of ${wanted}`);
  }
}

const chromium = await browser();
try {
  const server = await view(program, [set]);
  const { page, errors } = await open(chromium, server.address, { colorScheme: "dark" });
  await page.waitForFunction(count => window.state.shown.length === count && window.state.drawn >= count, lines.length, { timeout: 60_000 });
  await filters(page);
  await overlays(page);
  await epipolar(page);
  if (pictures) {
    await page.waitForTimeout(500);
    await page.screenshot({ path: join(pictures, "sheet-dark.png") });
  }
  await oneOfThem(page);
  check(!errors.length, `the console says:\n${errors.join("\n")}`);
  await page.close();
  for (const [name, options] of Object.entries({ light: { colorScheme: "light" }, phone: { colorScheme: "light", viewport: { width: 390, height: 844 }, deviceScaleFactor: 2 } })) {
    const { page, errors } = await open(chromium, server.address, options);
    await page.waitForFunction(() => window.state.drawn > 1, null, { timeout: 60_000 });
    const unnamed = await nameless(page);
    check(!unnamed.length, `without a name: ${unnamed.join(", ")}`);
    const [wide, window] = await page.evaluate(() => [document.documentElement.scrollWidth, innerWidth]);
    check(wide <= window, `${name}: the page is ${wide} px wide, the window ${window}`);
    check(!errors.length, errors.join("\n"));
    if (pictures) await page.screenshot({ path: join(pictures, `sheet-${name}.png`) });
    await page.close();
  }
  await strangers(server.address);
  check(!server.log().includes("panicked"), server.log());
  await server.end("SIGTERM");
} finally {
  await chromium.close();
}
process.exit(0);
