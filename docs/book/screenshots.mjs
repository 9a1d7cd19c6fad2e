// Takes the images of pages that the book shows, the live view and that of a lens: node docs/book/screenshots.mjs PHOTOSITE
//
// Run it in a folder with playwright-core, as the tests of the page (tests/view). They are not compared in CI: letters look
// different on each machine.
import { join, resolve } from "node:path";
import { browser, folder, open, photosite, view } from "../../tests/view/harness.mjs";

const program = resolve(process.argv[2]);
const root = resolve(import.meta.dirname, "../..");
const images = join(root, "docs/guides/images");

const words = [join(root, "scenes/cornell-box/capture.toml"), "--size", "400x400", "--spp", "24"];
const server = await view(program, words);
const chromium = await browser();
try {
  const { page, errors } = await open(chromium, server.address, { viewport: { width: 1200, height: 800 }, colorScheme: "light" });
  const shot = name => page.screenshot({ path: join(images, name), type: "jpeg", quality: 85 });
  await page.waitForFunction(() => window.state.status?.phase === "done" && window.state.picture, null, { timeout: 300_000 });
  await shot("view.jpg");

  await page.selectOption("#plane", "truth:depth");
  await page.waitForFunction(() => window.state.picture.plane === "truth:depth");
  await page.selectOption("#map", "viridis");
  for (const name of ["status-group", "scale-group"]) await page.locator(`#${name}`).evaluate(details => { details.open = details.id === "scale-group"; });
  for (const group of await page.locator("#controls details").all()) await group.evaluate(details => { details.open = false; });
  await page.locator("#view").click({ position: { x: 560, y: 560 } });
  await page.waitForFunction(() => window.state.pixel);
  await shot("view-depth.jpg");

  const lens = join(folder(), "lens.html");
  photosite(program, "lens", "canon-ef50", "--quiet", "-o", lens);
  const drawn = await chromium.newPage({ viewport: { width: 1000, height: 800 }, colorScheme: "light" });
  await drawn.goto(`file://${lens}`);
  await drawn.locator("svg").first().screenshot({ path: join(images, "lens-section.jpg"), type: "jpeg", quality: 85 });
  if (errors.length) throw new Error(errors.join("\n"));
} finally {
  await chromium.close();
  await server.end("SIGINT");
}
