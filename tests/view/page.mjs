// Drives the page of `photosite view` in headless Chromium, and compares what it shows with what the commands write.
//
//     node tests/view/page.mjs PHOTOSITE [SCREENSHOTS]
//
// Run it in a folder with playwright-core. A capture is rendered with `photosite render`. The page must show the same
// image when all is traced; after each change of a control, the bytes of the image that `photosite expose` makes with
// the same keys; after a move of the camera, that of `photosite render`. SCREENSHOTS is a folder for images of the page.
import { join, resolve } from "node:path";
import { browser, check, difference, folder, nameless, open, photosite, readNpy, readPng, view } from "./harness.mjs";

const [, , given, pictures] = process.argv;
const program = resolve(given);
const here = folder();
const capture = resolve(import.meta.dirname, "../../scenes/cornell-box/capture.toml");
const SETTINGS = ["sensor.resolution_px=[160,120]", "render.samples_per_pixel=24", "output.irradiance=true"];
const AUTOMATIC = ["exposure.auto", "exposure.compensation_ev"];
const sets = keys => keys.flatMap(key => ["--set", key]);

/** The light of the capture as it is, and moved. */
const stored = join(here, "stored"), moved = join(here, "moved");
const NPY = 'output.raw=["dng", "npy"]';
photosite(program, "render", capture, "-o", stored, "--quiet", ...sets([...SETTINGS, NPY]));
photosite(program, "render", capture, "-o", moved, "--quiet", ...sets([...SETTINGS, "lens.focus_distance_m=0.5"]));

/** The image that is on the page, as an array. */
const values = page => page.evaluate(() => [...window.state.picture.values]);
const settled = (page, light) => page.waitForFunction(light => {
  const { status, picture } = window.state;
  return status?.phase === "done" && status.light >= light && picture?.light === status.light;
}, light, { timeout: 120_000 });

/** A value of a control that differs from what is there, and what it becomes in a capture. */
function another(control) {
  const { kind, key, min, max, step, options } = control;
  if (kind === "linear") {
    const value = +(min + Math.round(0.7 * (max - min) / step) * step).toFixed(6);
    return { fill: String(value), expected: value };
  }
  if (kind === "logarithmic") return { fill: String(key === "exposure.time_s" ? Math.log2(0.004) : Math.log2(min) + 0.4), expected: null };
  if (kind === "whole") return { fill: "7", expected: 7 };
  if (kind === "choice") return { options: options.map(option => option.name) };
  return {};
}

/** A query as changes on a command line. */
function asChanges(url, controls) {
  const changes = [];
  for (const [key, value] of new URL(url).searchParams) {
    if (["plane", "input", "frame", "screen", "view", "step"].includes(key)) continue;
    const { kind } = controls.find(control => control.key === key);
    if (kind === "choice") changes.push(`${key}="${value}"`);
    else if (kind === "several") changes.push(`${key}=[${value.split(",").filter(Boolean).map(name => `"${name}"`).join(",")}]`);
    else changes.push(`${key}=${value}`);
  }
  return changes;
}

