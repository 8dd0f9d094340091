// An object and its grasps in WebGL, from data packed by egad/report/viewer.py. Part of viewer.js and gallery.js.

const MESH = [0.78, 0.80, 0.83];
const PAINTS = [MESH, [0.36, 0.56, 0.80], [0.95, 0.62, 0.29], [0.16, 0.63, 0.35], [0.80, 0.15, 0.15],
  [0.45, 0.72, 0.60]];
const STEM = 0.15, THICK = 0.006; // of the longest side of the object
const AMBIENT = { mesh: 0.5, jaws: 0.75 }; // ambient part of the light
const CREASE = Math.cos(40 * Math.PI / 180);
const GROUND = [0.961, 0.965, 0.973];
const START = { azimuth: -0.918, height: 0.505, zoom: 1 };
const SHADER = `
  attribute vec3 place, normal, color;
  uniform mat3 turn;
  uniform vec3 center;
  uniform float size, zoom, ambient;
  uniform vec2 shape;
  varying vec3 shade;
  void main() {
    vec3 seen = turn * ((place - center) / size);
    float light = ambient + (1.0 - ambient) * max(dot(turn * normal, normalize(vec3(-0.4, 0.6, 0.75))), 0.0);
    shade = color * light;
    float depth = 4.0 - seen.z;
    gl_Position = vec4(seen.xy * shape * zoom * 4.6, 1.2 * depth - 2.0, depth);
  }`;
const PAINT = `
  precision mediump float;
  varying vec3 shade;
  void main() { gl_FragColor = vec4(shade, 1.0); }`;

// ---- data

async function unpack(item, finger) {
  const packed = Uint8Array.from(atob(item.data), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const buffer = await new Response(stream).arrayBuffer();
  const [vertices, faces, grasps] = item.counts;
  let start = 0;
  function take(Kind, count) {
    const part = new Kind(buffer, start, count);
    start += part.byteLength;
    return part;
  }
  const object = {
    name: item.name, title: item.title, note: item.note, grasps, finger,
    faces: undoZigzag(take(Uint8Array, 12 * faces)),
    steps: undoZigzag(take(Uint8Array, 12 * vertices)),
    metrics: [take(Float32Array, grasps), take(Float32Array, grasps)],
  };
  const metres = (steps) => Float32Array.from(steps, (step, i) => item.origin[i % 3] + item.step * step);
  object.vertices = metres(object.steps);
  object.contacts = metres(take(Uint16Array, 6 * grasps));
  object.approaches = Float32Array.from(take(Int16Array, 3 * grasps), (value) => value / 32767);
  object.free = take(Uint8Array, grasps);
  object.paint = item.painted ? take(Uint8Array, faces) : null;
  object.labels = item.labelled ? take(Uint8Array, grasps) : null;
  return measure(object);
}

// Rows of three whole numbers from their differences: first the lowest bytes of all, and so on.
function undoZigzag(bytes) {
  const count = bytes.length / 4;
  const rows = new Int32Array(count);
  for (let i = 0; i < count; i++) {
    let folded = 0;
    for (let k = 3; k >= 0; k--) folded = (folded << 8) | bytes[k * count + i];
    rows[i] = ((folded >>> 1) ^ -(folded & 1)) + (i < 3 ? 0 : rows[i - 3]);
  }
  return rows;
}

function measure(object) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  object.vertices.forEach((value, i) => {
    low[i % 3] = Math.min(low[i % 3], value);
    high[i % 3] = Math.max(high[i % 3], value);
  });
  object.center = low.map((value, i) => (value + high[i]) / 2);
  object.longest = Math.max(...high.map((value, i) => value - low[i]));
  object.size = Math.hypot(...high.map((value, i) => value - low[i])) * 0.45 + 0.4 * object.finger;
  object.sides = high.map((value, i) => 1000 * (value - low[i]));
  return object;
}

// ---- triangles: rows of place, normal and color

const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const plus = (a, b, times = 1) => [a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const length = Math.hypot(...a) || 1; return a.map((value) => value / length); };

// Smooth over gentle edges and flat at sharp ones.
function surface({ vertices, faces, paint }) {
  const corner = (at) => vertices.subarray(3 * faces[at], 3 * faces[at] + 3);
  const flat = [], around = Array.from({ length: vertices.length / 3 }, () => []);
  for (let face = 0; face < faces.length / 3; face++) {
    const first = corner(3 * face);
    const normal = cross(minus(corner(3 * face + 1), first), minus(corner(3 * face + 2), first));
    flat.push([unit(normal), normal]);
    for (let k = 0; k < 3; k++) around[faces[3 * face + k]].push(face);
  }
  const rows = new Float32Array(9 * faces.length);
  faces.forEach((vertex, at) => {
    const face = Math.floor(at / 3), own = flat[face][0];
    let normal = [0, 0, 0];
    for (const other of around[vertex]) {
      if (dot(flat[other][0], own) > CREASE) normal = plus(normal, flat[other][1]);
    }
    rows.set([...corner(at), ...unit(normal), ...(paint ? PAINTS[paint[face]] : MESH)], 9 * at);
  });
  return rows;
}

// A bar from one point to another, thick along the vectors `wide` and `deep`.
function addBar(rows, from, to, wide, deep, color) {
  const along = unit(minus(to, from));
  const ring = (end) => [[1, 1], [-1, 1], [-1, -1], [1, -1]].map(([a, b]) => plus(plus(end, wide, a), deep, b));
  const [a, b] = [ring(from), ring(to)];
  const sides = [[wide, 0, 3], [deep, 1, 0], [wide.map((v) => -v), 2, 1], [deep.map((v) => -v), 3, 2]];
  const quads = sides.map(([normal, i, j]) => [unit(normal), a[i], b[i], b[j], a[j]]);
  quads.push([along, ...b], [along.map((v) => -v), ...a]);
  for (const [normal, ...corners] of quads) {
    for (const k of [0, 1, 2, 0, 2, 3]) rows.push(...corners[k], ...normal, ...color);
  }
}

