// Gaussians as instanced quads (WebGL2), sorted by depth, values over time from integer textures. A long clip has
// windows, each with Gaussians of its own; where two overlap, one fades into the next.

const scene = JSON.parse(document.getElementById("scene").textContent);
const canvas = document.getElementById("canvas");
const NAMES = ["means", "colors", "quats", "log_scales", "opacity_logits"], GROUND = 64 / 255;
const windows = scene.windows.map((one) => ({ ...one, tracks: NAMES.map((name) => one.tracks.find((track) => track.name === name)) }));

// Gaussians that no frame shows, drawn only from where the clip's camera is.
const hidden = new Set(scene.hidden);

function fail(text) {
  const message = document.getElementById("message");
  message.textContent = text;
  message.hidden = false;
  document.body.className = "failed";
  throw new Error(text);
}

async function unpacked() {
  const text = document.getElementById("content").textContent;
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).arrayBuffer();
}

// Of the bytes of each number: how it is read, and what stands for the high end of a track.
const KINDS = { 1: Uint8Array, 2: Uint16Array, 4: Float32Array }, TOPS = { 1: 255, 2: 65535, 4: 1 };

// The values of a track, as they are or as whole numbers, all of a Gaussian's moments one after another.
function numbers(one, buffer, kind = KINDS[one.bytes]) {
  return new kind(buffer, one.start, one.count * one.moments * one.channels);
}

// Of a number, in each channel.
const steps = (track) => track.high.map((high, c) => (high - track.low[c]) / TOPS[track.bytes]);

// What is there at a time: one window or two, each with its own time and how much of it is seen.
function present(time) {
  const within = (value) => Math.min(1, Math.max(0, value)), frame = within(time) * scene.frames;
  const from = (one) => one.shown ? one.shown[0] : one.first, to = (one) => one.shown ? one.shown[1] : one.last;
  const found = windows.filter((one) => from(one) <= frame && frame <= to(one));
  const there = found.length ? found : [windows.filter((one) => from(one) <= frame).pop() || windows[0]];
  const share = there.length < 2 ? 0 : (frame - from(there[1])) / Math.max(to(there[0]) - from(there[1]), 1e-3);
  return there.map((one, place) => ({
    ...one, time: within((frame - one.first) / (one.last - one.first + 1)),
    fade: there.length < 2 ? 1 : within(2 * (place ? share : 1 - share)),
  })).filter((one) => one.fade > 0);
}

// First control value or sample and the weights of four, as of a uniform cubic B-spline or between samples.
function taps(moments, { degree, time }) {
  if (moments === 1) return [0, [1, 0, 0, 0]];
  if (degree === 1) {
    const place = time * (moments - 1), first = Math.min(Math.floor(place), moments - 2), u = place - first;
    return [first, [1 - u, u, 0, 0]];
  }
  const segments = moments - 3, place = time * segments;
  const first = Math.min(Math.floor(place), segments - 1), u = place - first, v = 1 - u;
  return [first, [v ** 3, 3 * u ** 3 - 6 * u ** 2 + 4, 3 * v ** 3 - 6 * v ** 2 + 4, u ** 3].map((w) => w / 6)];
}

function program(gl, ...sources) {
  const made = gl.createProgram();
  [gl.VERTEX_SHADER, gl.FRAGMENT_SHADER].forEach((kind, place) => {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, sources[place]);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) fail(gl.getShaderInfoLog(shader));
    gl.attachShader(made, shader);
  });
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) fail(gl.getProgramInfoLog(made));
  return made;
}