async function everyControl(page, errors) {
  const about = await page.evaluate(async () => (await fetch("about")).json());
  let asked = null, exposed = 0, refused = 0;
  const bad = { picture: 0, pixel: 0, noise: 0 };
  page.on("response", answer => { if (answer.status() >= 400) bad[/\/([^/?]*)(\?|$)/.exec(answer.url())[1]]++; });
  page.on("request", request => { if (request.url().includes("/picture?")) asked = request.url(); });
  for (const group of await page.locator("#controls details").all()) await group.evaluate(details => { details.open = true; });

  /** Lets the page act, waits for its answer, and compares that with the command's. */
  const changed = async (control, act) => {
    const before = await page.evaluate(() => window.state.answers);
    await act();
    await page.waitForFunction(before => window.state.answers > before, before, { timeout: 30_000 });
    const error = await page.evaluate(() => window.state.error), changes = asChanges(asked, about.controls);
    check(changes.some(change => change.startsWith(`${control.key}=`)), `${control.key} is not asked for: ${asked}`);
    let wanted = null, why = "";
    // Automatic exposure goes by the light, of which electrons.exr holds what its exposure has rounded.
    const [how, input, more] = AUTOMATIC.includes(control.key) ? ["render", capture, SETTINGS] : ["expose", stored, []];
    try {
      photosite(program, how, input, "-o", join(here, "exposed"), "--force", "--quiet", ...sets([...more, ...changes]));
      wanted = readPng(join(here, "exposed/image.png"));
    } catch (failure) { why = failure.message; }
    if (error) {
      check(!wanted, `the page refuses ${changes.join(" ")} (${error}), and photosite ${how} does not`);
      check(await page.locator("#readout.bad").isVisible(), `${changes}: the page does not say ${error}`);
      refused++;
    } else {
      check(wanted, `photosite ${how} refuses ${changes.join(" ")}, and the page does not: ${why}`);
      const differs = difference(await values(page), wanted.values);
      check(!differs, `${changes.join(" ")}: ${differs}`);
      exposed++;
    }
  };
  const reset = async () => {
    const before = await page.evaluate(() => window.state.answers);
    await page.getByRole("button", { name: "Reset settings" }).click();
    await page.waitForFunction(before => window.state.answers > before, before, { timeout: 30_000 });
  };

  for (const control of about.controls) {
    const { label, kind, key } = control, { fill, expected, options } = another(control);
    const root = page.locator(".control").filter({ has: page.locator(`#control-${key.replace(/\W/g, "-")}`) });
    // Light through a lens is traced anew for its f-number, see light.mjs.
    if (kind !== "several" && !await root.isVisible() || key === "lens.f_number") continue;
    if (kind === "linear" || kind === "logarithmic") {
      const slider = page.getByRole("slider", { name: label, exact: true });
      await changed(control, () => slider.fill(fill));
      const value = new URL(asked).searchParams.get(key), at = expected ?? 2 ** +await slider.inputValue();
      check(Math.abs(value - at) <= 1e-5 * Math.abs(at), `${key}: the slider is at ${at}, and ${value} is asked for`);
    } else if (kind === "whole") await changed(control, () => page.getByRole("spinbutton", { name: label, exact: true }).fill(fill));
    else if (kind === "flag") await changed(control, () => page.getByRole("checkbox", { name: label, exact: true }).click());
    else if (kind === "choice") {
      const box = page.getByRole("combobox", { name: label, exact: true }), now = await box.inputValue();
      for (const option of options.filter(option => option !== now)) await changed(control, () => box.selectOption(option));
    } else {
      // Stages one by one, all others staying off.
      const none = page.getByRole("button", { name: `${label}: none` });
      await changed(control, () => none.click());
      const stages = await page.evaluate(() => window.state.picture.stages);
      for (const { name } of control.options) {
        const box = page.getByRole("checkbox", { name, exact: true }), has = stages.includes(name);
        check(await box.isVisible() === has, `${name} is ${has ? "not " : ""}offered`);
        if (has) await changed(control, () => box.check());
      }
    }
    await reset();
  }
  const differs = difference(await values(page), readPng(join(stored, "image.png")).values);
  check(!differs, `after all controls are reset: ${differs}`);
  // Browsers tell of each answer that is an error.
  const told = errors.filter(text => /^Failed to load resource: .* status of 4\d\d/.test(text));
  check(bad.picture === refused, `${bad.picture} images are refused, and ${refused} settings`);
  // What is measured of settings that are refused is refused, too.
  check(told.length === bad.picture + bad.pixel + bad.noise, `${told.length} answers are errors, of ${JSON.stringify(bad)}`);
  errors.splice(0, errors.length, ...errors.filter(text => !told.includes(text)));
  console.log(`${about.controls.length} controls: ${exposed} settings have the bytes of the commands, ${refused} are refused by both`);
}