// Two fingers that end at the contacts, the bridge between them, and the stem of the approach.
// Of a cup, both contacts are one point: its stem ends there.
function addJaws(rows, object, grasp, color) {
  const at = (array, place) => Array.from(array.subarray(3 * place, 3 * place + 3));
  const ends = [at(object.contacts, 2 * grasp), at(object.contacts, 2 * grasp + 1)];
  const approach = at(object.approaches, grasp);
  const half = THICK * object.longest;
  if (ends[0].every((value, k) => value === ends[1][k])) {
    const least = approach.map(Math.abs).reduce((best, value, k, all) => (value < all[best] ? k : best), 0);
    const aside = unit(cross(approach, [0, 1, 2].map((k) => (k === least ? 1 : 0))));
    const across = cross(approach, aside);
    const top = plus(ends[0], approach, -object.finger - STEM * object.longest);
    const thick = (direction) => direction.map((value) => value * half);
    addBar(rows, ends[0], top, thick(aside), thick(across), color);
    return;
  }
  const axis = unit(minus(ends[1], ends[0]));
  const wide = axis.map((value) => value * half);
  const deep = unit(cross(approach, axis)).map((value) => value * half);
  const back = (length) => approach.map((value) => -value * length);
  const tips = [plus(ends[0], wide, -1), plus(ends[1], wide)]; // outside, touching
  const roots = tips.map((tip) => plus(tip, back(object.finger)));
  tips.forEach((tip, k) => addBar(rows, roots[k], tip, wide, deep, color));
  const length = approach.map((value) => value * half);
  addBar(rows, plus(roots[0], wide, -1), plus(roots[1], wide), length, deep, color);
  const middle = plus(roots[0], minus(roots[1], roots[0]), 0.5);
  addBar(rows, middle, plus(middle, back(STEM * object.longest)), wide, deep, color);
}

// ---- drawing

function painter(canvas, ground = () => GROUND) {
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return null;
  const program = gl.createProgram();
  for (const [kind, text] of [[gl.VERTEX_SHADER, SHADER], [gl.FRAGMENT_SHADER, PAINT]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const layers = {};

  function layer(name, rows) {
    layers[name] ??= { buffer: gl.createBuffer() };
    layers[name].count = rows.length / 9;
    gl.bindBuffer(gl.ARRAY_BUFFER, layers[name].buffer);
    gl.bufferData(gl.ARRAY_BUFFER, rows, gl.DYNAMIC_DRAW);
  }

  function draw(object, view) {
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.round(canvas.clientWidth * scale);
    canvas.height = Math.round(canvas.clientHeight * scale);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(...ground(), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const { azimuth: a, height: h } = view;
    const right = [-Math.sin(a), Math.cos(a), 0];
    const back = [Math.cos(h) * Math.cos(a), Math.cos(h) * Math.sin(a), Math.sin(h)];
    const up = cross(back, right);
    gl.uniformMatrix3fv(uniform("turn"), false, [0, 1, 2].flatMap((k) => [right[k], up[k], back[k]]));
    gl.uniform3fv(uniform("center"), object.center);
    gl.uniform1f(uniform("size"), object.size);
    gl.uniform1f(uniform("zoom"), view.zoom);
    const least = Math.min(canvas.width, canvas.height);
    gl.uniform2f(uniform("shape"), 0.75 * least / canvas.width, 0.75 * least / canvas.height);
    for (const [name, { buffer, count }] of Object.entries(layers)) {
      gl.uniform1f(uniform("ambient"), AMBIENT[name]);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
      ["place", "normal", "color"].forEach((name, k) => {
        const where = gl.getAttribLocation(program, name);
        gl.enableVertexAttribArray(where);
        gl.vertexAttribPointer(where, 3, gl.FLOAT, false, 36, 12 * k);
      });
      gl.drawArrays(gl.TRIANGLES, 0, count);
    }
  }
  return { layer, draw };
}

// Drag, pinch, wheel and keys change the view.
function steer(canvas, view, changed) {
  const fingers = new Map();
  const zoom = (factor) => { view.zoom = Math.min(Math.max(view.zoom * factor, 0.3), 12); };
  const turn = (across, upwards) => {
    view.azimuth -= across;
    view.height = Math.min(Math.max(view.height + upwards, -Math.PI / 2), Math.PI / 2);
  };
  const spread = () => {
    const [a, b] = fingers.values();
    return Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY) || 1;
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, event);
  });
  canvas.addEventListener("pointermove", (event) => {
    const before = fingers.get(event.pointerId);
    if (!before) return;
    const distance = fingers.size === 2 ? spread() : 0;
    fingers.set(event.pointerId, event);
    if (distance) zoom(spread() / distance);
    else turn((event.clientX - before.clientX) / 120, (event.clientY - before.clientY) / 120);
    changed();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas && !event.ctrlKey) return; // the page scrolls
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 500));
    changed();
  }, { passive: false });
  const keys = {
    ArrowLeft: () => turn(-0.15, 0), ArrowRight: () => turn(0.15, 0),
    ArrowUp: () => turn(0, -0.15), ArrowDown: () => turn(0, 0.15),
    "+": () => zoom(1.15), "=": () => zoom(1.15), "-": () => zoom(1 / 1.15),
    0: () => Object.assign(view, START),
  };
  canvas.addEventListener("keydown", (event) => {
    if (!(event.key in keys) || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    keys[event.key]();
    changed();
  });
  canvas.addEventListener("dblclick", () => { keys[0](); changed(); });
}
