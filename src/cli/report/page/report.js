"use strict";
(() => {
  const $ = id => document.getElementById(id);
  const root = document.documentElement, body = document.body;

  // Light or dark: the system's, until the button is pressed.
  const dark = () => root.dataset.theme ? root.dataset.theme === "dark"
    : matchMedia("(prefers-color-scheme: dark)").matches;
  $("theme").onclick = () => { root.dataset.theme = dark() ? "light" : "dark"; draw(); };
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());

  let draw = () => {};
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

  // ---- programs
  const light = `
    float brightness(vec3 n) {
      vec3 key = normalize(vec3(-0.62, 0.62, 0.46)), side = normalize(vec3(0.85, -0.1, 0.5));
      return 0.04 + 1.3 * pow(0.5 + 0.5 * dot(n, key), 2.6) + 0.16 * max(0.0, dot(n, side)) + 0.1 * max(0.0, n.z);
    }
    vec3 encoded(vec3 c) {
      c = clamp(c, 0.0, 1.0);
      return mix(12.92 * c, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
    }`;
  const camera = `
    uniform mat3 turn; uniform vec3 eye; uniform vec3 zoom;
    vec3 seen(vec3 p) { return turn * p - eye; }
    vec4 place(vec3 s) { return vec4(s.xy * zoom.xy, -s.z * zoom.z, 1.0); }`;

  function program(vertex, fragment) {
    const made = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, "#version 300 es\nprecision highp float;\n" + text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(made, shader);
    }
    ["place_", "normal", "values"].forEach((name, k) => gl.bindAttribLocation(made, k, name));
    gl.linkProgram(made);
    if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
    const uniforms = {};
    for (let k = 0; k < gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS); k++) {
      const name = gl.getActiveUniform(made, k).name.replace("[0]", "");
      uniforms[name] = gl.getUniformLocation(made, name);
    }
    return { made, uniforms };
  }

  const sheet = program(`
    in vec3 place_, normal; in vec2 values; ${camera}
    uniform float which; uniform float sink;
    out vec3 n; out float d;
    void main() {
      vec3 s = seen(place_);
      n = turn * normal; d = mix(values.x, values.y, which);
      gl_Position = place(s + vec3(0.0, 0.0, sink));
    }`, `
    in vec3 n; in float d; out vec4 colour; ${light}
    uniform vec3 scale[9]; uniform float end; uniform bool absolute, plain, only; uniform float tolerance; uniform vec3 front, back;
    void main() {
      vec3 m = normalize(n);
      bool outer = gl_FrontFacing;
      if (!outer) m = -m;
      vec3 paint;
      if (plain) paint = outer ? front : back;
      else {
        float share = absolute ? abs(d) / end : 0.5 + 0.5 * d / end;
        float at = clamp(share, 0.0, 1.0) * 8.0;
        int k = min(int(at), 7);
        paint = mix(scale[k], scale[k + 1], at - float(k));
        if (only && abs(d) <= tolerance) paint = vec3(0.62);
      }
      float shade = plain ? brightness(m) : (outer ? 1.0 : 0.55) * (0.6 + 0.4 * brightness(m));
      vec3 half_ = normalize(normalize(vec3(-0.62, 0.62, 0.46)) + vec3(0.0, 0.0, 1.0));
      float gloss = plain ? 0.2 * pow(max(0.0, dot(m, half_)), 36.0) : 0.0;
      colour = vec4(encoded(paint * shade + gloss), 1.0);
    }`);

  const line = program(`
    in vec3 place_, normal; ${camera}
    uniform vec2 pixels; uniform float width, lift;
    void main() {
      vec3 a = seen(place_), b = seen(normal);
      vec2 along = (b.xy - a.xy) * zoom.xy * pixels;
      along = length(along) > 1e-6 ? normalize(along) : vec2(1.0, 0.0);
      int k = gl_VertexID;
      bool end = k == 1 || k == 2 || k == 4;
      float side = (k == 0 || k == 1 || k == 3) ? -1.0 : 1.0;
      vec2 off = side * vec2(-along.y, along.x) + (end ? along : -along) * 0.5;
      vec4 p = place((end ? b : a) + vec3(0.0, 0.0, lift));
      gl_Position = p + vec4(off * width / pixels, 0.0, 0.0);
    }`, `
    out vec4 colour; uniform vec4 ink;
    void main() { colour = vec4(ink.rgb * ink.a, ink.a); }`);

  // ---- what is drawn
  function buffer(data, target = gl.ARRAY_BUFFER) {
    const made = gl.createBuffer();
    gl.bindBuffer(target, made);
    gl.bufferData(target, data, gl.STATIC_DRAW);
    return made;
  }

  function upload(points, normals, triangles, values) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    [[points, 3], [normals, 3], [values, 2]].forEach(([data, size], k) => {
      if (!data) return;
      buffer(data);
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, size, gl.FLOAT, false, 0, 0);
    });
    buffer(triangles, gl.ELEMENT_ARRAY_BUFFER);
    gl.bindVertexArray(null);
    return { array, count: triangles.length };
  }

  function lines(pairs) {
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    buffer(pairs);
    for (const k of [0, 1]) {
      gl.enableVertexAttribArray(k);
      gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * k);
      gl.vertexAttribDivisor(k, 1);
    }
    gl.bindVertexArray(null);
    return { array, count: pairs.length / 6 };
  }

  const once = make => { let made; return () => made ??= make(); };
  const parts = scene.parts.map((part, number) => {
    const points = floats(part.scan.points), triangles = indices(part.scan.triangles);
    const [measured, smoothed] = [floats(part.scan.measured), floats(part.scan.smoothed)];
    const values = new Float32Array(2 * measured.length);
    for (let k = 0; k < measured.length; k++) { values[2 * k] = measured[k]; values[2 * k + 1] = smoothed[k]; }
    const rims = part.rims.map(rim => ({ hole: rim.hole, points: floats(rim.points) }));
    const holes = new Map();
    for (const rim of rims) if (rim.hole !== null) holes.set(`${number}-${rim.hole}`, once(() => lines(segments([rim.points]))));
    // All points as they are seen, until the view changes.
    let at = "", places = new Float32Array(points.length);
    const seenAll = () => {
      const now = JSON.stringify([view.turn, view.eye]);
      if (now !== at) {
        at = now;
        for (let k = 0; k < points.length; k += 3) places.set(seen([points[k], points[k + 1], points[k + 2]]), k);
      }
      return places;
    };
    return {
      triangles, values, seen: seenAll, outlines: rims.map(rim => rim.points),
      scan: upload(points, vertexNormals(points, triangles), triangles, values),
      face: part.face && once(() => {
        const [places, corners] = [floats(part.face.points), indices(part.face.triangles)];
        return upload(places, vertexNormals(places, corners), corners);
      }),
      rims: lines(segments(rims.map(rim => rim.points))),
      edges: once(() => lines(segments(part.edges.map(edge => floats(edge.points))))),
      net: once(() => lines(netLines(part.net))),
      holes, tolerance: part.tolerance, worst: part.worst,
    };
  });
  if (!parts.some(part => part.face)) $("show-face").disabled = true;

  // ---- the camera: rows to the right, up, towards the eye
  const home = () => ({ turn: scene.axes.map(axis => [...axis]), eye: [0, 0, 0], span: 2.25 * scene.radius });
  let view = home(), hole = null;
  // The scale's end, for the points that are shown.
  let factor = 1, end = 0;
  const rescale = () => { end = factor * scene.end[body.dataset.points]; };
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const seen = p => view.turn.map((axis, k) => dot(axis, p) - view.eye[k]);

  function fit() {
    // As large as the scan's box allows in this view.
    const low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    for (const { outlines } of parts) for (const points of outlines) {
      for (let k = 0; k < points.length; k += 3)
        for (const axis of [0, 1]) {
          const x = dot(view.turn[axis], points.subarray(k, k + 3));
          low[axis] = Math.min(low[axis], x); high[axis] = Math.max(high[axis], x);
        }
    }
    if (high[0] > low[0]) {
      const [w, h] = [high[0] - low[0], high[1] - low[1]];
      view.eye = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, 0];
      const aspect = canvas.clientWidth / Math.max(1, canvas.clientHeight);
      const room = aspect > 1.2 ? 0.74 : 0.95; // beside the panels
      view.span = 1.12 * Math.max(h, w / (aspect * room), 1e-9);
    }
  }

  function rotate(x, y) {
    const [right, up, eye] = view.turn;
    const [cx, sx, cy, sy] = [Math.cos(x), Math.sin(x), Math.cos(y), Math.sin(y)];
    const r = right.map((v, k) => cx * v + sx * eye[k]);
    const e = eye.map((v, k) => cx * v - sx * right[k]);
    const u = up.map((v, k) => cy * v - sy * e[k]);
    const e2 = e.map((v, k) => cy * v + sy * up[k]);
    // Turned around the point in the middle of the picture.
    const middle = [0, 1, 2].map(k => view.eye[0] * right[k] + view.eye[1] * up[k] + view.eye[2] * eye[k]);
    view.turn = orthonormal(r, u, e2);
    view.eye = view.turn.map(axis => dot(axis, middle));
  }

  function orthonormal(r, u, e) {
    const unit = v => { const n = Math.hypot(...v); return v.map(x => x / n); };
    e = unit(e);
    r = unit(r.map((x, k) => x - dot(r, e) * e[k]));
    return [r, [e[1] * r[2] - e[2] * r[1], e[2] * r[0] - e[0] * r[2], e[0] * r[1] - e[1] * r[0]], e];
  }

  const mm = () => view.span / Math.max(1, canvas.clientHeight); // of a CSS pixel
  function move(dx, dy) { view.eye[0] -= dx * mm(); view.eye[1] += dy * mm(); }
  function zoom(factor, x, y) {
    const before = mm();
    view.span = Math.min(20 * scene.radius, Math.max(2e-4 * scene.radius, view.span * factor));
    const off = before - mm();
    view.eye[0] += (x - canvas.clientWidth / 2) * off;
    view.eye[1] -= (y - canvas.clientHeight / 2) * off;
  }

  // ---- drawing
  const linear = code => [16, 8, 0].map(shift => {
    const c = (code >> shift & 255) / 255;
    return c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  });
  const scales = { signed: scene.signed, distance: scene.distance };
  const checked = id => $(id).checked;

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
    const mode = body.dataset.colours;
    gl.uniform3fv(u.scale, scales[mode].flatMap(linear));
    gl.uniform1f(u.end, end);
    gl.uniform1i(u.absolute, mode === "distance");
    gl.uniform1i(u.only, checked("beyond"));
    gl.uniform1f(u.which, body.dataset.points === "smoothed" ? 1 : 0);
    gl.uniform3fv(u.front, linear(0x86b0dc));
    gl.uniform3fv(u.back, linear(0xdda35a));
    for (const part of parts) {
      gl.uniform1f(u.tolerance, part.tolerance);
      const show = (made, plain, sink) => {
        gl.uniform1i(u.plain, plain);
        gl.uniform1f(u.sink, sink);
        gl.bindVertexArray(made.array);
        gl.drawElements(gl.TRIANGLES, made.count, gl.UNSIGNED_INT, 0);
      };
      if (checked("show-scan")) show(part.scan, false, 0);
      // With the scan over it, the face keeps a little below, so that its colours stay whole.
      if (checked("show-face") && part.face) show(part.face(), true, checked("show-scan") ? -0.002 * scene.radius : 0);
    }
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
      if (checked("show-edges") || (checked("show-face") && !checked("show-scan"))) strokes(part.edges(), 2, [...ink, 1], 0.005);
      if (checked("show-net")) strokes(part.net(), 1, dark() ? [1, 0.55, 0.45, 0.75] : [0.7, 0.15, 0.12, 0.7], 0.004);
      const rim = hole && part.holes.get(hole);
      if (rim) { gl.disable(gl.DEPTH_TEST); strokes(rim(), 5, [0.88, 0.13, 0.54, 1], 0); gl.enable(gl.DEPTH_TEST); }
    }
    pin();
  }

  function pin() {
    const which = body.dataset.points;
    const worst = parts.map(part => part.worst[which]).reduce((a, b) => b.mm > a.mm ? b : a);
    const s = seen(worst.at), shown = checked("show-worst");
    $("worst").hidden = !shown;
    if (!shown) return;
    const x = canvas.clientWidth / 2 + s[0] / mm(), y = canvas.clientHeight / 2 - s[1] / mm();
    $("worst").style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    $("worst").lastElementChild.textContent = `worst: ${text(worst.mm)} mm`;
  }

  let waiting = false;
  draw = () => {
    if (waiting) return;
    waiting = true;
    requestAnimationFrame(() => { waiting = false; paint(); });
  };

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
})();