/** Picks a pixel with the pointer, and looks at what is drawn there. */
async function aPixel(page) {
  const png = readPng(join(stored, "image.png")), raw = readNpy(join(stored, "raw.npy")), [x, y] = [61, 47];
  await page.getByRole("button", { name: "Fit" }).click();
  const place = await page.evaluate(([x, y]) => {
    const canvas = document.getElementById("view"), { width, height } = window.state.picture;
    const scale = Math.min(canvas.clientWidth / width, canvas.clientHeight / height);
    const at = [(canvas.clientWidth - width * scale) / 2 + (x + 0.5) * scale, (canvas.clientHeight - height * scale) / 2 + (y + 0.5) * scale];
    const ratio = window.devicePixelRatio, box = canvas.getBoundingClientRect();
    const drawn = canvas.getContext("2d").getImageData(Math.floor(at[0] * ratio), Math.floor(at[1] * ratio), 1, 1).data;
    return { at: [box.left + at[0], box.top + at[1]], drawn: [...drawn] };
  }, [x, y]);
  const first = (y * png.width + x) * 3, code = [...png.values.subarray(first, first + 3)];
  check(!difference(place.drawn, [...code, 255]), `the canvas shows ${place.drawn} where image.png has ${code}`);
  await page.mouse.click(...place.at);
  await page.waitForFunction(([x, y]) => window.state.pixel?.x === x && window.state.pixel?.y === y, [x, y]);
  const pixel = await page.evaluate(() => window.state.pixel);
  check(!difference(pixel.developed.map(([, value]) => value), code), `developed ${JSON.stringify(pixel.developed)}, ${code} in image.png`);
  check(pixel.raw.length === 1 && pixel.raw[0][1] === raw[y * png.width + x], `raw ${JSON.stringify(pixel.raw)}, ${raw[y * png.width + x]} in raw.npy`);
  check(pixel.electrons.length === 3 && pixel.electrons.every(([, mean, sigma]) => mean > 0 && sigma >= 0), JSON.stringify(pixel.electrons));
  const text = await page.getByRole("table", { name: "Values of the pixel" }).innerText();
  check(text.includes(`${raw[y * png.width + x]} DN`), text);
  console.log(`pixel ${x}, ${y}: ${pixel.raw[0]} DN, developed ${code}, and so drawn`);
}

/** Every plane can be shown; the raw one is that of the file. */
async function planes(page) {
  const box = page.getByRole("combobox", { name: "Show", exact: true });
  const names = await box.locator("option").evaluateAll(options => options.map(option => option.value));
  for (const name of names) {
    await box.selectOption(name);
    await page.waitForFunction(name => window.state.picture.plane === name || window.state.error, name, { timeout: 30_000 });
    check(!await page.evaluate(() => window.state.error), `${name}: ${await page.evaluate(() => window.state.error)}`);
  }
  await page.locator("#view").focus();
  for (const [key, plane] of [["r", "raw"], ["e", "electrons:"], ["r", "raw"]]) {
    await page.keyboard.press(key);
    await page.waitForFunction(plane => window.state.picture.plane.startsWith(plane), plane);
  }
  const differs = difference(await values(page), readNpy(join(stored, "raw.npy")));
  check(!differs, `raw: ${differs}`);
  await page.keyboard.press("d");
  await page.waitForFunction(() => window.state.picture.plane === "developed");
  console.log(`${names.length} planes can be shown; raw has the numbers of raw.npy`);
}

/** Light that is traced anew by a lens that is focused elsewhere. */
async function camera(page) {
  const { trace, light } = await page.evaluate(() => window.state.status);
  await page.locator("#camera-group").evaluate(details => { details.open = true; });
  const number = page.getByRole("spinbutton", { name: "Focus distance" });
  await number.fill("0.5");
  await number.press("Enter");
  await page.waitForFunction(trace => window.state.status.trace > trace, trace, { timeout: 30_000 });
  await settled(page, light + 1);
  const differs = difference(await values(page), readPng(join(moved, "image.png")).values);
  check(!differs, `focused at 0.5 m: ${differs}`);
  console.log("light of another focus has the bytes of photosite render");
}

