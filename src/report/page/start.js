// The page's program, first part: light and dark, WebGL, and the arrays that the page
// brings. The parts stand one after the other in one function.

const $ = id => document.getElementById(id);
// Tells a screen reader.
const say = text => { $("said").textContent = text; };
const root = document.documentElement, body = document.body;

// Light or dark: the system's, until the button is pressed.
const dark = () => root.dataset.theme ? root.dataset.theme === "dark"
  : matchMedia("(prefers-color-scheme: dark)").matches;
$("theme").onclick = () => { root.dataset.theme = dark() ? "light" : "dark"; draw(); };
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());

let draw = () => {};

// The command goes to the clipboard. A page from a disk may have no clipboard: then it is selected.
if ($("copy")) {
  $("copy").hidden = false;
  $("copy").onclick = async () => {
    getSelection().selectAllChildren($("command-line"));
    const copied = await Promise.resolve(navigator.clipboard?.writeText($("command-line").textContent))
      .then(() => Boolean(navigator.clipboard), () => document.execCommand("copy"));
    say(copied ? "Copied" : "Selected: copy it with the keyboard");
    $("copy").textContent = copied ? "Copied" : "Selected";
  };
}

const scene = JSON.parse($("scene").textContent);
const gl = scene.axes && $("view").getContext("webgl2", { antialias: true, alpha: true, premultipliedAlpha: true });
if (!gl) { $("refused").hidden = false; return; }
$("stage").hidden = false;
$("viewer").classList.add("live");
const canvas = $("view");
canvas.addEventListener("webglcontextlost", () => {
  $("viewer").classList.remove("live"); $("stage").hidden = true; $("refused").hidden = false;
});

// ---- typed arrays
const bytes = text => Uint8Array.from(atob(text), c => c.charCodeAt(0)).buffer;
const floats = text => new Float32Array(bytes(text));
const shorts = text => Float32Array.from(new Int16Array(bytes(text)), x => x / 32767);
const indices = text => new Uint32Array(bytes(text));

function vertexNormals(points, triangles) {
  const normals = new Float32Array(points.length);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [3 * triangles[t], 3 * triangles[t + 1], 3 * triangles[t + 2]];
    const ux = points[b] - points[a], uy = points[b + 1] - points[a + 1], uz = points[b + 2] - points[a + 2];
    const vx = points[c] - points[a], vy = points[c + 1] - points[a + 1], vz = points[c + 2] - points[a + 2];
    const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
    for (const k of [a, b, c]) { normals[k] += nx; normals[k + 1] += ny; normals[k + 2] += nz; }
  }
  return normals;
}

// A polyline as pairs of ends.
function segments(lines) {
  let count = 0;
  for (const line of lines) count += Math.max(0, line.length / 3 - 1);
  const pairs = new Float32Array(6 * count);
  let at = 0;
  for (const line of lines)
    for (let k = 0; k + 5 < line.length; k += 3) { pairs.set(line.subarray(k, k + 6), at); at += 6; }
  return pairs;
}

// Points as polylines without a length.
function points_(places) {
  return segments(Array.from({ length: places.length / 3 }, (_, k) => {
    const p = places.subarray(3 * k, 3 * k + 3);
    return Float32Array.of(...p, ...p);
  }));
}

function netLines({ rows, columns, points }) {
  const net = floats(points), lines = [];
  for (let i = 0; i < rows; i++) lines.push(net.subarray(3 * i * columns, 3 * (i + 1) * columns));
  for (let j = 0; j < columns; j++) {
    const line = new Float32Array(3 * rows);
    for (let i = 0; i < rows; i++) line.set(net.subarray(3 * (i * columns + j), 3 * (i * columns + j) + 3), 3 * i);
    lines.push(line);
  }
  return segments(lines);
}
