// Third part: what there is to see, and from where.

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

function lines(ends) {
  const array = gl.createVertexArray();
  gl.bindVertexArray(array);
  buffer(ends);
  for (const k of [0, 1]) {
    gl.enableVertexAttribArray(k);
    gl.vertexAttribPointer(k, 3, gl.FLOAT, false, 24, 12 * k);
    gl.vertexAttribDivisor(k, 1);
  }
  gl.bindVertexArray(null);
  return { array, count: ends.length / 6 };
}

// Two numbers of every vertex beside each other.
function pairs(first, second) {
  const both = new Float32Array(2 * first.length);
  for (let k = 0; k < first.length; k++) { both[2 * k] = first[k]; both[2 * k + 1] = second[k]; }
  return both;
}

const once = make => { let made; return () => made ??= make(); };
const parts = scene.parts.map((part, number) => {
  const points = floats(part.scan.points), triangles = indices(part.scan.triangles);
  const values = pairs(floats(part.scan.measured), floats(part.scan.smoothed));
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
    triangles, values, seen: seenAll, outlines: rims.length ? rims.map(rim => rim.points) : [points],
    scan: upload(points, vertexNormals(points, triangles), triangles, values),
    face: part.face && once(() => {
      const { points, normals, triangles, tints, curvatures, tinted } = part.face;
      const numbers = pairs(new Uint8Array(bytes(tints)), floats(curvatures));
      return { ...upload(floats(points), shorts(normals), indices(triangles), numbers), tinted };
    }),
    dots: once(() => lines(points_(floats(part.irregular)))),
    rims: lines(segments(rims.map(rim => rim.points))),
    edges: once(() => lines(segments(part.edges.map(edge => floats(edge.points))))),
    smooth: once(() => lines(segments(part.smooth.map(floats)))),
    net: once(() => lines(netLines(part.net))),
    holes, tolerance: part.tolerance, worst: part.worst, places: part.places,
  };
});
if (!parts.some(part => part.face)) $("show-face").disabled = true;

// ---- the camera: rows to the right, up, towards the eye
// The sides have the names that CAD programs give them: z is up, and the front looks along y.
const sides = {
  overview: scene.axes,
  front: [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
  back: [[-1, 0, 0], [0, 0, 1], [0, 1, 0]],
  left: [[0, -1, 0], [0, 0, 1], [-1, 0, 0]],
  right: [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
  top: [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
  bottom: [[1, 0, 0], [0, -1, 0], [0, 0, -1]],
};
const from = side => ({ turn: sides[side].map(axis => [...axis]), eye: [0, 0, 0], span: 2.25 * scene.radius });
let view = from("overview"), hole = null, place = null;
// The scale's end, for the points that are shown.
let factor = 1, end = 0;
const rescale = () => { end = factor * scene.end[body.dataset.points]; };
const curvatureEnd = () => factor * scene.end.curvature;
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
    const bar = aspect > 1.2 ? 0.08 : 0; // of the height, for the buttons above
    view.span = 1.12 * Math.max(h / (1 - bar), w / (aspect * room), 1e-9);
    view.eye[1] += 0.5 * bar * view.span;
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