/** What the pointer does with an image, keys do, too. */
async function byKeys(page) {
  const view = page.locator("#view"), tool = page.getByRole("combobox", { name: "Tool" });
  const press = async (...keys) => { await view.focus(); for (const key of keys) await page.keyboard.press(key); };
  const figures = words => page.waitForFunction(words => document.getElementById("figures").textContent.startsWith(words), words, { timeout: 10_000 });
  await tool.selectOption("patch");
  const [x, y] = await page.evaluate(() => [window.state.pixel.x, window.state.pixel.y]);
  await press("Enter", "ArrowRight", "ArrowRight", "ArrowRight", "ArrowDown", "ArrowDown", "Enter");
  await figures(`Patch of 4 × 3 pixels at ${x}, ${y}`);
  const { width, values: codes } = readPng(join(moved, "image.png"));
  let sum = 0;
  for (let row = y; row < y + 3; row++) for (let column = x; column < x + 4; column++) sum += codes[3 * (row * width + column) + 1];
  const green = await page.evaluate(() => window.state.figures.find(({ name }) => name === "G"));
  check(green.count === 12 && Math.abs(green.mean - sum / 12) < 1e-9, `green of the patch: ${JSON.stringify(green)}, ${sum / 12} in image.png`);
  await press("ArrowRight", "Escape");
  await figures("All pixels");
  /** Keys by which light is traced anew. */
  const traces = async (...keys) => {
    const { trace } = await page.evaluate(() => window.state.status);
    await press(...keys);
    await page.waitForFunction(trace => window.state.status.trace > trace && window.state.status.phase === "done", trace, { timeout: 30_000 });
    return page.evaluate(() => window.state.status.camera);
  };
  await tool.selectOption("focus");
  const focused = await traces("Enter");
  check(focused.focus_distance_m > 0.7 && focused.focus_distance_m < 1.5, `focused at ${focused.focus_distance_m} m, in a room that is 0.8 to 1.36 m away`);
  await tool.selectOption("orbit");
  const distance = (a, b) => Math.hypot(...a.position_m.map((v, i) => v - b.position_m[i]));
  const near = await traces("PageUp"), aside = await traces("Shift+ArrowRight"), turned = await traces("ArrowRight");
  check(Math.abs(near.pivot_m / focused.pivot_m - 1 / 1.1) < 0.01, `nearer: ${focused.pivot_m} m, then ${near.pivot_m} m`);
  check(distance(near, aside) > 0.01 && near.forward.every((v, i) => Math.abs(v - aside.forward[i]) < 1e-6), "moved aside by Shift and an arrow");
  check(distance(aside, turned) > 0.01 && turned.forward.some((v, i) => Math.abs(v - aside.forward[i]) > 0.01), "turned by an arrow");
  console.log("patch, focus and camera by keys alone");
}

