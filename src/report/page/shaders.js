// Second part: what the graphics card does.

// ---- programs
// How a sheet is painted: in one colour or those of its faces, by a number on a scale, in stripes.
const [PLAIN, SCALED, ZEBRA] = [0, 1, 2];
// Stripes over the half circle of mirrored directions: few show no small waves, many run together.
const STRIPES = 16;
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
    n = turn * normal; d = which < 0.5 ? values.x : values.y;
    gl_Position = place(s + vec3(0.0, 0.0, sink));
  }`, `
  in vec3 n; in float d; out vec4 colour; ${light}
  uniform vec3 scale[9]; uniform float end; uniform bool absolute, only, tinted; uniform int kind; uniform vec3 tints[${scene.tints.length}]; uniform float tolerance; uniform vec3 front, back;
  // Bright and dark lamps across, mirrored in the sheet: a kink breaks the stripes, a jump of curvature bends them sharply.
  vec3 zebra(vec3 m) {
    float across = ${STRIPES.toFixed(1)} * acos(clamp(2.0 * m.z * m.y, -1.0, 1.0)) / 3.14159265;
    float edge = abs(fract(across) - 0.5) - 0.25, soft = max(fwidth(across), 1e-4);
    return vec3(mix(0.03, 0.85, clamp(0.5 + edge / soft, 0.0, 1.0)));
  }
  void main() {
    vec3 m = normalize(n);
    bool outer = gl_FrontFacing;
    if (!outer) m = -m;
    bool scaled = kind == ${SCALED};
    vec3 paint;
    if (kind == ${ZEBRA}) paint = zebra(m);
    else if (!scaled) paint = !outer ? back : tinted ? tints[int(d + 0.5)] : front;
    else {
      float share = absolute ? abs(d) / end : 0.5 + 0.5 * d / end;
      float at = clamp(share, 0.0, 1.0) * 8.0;
      int k = min(int(at), 7);
      paint = mix(scale[k], scale[k + 1], at - float(k));
      if (only && abs(d) <= tolerance) paint = vec3(0.62);
    }
    float shade = kind == ${PLAIN} ? brightness(m) : (outer ? 1.0 : 0.55) * (0.6 + 0.4 * brightness(m));
    vec3 half_ = normalize(normalize(vec3(-0.62, 0.62, 0.46)) + vec3(0.0, 0.0, 1.0));
    float gloss = kind == ${PLAIN} ? 0.2 * pow(max(0.0, dot(m, half_)), 36.0) : 0.0;
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
