// The page of photosite view. `window.state` is for tests: what was asked for, what came back.
const state = { pictures: 0, picture: null, status: null, error: null };
window.state = state;

const canvas = document.getElementById("picture");
const line = document.getElementById("status");

/** A picture of the server: its description and its values. */
async function fetchPicture(query) {
  const answer = await fetch("picture?" + new URLSearchParams(query));
  if (!answer.ok) throw new Error((await answer.json()).message);
  const bytes = await answer.arrayBuffer();
  const length = new DataView(bytes).getUint32(0, true);
  const description = JSON.parse(new TextDecoder().decode(new Uint8Array(bytes, 4, length)));
  const kinds = { u8: Uint8Array, u16: Uint16Array, f32: Float32Array };
  return { ...description, values: new kinds[description.type](bytes, 4 + length) };
}

function paint(picture) {
  const { width, height, values, channels } = picture;
  const data = new ImageData(width, height);
  const most = picture.type === "u16" ? 257 : 1;
  for (let i = 0; i < width * height; i++) {
    for (let c = 0; c < 3; c++) data.data[4 * i + c] = values[i * channels.length + (channels.length === 3 ? c : 0)] / most;
    data.data[4 * i + 3] = 255;
  }
  canvas.width = width;
  canvas.height = height;
  canvas.getContext("2d").putImageData(data, 0, 0);
}

let busy = false, wanted = false;
async function refresh() {
  if (busy) { wanted = true; return; }
  busy = true;
  try {
    state.picture = await fetchPicture({ plane: "developed" });
    paint(state.picture);
    state.pictures++;
  } catch (error) {
    state.error = error.message;
    line.textContent = error.message;
  }
  busy = false;
  if (wanted) { wanted = false; refresh(); }
}

const events = new EventSource("events");
let light = 0;
events.onmessage = ({ data }) => {
  state.status = JSON.parse(data);
  line.textContent = `${state.status.phase}, ${state.status.samples_per_pixel.toFixed(0)} samples a pixel`;
  if (state.status.light !== light) { light = state.status.light; refresh(); }
};
events.onerror = () => { line.textContent = "The connection is lost"; };