/** Tracing that would take hours pauses, goes on and stops, and what is there can be exposed. */
async function longTrace(chromium) {
  const server = await view(program, [capture, ...sets(["sensor.resolution_px=[160,120]", "render.samples_per_pixel=1000000"])]);
  const { page, errors } = await open(chromium, server.address);
  const samples = () => page.evaluate(() => window.state.status.samples_per_pixel);
  const grows = async () => { const now = await samples(); await page.waitForFunction(now => window.state.status.samples_per_pixel > now && window.state.picture, now, { timeout: 60_000 }); };
  const phase = name => page.waitForFunction(name => window.state.status.phase === name, name, { timeout: 30_000 });
  await page.waitForFunction(() => window.state.pictures > 0, null, { timeout: 60_000 });
  const first = await page.evaluate(() => window.state.pictures);
  await grows();
  await grows();
  // The image follows the light; on a busy machine it may come after the next pass.
  await page.waitForFunction(first => window.state.pictures > first, first, { timeout: 60_000 });
  await page.getByRole("button", { name: "Pause" }).click();
  await phase("paused");
  const before = await samples(), answers = await page.evaluate(() => window.state.answers);
  await page.getByRole("slider", { name: "Gain", exact: true }).fill("6");
  await page.waitForFunction(answers => window.state.answers > answers, answers, { timeout: 30_000 });
  // A pass that is under way may end.
  check(await samples() <= 2 * before + 1, "light goes on being traced in a pause");
  await page.getByRole("button", { name: "Continue" }).click();
  // Each pass takes as long as all before it, however long the browser took to start: paths tell sooner than the next pass.
  const paths = await page.evaluate(() => window.state.status.paths);
  await page.waitForFunction(paths => window.state.status.paths > paths, paths, { timeout: 60_000 });
  await page.getByRole("button", { name: "Stop" }).click();
  await phase("stopped");
  const stopped = await page.evaluate(() => window.state.answers);
  await page.getByRole("slider", { name: "Gain", exact: true }).fill("12");
  await page.waitForFunction(answers => window.state.answers > answers, stopped, { timeout: 30_000 });
  check(!errors.length, errors.join("\n"));
  await page.close();
  const by = await server.end("SIGINT");
  check(by === 130, `SIGINT ends it with ${by}`);
  console.log("a long trace pauses, goes on and stops");
}

/** The server dies and is started again: the page says so, and finds it. */
async function lost(chromium) {
  const token = "0123456789abcdef0123456789abcdef", words = [stored];
  const server = await view(program, words, { token });
  const { page, errors } = await open(chromium, server.address);
  await page.waitForFunction(() => window.state.pictures > 0, null, { timeout: 30_000 });
  check(!errors.length, errors.join("\n"));
  const before = await page.evaluate(() => window.state.pictures);
  await server.end("SIGKILL");
  await page.getByRole("alert").filter({ hasText: "The connection is lost" }).waitFor({ timeout: 15_000 });
  const again = await view(program, words, { token, port: server.port });
  await page.getByRole("alert").waitFor({ state: "hidden", timeout: 30_000 });
  await page.waitForFunction(before => window.state.pictures > before, before, { timeout: 30_000 });
  const differs = difference(await values(page), readPng(join(stored, "image.png")).values);
  check(!differs, `after the server has come back: ${differs}`);
  await page.close();
  await again.end("SIGTERM");
  console.log("a server that dies is missed, and found again");
}

/** A raw file is developed as the command does; what needs its light is not offered, not even as an empty group. */
async function rawFile(chromium) {
  const raw = join(stored, "raw.dng"), developed = join(here, "developed.png");
  photosite(program, "develop", raw, "-o", developed, "--quiet", "--set", "develop.sharpening=1.5");
  const server = await view(program, [raw]);
  const { page, errors } = await open(chromium, server.address);
  await page.waitForFunction(() => window.state.picture);
  const before = await values(page), answers = await page.evaluate(() => window.state.answers);
  const groups = await page.locator("#controls > details:visible").all();
  for (const group of groups) check(await group.locator(".control:visible").count(), `an empty group: ${await group.textContent()}`);
  check(groups.length === 1, `${groups.length} groups of controls for a raw file`);
  await page.locator('[id="control-develop-sharpening"]').fill("1.5");
  await page.waitForFunction(answers => window.state.answers > answers, answers);
  const after = await values(page);
  check(difference(before, after), "sharpening changes nothing");
  const differs = difference(after, readPng(developed).values);
  check(!differs, `a raw file, sharpened: ${differs}`);
  check(!errors.length, errors.join("\n"));
  await page.close();
  await server.end("SIGTERM");
  console.log("a raw file has the bytes of photosite develop, and controls of nothing else");
}

/** Effects are those of the sensor that is chosen, the panel holds names of any length, and light of files is not said to be
 * traced again. */
