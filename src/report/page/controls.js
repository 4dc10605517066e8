// Last part: the legend, the controls, the pointer.

// ---- the legend
const text = x => x === 0 ? "0" : Number(x.toPrecision(3)).toString().replace("-", "−");
const css = code => "#" + code.toString(16).padStart(6, "0");
function colour(scale, share) {
  const at = Math.min(1, Math.max(0, share)) * 8, k = Math.min(7, Math.floor(at));
  const [a, b] = [linear(scale[k]), linear(scale[k + 1])];
  const mixed = a.map((x, c) => x + (at - k) * (b[c] - x));
  return "rgb(" + mixed.map(c => Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055))).join(" ") + ")";
}
function legend() {
  const mode = body.dataset.colours, from = mode === "signed" ? -end : 0, scale = scales[mode];
  const y = d => 288 - 270 * (d - from) / (end - from);
  let svg = "";
  for (let k = 0; k < 90; k++)
    svg += `<rect x="4" y="${18 + 3 * k}" width="20" height="3.6" fill="${colour(scale, 1 - (k + 0.5) / 90)}"/>`;
  const ticks = mode === "signed" ? [-1, -0.5, 0, 0.5, 1] : [0, 0.25, 0.5, 0.75, 1];
  const tolerance = parts.every(part => part.tolerance === parts[0].tolerance) ? parts[0].tolerance : Infinity;
  const marks = (mode === "signed" ? [-tolerance, tolerance] : [tolerance]).filter(d => Math.abs(d) < end);
  for (const share of ticks) {
    const d = share * end;
    if (marks.some(mark => Math.abs(y(mark) - y(d)) < 14)) continue;
    svg += `<text x="34" y="${y(d) + 4}">${d > 0 && mode === "signed" ? "+" : ""}${text(d)}</text>`;
  }
  for (const d of marks)
    svg += `<path class="mark" d="M0 ${y(d)}H30"/><text x="34" y="${y(d) + 4}">${d > 0 && mode === "signed" ? "+" : ""}${text(d)} tol.</text>`;
  svg += `<text x="4" y="10">mm</text>`;
  $("legend").firstElementChild.innerHTML = svg;
  for (const bar of document.querySelectorAll(".histogram rect")) {
    if (!bar.parentNode.classList.contains("of-" + body.dataset.points)) continue;
    const d = Number(bar.dataset.mm), signed = bar.parentNode.classList.contains("signed");
    bar.setAttribute("fill", colour(signed ? scene.signed : scene.distance, signed ? 0.5 + 0.5 * d / end : d / end));
  }
}

// ---- controls
for (const id of ["show-scan", "show-face", "show-edges", "show-net", "show-worst", "beyond"]) $(id).onchange = () => draw();
for (const name of ["colours", "points"])
  for (const input of document.getElementsByName(name))
    input.onchange = () => { body.dataset[name] = input.value; rescale(); legend(); draw(); };
$("range").oninput = event => { factor = 2 ** Number(event.target.value); rescale(); legend(); draw(); };
$("reset").onclick = () => { view = home(); fit(); draw(); };

const fingers = new Map();
canvas.addEventListener("contextmenu", event => event.preventDefault());
canvas.addEventListener("pointerdown", event => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  $("readout").hidden = true;
});
for (const name of ["pointerup", "pointercancel"])
  canvas.addEventListener(name, event => fingers.delete(event.pointerId));
canvas.addEventListener("pointerleave", () => { $("readout").hidden = true; });
canvas.addEventListener("pointermove", event => {
  const now = [event.offsetX, event.offsetY], before = fingers.get(event.pointerId);
  if (!before) { readout(event); return; }
  const [dx, dy] = [now[0] - before[0], now[1] - before[1]];
  if (fingers.size === 2) {
    const other = [...fingers].find(([id]) => id !== event.pointerId)[1];
    const far = p => Math.hypot(p[0] - other[0], p[1] - other[1]);
    zoom(far(before) / Math.max(1, far(now)), (now[0] + other[0]) / 2, (now[1] + other[1]) / 2);
    move(dx / 2, dy / 2);
  } else if (event.shiftKey || event.buttons & 6) move(dx, dy);
  else rotate(0.008 * dx, 0.008 * dy);
  fingers.set(event.pointerId, now);
  draw();
});
canvas.addEventListener("wheel", event => {
  event.preventDefault();
  const lines = event.deltaMode === 1 ? 18 : 1;
  zoom(Math.exp(0.0015 * lines * event.deltaY), event.offsetX, event.offsetY);
  draw();
}, { passive: false });
canvas.addEventListener("keydown", event => {
  const turn = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] }[event.key];
  const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
  if (turn) rotate(...turn);
  else if (event.key === "+" || event.key === "=") zoom(0.85, ...middle);
  else if (event.key === "-") zoom(1 / 0.85, ...middle);
  else if (event.key === "0") $("reset").onclick();
  else return;
  event.preventDefault();
  draw();
});

// The deviation under the pointer, on the triangle that is nearest to the eye.
function readout(event) {
  const out = $("readout");
  const d = checked("show-scan") && event.pointerType !== "touch" ? under(event.offsetX, event.offsetY) : null;
  out.hidden = d === null;
  if (d === null) return;
  out.textContent = `${d > 0 ? "+" : ""}${text(d)} mm`;
  out.style.left = `${event.offsetX}px`;
  out.style.top = `${event.offsetY}px`;
}

function under(left, top) {
  const x = (left - canvas.clientWidth / 2) * mm(), y = (canvas.clientHeight / 2 - top) * mm();
  let nearest = -Infinity, found = null;
  for (const part of parts) {
    const s = part.seen(), { triangles, values } = part, which = body.dataset.points === "smoothed" ? 1 : 0;
    for (let t = 0; t < triangles.length; t += 3) {
      const [i, j, k] = [triangles[t], triangles[t + 1], triangles[t + 2]];
      const ax = s[3 * i] - x, ay = s[3 * i + 1] - y, bx = s[3 * j] - x, by = s[3 * j + 1] - y, cx = s[3 * k] - x, cy = s[3 * k + 1] - y;
      const a = bx * cy - by * cx, b = cx * ay - cy * ax, c = ax * by - ay * bx;
      if ((a < 0 || b < 0 || c < 0) && (a > 0 || b > 0 || c > 0)) continue;
      const area = a + b + c;
      if (area === 0) continue;
      const z = (a * s[3 * i + 2] + b * s[3 * j + 2] + c * s[3 * k + 2]) / area;
      if (z <= nearest) continue;
      nearest = z;
      found = (a * values[2 * i + which] + b * values[2 * j + which] + c * values[2 * k + which]) / area;
    }
  }
  return found;
}

// Holes: rows, loops of the parameter plane and rims go together.
function light_(name) {
  if (hole === name) return;
  hole = name;
  for (const element of document.querySelectorAll("[data-hole]")) element.classList.toggle("on", element.dataset.hole === name);
  draw();
}
for (const element of document.querySelectorAll("[data-hole]")) {
  element.addEventListener("pointerenter", () => light_(element.dataset.hole));
  element.addEventListener("pointerleave", () => light_(null));
  element.addEventListener("focus", () => light_(element.dataset.hole));
  element.addEventListener("blur", () => light_(null));
}

new ResizeObserver(() => draw()).observe(canvas);
rescale();
fit();
legend();
paint();
