// How far the light is, in words.
import { readable } from "./controls.js";
import { $, state } from "./session.js";

const PHASES = { preparing: "Building the scene", tracing: "Tracing", paused: "Paused", stopped: "Stopped", done: "Traced", failed: "Cannot be traced", stored: "Light from files" };
const clock = s => s >= 3600 ? `${Math.floor(s / 3600)} h ${Math.floor(s / 60 % 60)} min` : s >= 60 ? `${Math.floor(s / 60)} min ${Math.floor(s % 60)} s` : `${readable(s, s < 10 ? 2 : 3)} s`;

/** Says how far the light is, and enables what can be done with it. */
export function tellStatus() {
  const { status } = state;
  if (!status) return;
  const isTraced = ["tracing", "paused"].includes(status.phase), isStored = status.phase === "stored";
  const lines = [status.frame === null ? PHASES[status.phase] : `${PHASES[status.phase]}, frame ${status.frame}`];
  if (!isStored) lines.push(`${readable(status.samples_per_pixel, 4)} samples per pixel, ${clock(status.elapsed_s)}${isTraced && status.left_s !== null ? `, ${clock(status.left_s)} left` : ""}`);
  if (status.message) lines.push(status.message);
  if (state.latency !== null) lines.push(`Answered in ${state.latency.toFixed(0)} ms`);
  $("status").textContent = lines.join("\n");
  $("progress").hidden = isStored;
  $("progress").value = status.expected_paths ? Math.min(status.paths / status.expected_paths, 1) : 0;
  $("pause").textContent = status.phase === "paused" ? "Continue" : "Pause";
  $("pause").disabled = $("stop").disabled = !isTraced;
  for (const part of [$("trace-buttons"), $("camera-group"), ...document.querySelectorAll(".of-trace")]) part.hidden = isStored;
  $("frame-anew").hidden = status.frame === null;
  for (const tool of ["focus", "orbit"]) [...$("tool").options].find(option => option.value === tool).disabled = !status.camera || status.camera.moves;
}
