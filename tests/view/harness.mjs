// What the tests of the page have in common: photosite as a command and as a server, Chromium, and images of files.
import { execFileSync, spawn } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { inflateSync } from "node:zlib";

// playwright-core is found from the current folder on.
const { chromium } = createRequire(join(process.cwd(), "package.json"))("playwright-core");

// Pages are composed as on a machine without a graphics card: OpenGL by software in its place takes more of the processor
// than all else.
const ARGUMENTS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--disable-gpu"];

export const browser = () => chromium.launch({ executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium", args: ARGUMENTS });

/** A folder that goes away at the end. */
export function folder() {
  const path = mkdtempSync(join(tmpdir(), "photosite-view-"));
  process.on("exit", () => rmSync(path, { recursive: true, force: true }));
  return path;
}

/** Runs a command of photosite. */
export function photosite(program, ...words) {
  try {
    execFileSync(program, words.map(String), { stdio: ["ignore", "ignore", "pipe"] });
  } catch (error) {
    throw new Error(`photosite ${words.join(" ")}: ${error.stderr}`);
  }
}

/** Starts `photosite view` and waits for its address. */
export async function view(program, words, { token, port = 0 } = {}) {
  const env = token ? { ...process.env, PHOTOSITE_VIEW_TOKEN: token } : process.env;
  const server = spawn(program, ["view", "--port", String(port), ...words.map(String)], { stdio: ["ignore", "pipe", "pipe"], env });
  process.on("exit", () => server.kill("SIGKILL"));
  let log = "";
  server.stderr.on("data", data => { log += data; });
  const address = await new Promise((found, failed) => {
    let text = "";
    server.stdout.on("data", data => { text += data; if (text.includes("\n")) found(text.trim()); });
    server.on("exit", () => failed(new Error(`photosite view ${words.join(" ")}: ${log}`)));
  });
  const end = signal => new Promise(done => { server.on("exit", (code, by) => done(by ?? code)); server.kill(signal); });
  return { address, port: new URL(address).port, end, log: () => log };
}

/** A page whose console is listened to: errors that it shows are in `errors`. */
export async function open(chromium, address, options = {}) {
  const page = await chromium.newPage({ viewport: { width: 1100, height: 760 }, ...options });
  const errors = [];
  // Only tests read pixels back again and again.
  const isOurs = text => text.startsWith("Canvas2D: Multiple readback operations");
  page.on("console", message => { if (["error", "warning"].includes(message.type()) && !isOurs(message.text())) errors.push(message.text()); });
  page.on("pageerror", error => errors.push(String(error)));
  page.on("request", request => { if (!request.url().startsWith(new URL(address).origin) && !/^(data|blob):/.test(request.url())) errors.push(`asks ${request.url()}`); });
  await page.goto(address);
  return { page, errors };
}

/** Names of controls that assistive technology finds without any. */
export async function nameless(page) {
  const tree = await page.locator("body").ariaSnapshot();
  return tree.split("\n").filter(line => /^\s*- (slider|combobox|checkbox|button|spinbutton|textbox|radio|switch|link|img)(:| \[|$)/.test(line));
}

/** Codes of an 8-bit PNG file of RGB or grey that is not interlaced, by the filters of its specification. */
export function readPng(path) {
  const file = readFileSync(path);
  let at = 8, width, height, channels;
  const data = [];
  while (at < file.length) {
    const length = file.readUInt32BE(at), kind = file.toString("latin1", at + 4, at + 8), body = file.subarray(at + 8, at + 8 + length);
    if (kind === "IHDR") {
      [width, height, channels] = [body.readUInt32BE(0), body.readUInt32BE(4), { 0: 1, 2: 3 }[body[9]]];
      if (body[8] !== 8 || !channels || body[12]) throw new Error(`${path}: another kind of PNG`);
    }
    if (kind === "IDAT") data.push(body);
    at += 12 + length;
  }
  const lines = inflateSync(Buffer.concat(data)), stride = width * channels, values = new Uint8Array(stride * height);
  for (let y = 0; y < height; y++) {
    const filter = lines[y * (stride + 1)];
    for (let i = 0; i < stride; i++) {
      const left = i >= channels ? values[y * stride + i - channels] : 0, up = y ? values[(y - 1) * stride + i] : 0;
      const corner = i >= channels && y ? values[(y - 1) * stride + i - channels] : 0;
      const [a, b, c] = [up - corner, left - corner, left + up - 2 * corner].map(Math.abs);
      const guess = [0, left, up, (left + up) >> 1, a <= b && a <= c ? left : b <= c ? up : corner][filter];
      values[y * stride + i] = lines[y * (stride + 1) + 1 + i] + guess;
    }
  }
  return { width, height, channels, values };
}

/** Numbers of a NPY file of `uint16`, `uint32` or `float32`. */
export function readNpy(path) {
  const file = readFileSync(path), length = file.readUInt16LE(8), head = file.toString("latin1", 10, 10 + length);
  const Kind = { "<u2": Uint16Array, "<u4": Uint32Array, "<f4": Float32Array }[/'descr': '([^']+)'/.exec(head)[1]];
  const bytes = file.subarray(10 + length);
  return new Kind(bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length));
}

/** The first place at which two lists differ; `null` where they are equal. */
export function difference(a, b) {
  if (a.length !== b.length) return `${a.length} and ${b.length} values`;
  const i = Array.prototype.findIndex.call(a, (value, i) => value !== b[i]);
  return i < 0 ? null : `value ${i}: ${a[i]} and ${b[i]}`;
}

export function check(condition, words) {
  if (!condition) throw new Error(words);
}
