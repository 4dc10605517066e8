// Fourth part: drawing it.

// ---- drawing
const linear = code => [16, 8, 0].map(shift => {
  const c = (code >> shift & 255) / 255;
  return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
});
const scales = { signed: scene.signed, distance: scene.distance };
const checked = id => $(id).checked;
const chosen = name => document.querySelector(`input[name=${name}]:checked`).value;

function use(which, at) {
  gl.useProgram(which.made);
  const [w, h] = [canvas.width, canvas.height];
  const t = view.turn;
  gl.uniformMatrix3fv(which.uniforms.turn, false, [0, 1, 2].flatMap(k => [t[0][k], t[1][k], t[2][k]]));
  gl.uniform3fv(which.uniforms.eye, view.eye);
  gl.uniform3f(which.uniforms.zoom, 2 * h / (w * view.span), 2 / view.span, 1 / (4 * scene.radius + 1e-30));
  if (which.uniforms.pixels) gl.uniform2f(which.uniforms.pixels, w / 2, h / 2);
  return which.uniforms;
}

function sheets() {
  const u = use(sheet);
  gl.uniform3fv(u.front, linear(0x86b0dc));
  gl.uniform3fv(u.back, linear(0xdda35a));
  gl.uniform3fv(u.tints, scene.tints.flatMap(linear));
  for (const part of parts) {
    if (checked("show-scan")) show(u, part.scan, { ...lookOfScan(), tolerance: part.tolerance });
    if (checked("show-face") && part.face) show(u, part.face(), lookOfFace());
  }
}

function lookOfScan() {
  const mode = body.dataset.colours, which = body.dataset.points === "smoothed" ? 1 : 0;
  return { kind: SCALED, which, scale: scales[mode], end, absolute: mode === "distance", only: checked("beyond"), sink: 0 };
}

function lookOfFace() {
  const kind = { plain: PLAIN, curvature: SCALED, zebra: ZEBRA }[chosen("face-colours")];
  // With the scan over it, the face keeps a little below, so that its colours stay whole.
  const sink = checked("show-scan") ? -0.002 * scene.radius : 0;
  return { kind, which: kind === SCALED ? 1 : 0, scale: scales.signed, end: curvatureEnd(), absolute: false, only: false, sink, tolerance: 0 };
}

function show(u, made, look) {
  gl.uniform1i(u.kind, look.kind);
  gl.uniform1f(u.which, look.which);
  gl.uniform3fv(u.scale, look.scale.flatMap(linear));
  gl.uniform1f(u.end, look.end);
  gl.uniform1i(u.absolute, look.absolute);
  gl.uniform1i(u.only, look.only);
  gl.uniform1f(u.sink, look.sink);
  gl.uniform1f(u.tolerance, look.tolerance);
  gl.uniform1i(u.tinted, Boolean(made.tinted));
  gl.bindVertexArray(made.array);
  gl.drawElements(gl.TRIANGLES, made.count, gl.UNSIGNED_INT, 0);
}

function strokes(made, width, ink, lift) {
  const u = use(line);
  gl.uniform1f(u.width, width * devicePixelRatio / 2);
  gl.uniform1f(u.lift, lift * scene.radius);
  gl.uniform4fv(u.ink, ink);
  gl.bindVertexArray(made.array);
  gl.drawArraysInstanced(gl.TRIANGLES, 0, 6, made.count);
}

function paint() {
  const ratio = devicePixelRatio || 1;
  const [w, h] = [canvas.clientWidth, canvas.clientHeight].map(x => Math.max(1, Math.round(x * ratio)));
  if (canvas.width !== w || canvas.height !== h) { canvas.width = w; canvas.height = h; }
  gl.viewport(0, 0, w, h);
  gl.clearColor(0, 0, 0, 0);
  gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
  gl.enable(gl.DEPTH_TEST);
  gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
  sheets();
  const ink = dark() ? [0.91, 0.93, 0.95] : [0.11, 0.14, 0.19];
  for (const part of parts) {
    if (checked("show-scan")) strokes(part.rims, 1.2, [...ink, 0.8], 0.003);
    if (checked("show-edges") || (checked("show-face") && !checked("show-scan"))) {
      strokes(part.smooth(), 1, [...ink, 0.45], 0.005);
      strokes(part.edges(), 2, [...ink, 1], 0.005);
      strokes(part.dots(), 7, [0.7, 0.15, 0.12, 1], 0.006);
    }
    if (checked("show-net")) strokes(part.net(), 1, dark() ? [1, 0.55, 0.45, 0.75] : [0.7, 0.15, 0.12, 0.7], 0.004);
    const rim = hole && part.holes.get(hole);
    if (rim) { gl.disable(gl.DEPTH_TEST); strokes(rim(), 5, [0.88, 0.13, 0.54, 1], 0); gl.enable(gl.DEPTH_TEST); }
  }
  pin();
}

// The ring around the worst point, or around the place that the user has chosen from the list.
function pin() {
  const which = body.dataset.points;
  const worst = parts.map(part => part.worst[which]).reduce((a, b) => b.mm > a.mm ? b : a);
  const shown = place || (checked("show-worst") ? { at: worst.at, text: `worst: ${text(worst.mm)} mm` } : null);
  $("worst").hidden = !shown;
  if (!shown) return;
  const s = seen(shown.at);
  const x = canvas.clientWidth / 2 + s[0] / mm(), y = canvas.clientHeight / 2 - s[1] / mm();
  $("worst").style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
  $("worst").classList.toggle("left", x > canvas.clientWidth - 150);
  $("worst").lastElementChild.textContent = shown.text;
}

let waiting = false;
draw = () => {
  if (waiting) return;
  waiting = true;
  requestAnimationFrame(() => { waiting = false; paint(); });
};
