// Last part: the legend, the controls, the pointer.

// ---- the legend
const text = x => x === 0 ? "0" : Number(x.toPrecision(3)).toString().replace("-", "−");
function colour(scale, share) {
  const at = Math.min(1, Math.max(0, share)) * 8, k = Math.min(7, Math.floor(at));
  const [a, b] = [linear(scale[k]), linear(scale[k + 1])];
  const mixed = a.map((x, c) => x + (at - k) * (b[c] - x));
  return "rgb(" + mixed.map(c => Math.round(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055))).join(" ") + ")";
}
// The scale of what is in front: the scan over the face.
function shownScale() {
  if (checked("show-scan")) {
    const signed = body.dataset.colours === "signed";
    const tolerance = parts.every(part => part.tolerance === parts[0].tolerance) ? parts[0].tolerance : Infinity;
    const marks = (signed ? [-tolerance, tolerance] : [tolerance]).filter(d => Math.abs(d) < end);
    return { what: "Deviation", unit: "mm", from: signed ? -end : 0, to: end, scale: scales[signed ? "signed" : "distance"], marks };
  }
  if (!checked("show-face") || chosen("face-colours") !== "curvature") return null;
  return { what: "Mean curvature", unit: "1/mm", from: -curvatureEnd(), to: curvatureEnd(), scale: scales.signed, marks: [] };
}
function legend() {
  const shown = shownScale();
  $("legend").hidden = !shown;
  recolour();
  if (!shown) return;
  const { what, unit, from, to, scale, marks } = shown;
  const y = d => 288 - 270 * (d - from) / (to - from), signed = from < 0;
  const number = d => (d > 0 && signed ? "+" : "") + text(d);
  let svg = `<text x="4" y="10">${unit}</text>`;
  for (let k = 0; k < 90; k++)
    svg += `<rect x="4" y="${18 + 3 * k}" width="20" height="3.6" fill="${colour(scale, 1 - (k + 0.5) / 90)}"/>`;
  for (const share of [0, 0.25, 0.5, 0.75, 1]) {
    const d = from + share * (to - from);
    if (marks.some(mark => Math.abs(y(mark) - y(d)) < 14)) continue;
    svg += `<text x="34" y="${y(d) + 4}">${number(d)}</text>`;
  }
  for (const d of marks)
    svg += `<path class="mark" d="M0 ${y(d)}H30"/><text x="34" y="${y(d) + 4}">${number(d)} tol.</text>`;
  $("legend-of").textContent = what;
  $("legend").querySelector("svg").innerHTML = svg;
  $("legend").querySelector("svg").setAttribute("aria-label", `${what}: colours from ${number(from)} to ${number(to)} ${unit}`);
  $("range").setAttribute("aria-valuetext", `${number(to)} ${unit}`);
}
function recolour() {
  for (const bar of document.querySelectorAll(".histogram rect")) {
    if (!bar.parentNode.classList.contains("of-" + body.dataset.points)) continue;
    const d = Number(bar.dataset.mm), signed = bar.parentNode.classList.contains("signed");
    bar.setAttribute("fill", colour(signed ? scene.signed : scene.distance, signed ? 0.5 + 0.5 * d / end : d / end));
  }
}

// ---- controls
const refresh = () => { rescale(); legend(); draw(); };
for (const id of ["show-scan", "show-face", "show-edges", "show-net", "show-worst", "beyond"]) $(id).onchange = refresh;
for (const name of ["colours", "points"])
  for (const input of document.getElementsByName(name))
    input.onchange = () => { body.dataset[name] = input.value; refresh(); };
// Curvature and stripes belong to the face, which the scan would hide.
for (const input of document.getElementsByName("face-colours"))
  input.onchange = () => { $("show-face").checked = true; if (input.value !== "plain") $("show-scan").checked = false; refresh(); };
$("range").oninput = event => { factor = 2 ** Number(event.target.value); refresh(); };
function look(side) {
  view = from(side);
  fit();
  draw();
  say(side === "overview" ? "Overview" : `Seen from: ${side}`);
}
const buttons = [...document.querySelectorAll("[data-side]")];
for (const button of buttons) button.onclick = () => look(button.dataset.side);
for (const [id, amount] of [["nearer", 0.8], ["farther", 1.25]])
  $(id).onclick = () => { zoom(amount, canvas.clientWidth / 2, canvas.clientHeight / 2); draw(); };

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
  const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[event.key];
  const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  if (step && event.shiftKey) move(...step.map(x => 40 * x));
  else if (step) rotate(...step.map(x => 0.1 * x));
  else if (event.key === "+" || event.key === "=") zoom(0.85, ...middle);
  else if (event.key === "-") zoom(1 / 0.85, ...middle);
  else if (buttons[event.key] && event.key.length === 1) look(buttons[event.key].dataset.side);
  else if (event.key === "Enter") readMiddle();
  else return;
  event.preventDefault();
  draw();
});

// Says the deviation in the middle of the view.
function readMiddle() {
  const [x, y] = [canvas.clientWidth / 2, canvas.clientHeight / 2];
  const d = checked("show-scan") ? under(x, y) : null;
  showReadout(d, x, y);
  say(d === null ? "There is no scan in the middle of the view" : `Deviation in the middle of the view: ${signed(d)} mm`);
}

const signed = d => (d > 0 ? "+" : "") + text(d);
function showReadout(d, x, y) {
  const out = $("readout");
  out.hidden = d === null;
  if (d === null) return;
  out.textContent = `${signed(d)} mm`;
  out.style.left = `${x}px`;
  out.style.top = `${Math.max(y, 32)}px`;
  out.classList.toggle("left", x > canvas.clientWidth - 120);
}

// The deviation under the pointer, on the triangle that is nearest to the eye.
function readout(event) {
  const d = checked("show-scan") && event.pointerType !== "touch" ? under(event.offsetX, event.offsetY) : null;
  showReadout(d, event.offsetX, event.offsetY);
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
  // Only the rows take the focus, not the loops of the drawing.
  if (element.tabIndex < 0) continue;
  element.addEventListener("focus", () => light_(element.dataset.hole));
  element.addEventListener("blur", () => light_(null));
}

// The places of the largest deviations, of bores and of facets, which the keyboard reaches, too.
for (const row of document.querySelectorAll("[data-place], [data-spot]")) {
  const isSpot = row.dataset.spot !== undefined;
  const [part, number] = (isSpot ? row.dataset.spot : row.dataset.place).split("-");
  const found = scene.parts[part][isSpot ? "spots" : "places"][number];
  const shown = { at: found.at, text: isSpot ? found.text : `${signed(found.mm)} mm` };
  const mark = chosen => { place = chosen; row.classList.toggle("on", Boolean(chosen)); draw(); };
  for (const event of ["pointerenter", "focus"]) row.addEventListener(event, () => mark(shown));
  for (const event of ["pointerleave", "blur"]) row.addEventListener(event, () => mark(null));
}

new ResizeObserver(() => { $("readout").hidden = true; draw(); }).observe(canvas);
rescale();
fit();
legend();
paint();