// One value of all windows, one window after another, as wide as the widest; of floats, their bits.
function texture(gl, unit, buffer) {
  const tracks = windows.map((one) => one.tracks[unit]), { channels } = tracks[0];
  const bytes = Math.max(...tracks.map((one) => one.bytes));
  let texels = 0;
  for (const one of tracks) { one.texel = texels; texels += one.count * one.moments; }
  const rows = Math.max(1, Math.ceil(texels / WIDTH));
  if (rows > gl.getParameter(gl.MAX_TEXTURE_SIZE)) fail("This model is too large for this browser's graphics.");
  const formats = {
    1: { 3: gl.RGB8UI },
    2: { 1: gl.R16UI, 3: gl.RGB16UI, 4: gl.RGBA16UI },
    4: { 1: gl.R32UI, 3: gl.RGB32UI, 4: gl.RGBA32UI },
  };
  const [kind, type] = { 1: [Uint8Array, gl.UNSIGNED_BYTE], 2: [Uint16Array, gl.UNSIGNED_SHORT], 4: [Uint32Array, gl.UNSIGNED_INT] }[bytes];
  const format = { 1: gl.RED_INTEGER, 3: gl.RGB_INTEGER, 4: gl.RGBA_INTEGER }[channels];
  const values = new kind(rows * WIDTH * channels);
  for (const one of tracks) values.set(numbers(one, buffer, one.bytes === 4 ? kind : undefined), one.texel * channels);
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, gl.createTexture());
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
  gl.texImage2D(gl.TEXTURE_2D, 0, formats[bytes][channels], WIDTH, rows, 0, format, type, values);
  for (const name of ["MIN", "MAG"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}_FILTER`], gl.NEAREST);
}

// Rigid motions of the camera: a 3 x 3 rotation, row by row, and a shift.
const times = (a, b) => [0, 1, 2].flatMap((i) => [0, 1, 2].map((j) =>
  a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j]));
const turned = (a, v) => [0, 1, 2].map((i) => a[3 * i] * v[0] + a[3 * i + 1] * v[1] + a[3 * i + 2] * v[2]);

// The clip's frame nearest to a time.
const frameAt = (time) => Math.min(scene.frames - 1, Math.floor(time * scene.frames + 0.5));

function clipCamera(time) {
  const rows = scene.poses ? scene.poses[frameAt(time)] : scene.camera.camera_from_world;
  return { turn: [0, 1, 2].flatMap((i) => rows[i].slice(0, 3)), shift: [0, 1, 2].map((i) => rows[i][3]) };
}

// Focal lengths and principal point, in pixels.
function clipLens(time) {
  const { fx, fy, cx, cy } = scene.camera;
  return scene.lenses ? scene.lenses[frameAt(time)] : [fx, fy, cx, cy];
}

// Numbers (Float32Array) above 0, by their places in the array: the largest first, of equal ones the last. The bits
// of a positive float order as it does; they are counted 16 at a time, the low ones first.
function descending(values, places, spare) {
  const digits = new Uint16Array(values.buffer), count = places.length;
  const pass = (from, to, half, first, step) => {
    const starts = new Uint32Array(65537);
    for (let n = 0; n < count; n++) starts[65536 - digits[2 * from[n] + half]]++;
    for (let k = 0; k < 65536; k++) starts[k + 1] += starts[k];
    for (let n = 0, at = first; n < count; n++, at += step) to[starts[65535 - digits[2 * from[at] + half]]++] = from[at];
  };
  pass(places, spare, 0, count - 1, -1);
  pass(spare, places, 1, 0, 1);
}

class Viewer {
  constructor(buffer) {
    const gl = this.gl = canvas.getContext("webgl2", { antialias: false, alpha: false, preserveDrawingBuffer: true });
    if (!gl) fail("This browser does not offer WebGL2, which the 3D view needs.");
    for (const one of windows) one.means = numbers(one.tracks[0], buffer);
    this.draws = program(gl, VERTEX, FRAGMENT);
    this.averages = program(gl, WHOLE, ROWS);
    this.resolves = program(gl, WHOLE, RESOLVE);
    this.places = new Map();
    gl.useProgram(this.draws);
    NAMES.forEach((name, unit) => {
      texture(gl, unit, buffer);
      gl.uniform1i(this.at(name), unit);
    });
    const most = Math.max(...windows.map((one, place) => one.tracks[0].count + (windows[place + 1]?.tracks[0].count ?? 0)));
    this.order = new Uint32Array(most);
    this.depths = new Float32Array(most);
    this.spare = new Uint32Array(most);
    this.splats = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, this.splats);
    gl.bufferData(gl.ARRAY_BUFFER, 4 * most, gl.DYNAMIC_DRAW);
    const place = gl.getAttribLocation(this.draws, "splat");
    gl.enableVertexAttribArray(place);
    gl.vertexAttribIPointer(place, 1, gl.UNSIGNED_INT, 0, 0);
    gl.vertexAttribDivisor(place, 1);
    // Sums of many faint splats need more than 8 bits.
    this.deep = gl.getExtension("EXT_color_buffer_float") ? gl.RGBA16F : gl.RGBA8;
    gl.getExtension("EXT_float_blend");
    this.time = 0;
    this.reset();
  }

  // Of a uniform of what draws the Gaussians, asked for once.
  at(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.draws, name));
    return this.places.get(name);
  }

  // The clip's camera, and what the hand has added to it.
  get camera() {
    const { turn, shift } = clipCamera(this.time), moved = turned(this.added.turn, shift);
    return { turn: times(this.added.turn, turn), shift: moved.map((value, i) => value + this.added.shift[i]) };
  }

  // It is not where the clip's is.
  get isFree() {
    const { turn, shift } = this.added;
    return scene.free || shift.some((value) => value !== 0) || turn.some((value, i) => value !== (i % 4 ? 0 : 1));
  }

  // Depth of the middle of what the camera sees, about which a drag turns.
  pivot() {
    const seen = this.sort(present(this.time));
    return seen ? this.depths[this.order[(seen - 1) >> 1]] : 1;
  }

  // Those before the camera, far to near, of those as far the last first, as CPU and OpenGL draw; how many there are.
  sort(there) {
    const { turn, shift } = this.camera, axis = turn.slice(6, 9), { isFree } = this;
    let count = 0, seen = 0;
    for (const one of there) {
      const track = one.tracks[0], [first, weights] = taps(track.moments, one), means = one.means;
      const base = shift[2] + axis.reduce((sum, a, c) => sum + a * track.low[c], 0);
      const factors = steps(track).map((step, c) => axis[c] * step);
      for (let n = 0; n < track.count; n++) {
        let z = base;
        for (let tap = 0; tap < 4; tap++) {
          if (weights[tap] === 0) continue;
          const at = 3 * (n * track.moments + first + tap);
          z += weights[tap] * (factors[0] * means[at] + factors[1] * means[at + 1] + factors[2] * means[at + 2]);
        }
        if (z > scene.near && !(isFree && hidden.has(count))) this.order[seen++] = count;
        this.depths[count++] = z;
      }
    }
    descending(this.depths, this.order.subarray(0, seen), this.spare);
    return seen;
  }

  // Where the values of what is there lie, and which of them this time needs.
  place(there) {
    const gl = this.gl, at = (name) => this.at(name);
    const four = (list) => [...list, 0, 0, 0, 0].slice(0, 4);
    there.forEach((one, later) => {
      gl.uniform1f(at(`fades[${later}]`), one.fade);
      one.tracks.forEach((track, name) => {
        const which = 5 * later + name, [first, weights] = taps(track.moments, one);
        gl.uniform1i(at(`exact[${which}]`), track.bytes === 4 ? 1 : 0);
        gl.uniform1i(at(`start[${which}]`), track.texel);
        gl.uniform1i(at(`moments[${which}]`), track.moments);
        gl.uniform1i(at(`first[${which}]`), first);
        gl.uniform4fv(at(`weights[${which}]`), weights);
        gl.uniform4fv(at(`low[${which}]`), four(track.low));
        gl.uniform4fv(at(`span[${which}]`), four(steps(track)));
      });
    });
    gl.uniform1i(at("split"), there[0].tracks[0].count);
  }

  // `size`: pixels; none: the window's.
  draw(size) {
    const gl = this.gl, own = scene.camera, ratio = size ? 1 : window.devicePixelRatio || 1;
    const width = size ? size[0] : Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = size ? size[1] : Math.max(1, Math.round(canvas.clientHeight * ratio));
    if (canvas.width !== width || canvas.height !== height || !this.target) this.resize(width, height);
    const there = present(this.time), count = this.sort(there), { turn, shift } = this.camera;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.splats);
    gl.bufferSubData(gl.ARRAY_BUFFER, 0, this.order, 0, count);
    gl.useProgram(this.draws);
    this.place(there);
    const at = (name) => this.at(name);
    const zoom = Math.min(width / own.width, height / own.height);
    const [fx, fy, cx, cy] = clipLens(this.time);
    const lens = [fx * zoom, fy * zoom, cx * zoom + (width - own.width * zoom) / 2, cy * zoom + (height - own.height * zoom) / 2];
    const margins = [0.15 * width / lens[0], 0.15 * height / lens[1]];
    gl.uniform4fv(at("lens"), lens);
    gl.uniform4fv(at("limits"), [-lens[2] / lens[0] - margins[0], (width - lens[2]) / lens[0] + margins[0], -lens[3] / lens[1] - margins[1], (height - lens[3]) / lens[1] + margins[1]]);
    gl.uniform2fv(at("size"), [width, height]);
    gl.uniform1f(at("near"), scene.near);
    gl.uniform1i(at("antialiased"), scene.antialiased ? 1 : 0);
    const local = (sides) => sides.flatMap((side) => {
      const normal = turned(turn, side.slice(0, 3));
      return [...normal, side[3] - normal.reduce((sum, value, i) => sum + value * shift[i], 0)];
    });
    const field = this.isFree && scene.field || [];
    gl.uniform1i(at("bounded"), scene.sides ? 1 : 0);
    if (scene.sides) gl.uniform4fv(at("sides"), local(scene.sides));
    gl.uniform1i(at("corners"), field.length);
    if (field.length) gl.uniform4fv(at("field"), local(field));
    gl.uniformMatrix3fv(at("turn"), true, turn);
    gl.uniform3fv(at("shift"), shift);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.target.framebuffer);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    gl.disable(gl.BLEND);
    this.resolve(this.isFree && scene.closing ? Math.max(1, Math.round(scene.closing * zoom)) : 0);
  }

  // What is drawn onto the ground, with gaps closed over so many pixels to each side.
  resolve(closing) {
    const gl = this.gl;
    const last = [this.resolves, null], passes = closing ? [[this.averages, this.means.framebuffer], last] : [last];
    for (const [code, target] of passes) {
      const at = (name) => gl.getUniformLocation(code, name);
      gl.bindFramebuffer(gl.FRAMEBUFFER, target);
      gl.useProgram(code);
      gl.uniform1i(at("drawn"), 7);
      gl.uniform1i(at("rows"), 8);
      gl.uniform1i(at("closing"), closing);
      gl.uniform1f(at("ground"), GROUND);
      gl.drawArrays(gl.TRIANGLES, 0, 3);
    }
  }

  resize(width, height) {
    const gl = this.gl;
    [canvas.width, canvas.height] = [width, height];
    this.target = this.newTarget(this.target, 7, width, height);
    this.means = this.newTarget(this.means, 8, width, height);
  }

  // A framebuffer in place of the last one, with its image in that texture unit.
  newTarget(last, unit, width, height) {
    const gl = this.gl, target = { framebuffer: gl.createFramebuffer(), image: gl.createTexture() };
    if (last) {
      gl.deleteFramebuffer(last.framebuffer);
      gl.deleteTexture(last.image);
    }
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, target.image);
    gl.texStorage2D(gl.TEXTURE_2D, 1, this.deep, width, height);
    for (const name of ["MIN", "MAG"]) gl.texParameteri(gl.TEXTURE_2D, gl[`TEXTURE_${name}_FILTER`], gl.NEAREST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, target.framebuffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, target.image, 0);
    return target;
  }

  // About the pivot, by angles about the camera's own axes.
  orbit(across, down) {
    const [c, s, d, t] = [Math.cos(across), Math.sin(across), Math.cos(down), Math.sin(down)];
    const by = times([1, 0, 0, 0, d, -t, 0, t, d], [c, 0, s, 0, 1, 0, -s, 0, c]);
    const { turn, shift } = this.added, from = [shift[0], shift[1], shift[2] - this.middle];
    const moved = turned(by, from);
    this.added = { turn: times(by, turn), shift: [moved[0], moved[1], moved[2] + this.middle] };
  }

  pan(across, down) {
    this.added.shift[0] += across;
    this.added.shift[1] += down;
  }

  zoom(factor) {
    const nearer = this.middle * (1 - factor);
    this.middle *= factor;
    this.added.shift[2] -= nearer;
  }

  reset() {
    this.added = { turn: [1, 0, 0, 0, 1, 0, 0, 0, 1], shift: [0, 0, 0] };
    this.middle = this.pivot();
  }
}

// #still=TIME shows one moment at the size of the clip, and nothing else: for comparisons.
async function start() {
  const viewer = new Viewer(await unpacked().catch(() => fail("The model in this file is damaged.")));
  const still = /^#still=([\d.]+)$/.exec(location.hash);
  if (!still) return listen(viewer);
  document.body.className = "still";
  canvas.style.width = `${scene.camera.width}px`;
  canvas.style.height = `${scene.camera.height}px`;
  viewer.time = Number(still[1]);
  viewer.draw([scene.camera.width, scene.camera.height]);
}
start();