async function storedLight(chromium) {
  const long = "a sensor whose name says all of its figures and does not end before the panel does";
  const out = join(here, "long"), keys = ["render.samples_per_pixel=2", "sensor.resolution_px=[48,36]", "output.electrons=true", `sensor.name=${JSON.stringify(long)}`];
  photosite(program, "render", capture, "-o", out, "--quiet", ...sets(keys));
  const server = await view(program, [out]);
  const { page, errors } = await open(chromium, server.address);
  await page.waitForFunction(() => window.state.picture);
  for (const group of await page.locator("#panel details").all()) await group.evaluate(details => { details.open = true; });
  const box = page.getByRole("combobox", { name: "Sensor", exact: true });
  check(await box.inputValue() === long && await box.getAttribute("title") === long, await box.inputValue());
  const [wide, shown] = await page.evaluate(() => { const panel = document.getElementById("panel"); return [panel.scrollWidth, panel.clientWidth]; });
  check(wide <= shown, `the panel holds ${wide} px, and shows ${shown}`);
  const offered = async name => page.getByRole("checkbox", { name, exact: true }).isVisible();
  check(await offered("read-noise") && !await offered("smear") && !await offered("vertical-transfer"), "effects of a CCD are offered for a CMOS sensor");
  const planes = await page.locator("#plane option").evaluateAll(options => options.map(option => option.value));
  check(planes.includes("noise:read_noise_e") && !planes.includes("noise:smear_e"), `planes: ${planes}`);
  await box.selectOption("textbook-ccd");
  await page.locator("#readout.bad").waitFor();
  const said = await page.locator("#readout").textContent();
  check(!/trace again|keep the spectrum/i.test(said) && /output\.irradiance/.test(said), said);
  await page.getByRole("button", { name: "Keys" }).click();
  const help = await page.locator("#keys").innerText();
  check(!/trac|camera|focus/i.test(help) && /zoom/.test(help), help);
  check(!errors.length, errors.join("\n"));
  await page.close();
  await server.end("SIGTERM");
  console.log("light of files: effects of its sensor, a panel that holds its name, and no word of tracing");
}

/** What people look at: dark, light, and as narrow as a phone. */
async function looks(chromium, address) {
  for (const [name, options] of Object.entries({
    dark: { colorScheme: "dark" }, light: { colorScheme: "light" },
    phone: { colorScheme: "light", viewport: { width: 390, height: 844 }, hasTouch: true, deviceScaleFactor: 2 },
  })) {
    const { page, errors } = await open(chromium, address, options);
    await settled(page, 0);
    const unnamed = await nameless(page);
    check(!unnamed.length, `without a name: ${unnamed.join(", ")}`);
    const [wide, shown] = await page.evaluate(() => [document.documentElement.scrollWidth, window.innerWidth]);
    check(wide <= shown, `${name}: the page is ${wide} px wide, the window ${shown}`);
    check(!errors.length, errors.join("\n"));
    if (pictures) await page.screenshot({ path: join(pictures, `view-${name}.png`) });
    await page.close();
  }
  console.log("dark, light and narrow; every control has a name");
}

const chromium = await browser();
try {
  const server = await view(program, [capture, ...sets(SETTINGS)]);
  const { page, errors } = await open(chromium, server.address);
  await page.waitForFunction(() => window.state.pictures > 0, null, { timeout: 60_000 });
  await settled(page, 1);
  const differs = difference(await values(page), readPng(join(stored, "image.png")).values);
  check(!differs, `the image when all is traced: ${differs}`);
  console.log("the image when all is traced has the bytes of photosite render");
  await aPixel(page);
  await planes(page);
  await everyControl(page, errors);
  await camera(page);
  await byKeys(page);
  check(!errors.length, `the console says:\n${errors.join("\n")}`);
  await page.close();
  await looks(chromium, server.address);
  check(!server.log().includes("panicked"), server.log());
  await server.end("SIGTERM");
  await rawFile(chromium);
  await storedLight(chromium);
  await longTrace(chromium);
  await lost(chromium);
} finally {
  await chromium.close();
}
process.exit(0);
