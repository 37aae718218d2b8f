// All blocks in one buffer: a vertex knows its block, the block's 3 × 4 map stands in a texture.
import {BufferAttribute, BufferGeometry, DataTexture, FloatType, FrontSide, GLSL3, Mesh, NearestFilter,
        RGBAFormat, RawShaderMaterial, Vector3, Vector4} from 'three';

const ROW = 1024;  // blocks a row of the textures
const HIDDEN = -1, PICKED = 2;
export const ABSENT = 4, FIXED = 2, RIGID = 1;

// Faces of each convex part of a shape, by number: parts share no corner.
function partsOf(shape) {
  const root = shape.p.map((_, v) => v), top = (v) => { while (root[v] !== v) v = root[v]; return v; };
  for (const face of shape.f) for (const v of face) root[top(v)] = top(face[0]);
  const parts = new Map();
  shape.f.forEach((face, f) => { const r = top(face[0]); parts.set(r, [...(parts.get(r) || []), f]); });
  return [...parts.values()];
}

// Corners, normals and rims of the triangles of a shape, and the planes of its faces. `rim`: distance from each
// side of the triangle, 0 … 1; a side inside a polygon is lifted by 1, and so never drawn.
function triangles(shape) {
  const p = [], n = [], rim = [], planes = [];
  shape.f.forEach((f) => {
    const c = f.map((v) => shape.p.slice(3 * v, 3 * v + 3)), m = [0, 0, 0];
    for (let i = 1; i + 1 < c.length; ++i) {
      const a = c[i].map((x, k) => x - c[0][k]), b = c[i + 1].map((x, k) => x - c[0][k]);
      m[0] += a[1] * b[2] - a[2] * b[1]; m[1] += a[2] * b[0] - a[0] * b[2]; m[2] += a[0] * b[1] - a[1] * b[0];
    }
    const l = Math.hypot(...m) || 1;
    m.forEach((x, k) => { m[k] = x / l; });
    for (let i = 1; i + 1 < c.length; ++i) {
      const lift = [0, i + 2 < c.length ? 1 : 0, i > 1 ? 1 : 0];  // sides against corners 0, i, i + 1
      [0, i, i + 1].forEach((v, k) => {
        p.push(...c[v]); n.push(...m);
        for (let q = 0; q < 3; ++q) rim.push((q === k ? 1 : 0) + lift[q]);
      });
    }
    planes.push(...m, m[0] * c[0][0] + m[1] * c[0][1] + m[2] * c[0][2]);
  });
  const parts = partsOf(shape);
  const ends = (of) => [0, 1, 2].map((i) => of(...shape.p.filter((_, k) => k % 3 === i)));
  return {p: new Float32Array(p), n, rim, planes, parts, planesOf: parts.map((part) => part.flatMap((f) => planes.slice(4 * f, 4 * f + 4))), low: ends(Math.min), high: ends(Math.max), reach: Math.max(...shape.p.map(Math.abs))};
}

function geometryOf(shapes, shapeOf) {
  let count = 0;
  shapeOf.forEach((s) => { count += shapes[s].p.length / 3; });
  const position = new Float32Array(3 * count), normal = new Int8Array(4 * count), rim = new Uint8Array(4 * count),
        block = new Float32Array(count);
  let v = 0;
  shapeOf.forEach((s, b) => {
    const shape = shapes[s], own = shape.p.length / 3;
    position.set(shape.p, 3 * v);
    block.fill(b, v, v + own);
    for (let k = 0; k < own; ++k) for (let x = 0; x < 3; ++x) {
      normal[4 * (v + k) + x] = Math.round(127 * shape.n[3 * k + x]);
      rim[4 * (v + k) + x] = shape.rim[3 * k + x];
    }
    v += own;
  });
  const faces = new BufferGeometry();
  faces.setAttribute('position', new BufferAttribute(position, 3));
  faces.setAttribute('normal', new BufferAttribute(normal, 4, true));
  faces.setAttribute('rim', new BufferAttribute(rim, 4));
  faces.setAttribute('block', new BufferAttribute(block, 1));
  return faces;
}

const PLACE = `
precision highp float; precision highp sampler2D;
uniform mat4 viewMatrix, projectionMatrix; uniform sampler2D maps, values;
in vec3 position, normal, rim; in float block;
out vec3 place, border; flat out vec3 side; flat out vec4 value;
void main() {
  int b = int(block + 0.5), r = b / ${ROW}, c = b - r * ${ROW};
  vec4 x = texelFetch(maps, ivec2(3 * c, r), 0), y = texelFetch(maps, ivec2(3 * c + 1, r), 0),
       z = texelFetch(maps, ivec2(3 * c + 2, r), 0);
  vec4 p = vec4(position, 1.0);
  place = vec3(dot(x, p), dot(y, p), dot(z, p));
  side = vec3(dot(x.xyz, normal), dot(y.xyz, normal), dot(z.xyz, normal));
  border = rim;
  value = texelFetch(values, ivec2(c, r), 0);
  gl_Position = projectionMatrix * viewMatrix * vec4(place, 1.0);
  if (value.a < 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
}`;
const FACE = `
precision highp float; in vec3 place, border; flat in vec3 side; flat in vec4 value; out vec4 colour;
uniform vec4 cut; uniform vec3 light, eye; uniform float edge, glass;
void main() {
  if (dot(cut.xyz, place) > cut.w) discard;
  vec3 change = max(fwidth(border), 1e-9), far = border / change;  // pixels from each side
  float fade = smoothstep(3.0, 14.0, 1.0 / max(change.x, max(change.y, change.z)));  // small faces are not all edge
  float line = edge * fade * (1.0 - smoothstep(0.4, 1.4, min(far.x, min(far.y, far.z))));
  if (glass > 0.5) {  // every other pixel, so that what is inside is seen
    if (line < 0.5 && mod(floor(gl_FragCoord.x) + floor(gl_FragCoord.y), 2.0) > 0.5) discard;
  }
  vec3 n = normalize(side);
  float shade = 0.52 + 0.34 * max(0.0, dot(n, light)) + 0.14 * max(0.0, dot(n, normalize(eye - place)));
  bool chosen = value.a > 1.5;
  vec3 stone = value.rgb * shade;
  if (chosen) stone = 0.45 * stone + 0.55 * vec3(1.0, 0.85, 0.25) * shade;
  colour = vec4(mix(stone, chosen ? vec3(0.8, 0.1, 0.05) : vec3(0.1), line * 0.85), 1.0);
}`;

// row: nine numbers of R (I + E), by the rotation vector x y z and the strain
function linear(x, y, z, e, r) {
  const angle = Math.hypot(x, y, z);
  r.fill(0);
  r[0] = r[4] = r[8] = 1;
  if (angle > 0) {
    const c = Math.cos(angle), p = Math.sin(angle) / angle, q = (1 - c) / (angle * angle);
    r[0] = c + q * x * x; r[1] = q * x * y - p * z; r[2] = q * x * z + p * y;
    r[3] = q * x * y + p * z; r[4] = c + q * y * y; r[5] = q * y * z - p * x;
    r[6] = q * x * z - p * y; r[7] = q * y * z + p * x; r[8] = c + q * z * z;
  }
  if (!e) return;
  const E = [e[0], e[3], e[5], e[3], e[1], e[4], e[5], e[4], e[2]];
  for (let i = 0; i < 9; i += 3) {
    const [a, b, c] = [r[i], r[i + 1], r[i + 2]];
    for (let j = 0; j < 3; ++j) r[i + j] = a * (j === 0) + b * (j === 1) + c * (j === 2) + a * E[j] + b * E[3 + j] + c * E[6 + j];
  }
}

export class Blocks {
  constructor(data) {
    const {head, section} = data;
    this.head = head;
    this.count = head.blocks;
    this.shapeOf = section('shape');
    this.kinds = section('kind');
    this.origin = section('origin');
    this.motion = section('motion');
    this.shapes = head.shapes.map(triangles);
    this.scale = 1;
    const rows = Math.ceil(this.count / ROW);
    const texture = (width) => {
      const t = new DataTexture(new Float32Array(4 * width * rows), width, rows, RGBAFormat, FloatType);
      t.minFilter = t.magFilter = NearestFilter;
      return t;
    };
    this.maps = texture(3 * ROW);
    this.values = texture(ROW);
    this.uniforms = {maps: {value: this.maps}, values: {value: this.values}, cut: {value: new Vector4(0, 0, 0, 1)},
                     light: {value: new Vector3(-0.45, -0.6, 0.9).normalize()}, eye: {value: new Vector3()},
                     edge: {value: 1}, glass: {value: 0}};
    this.faces = new Mesh(geometryOf(this.shapes, this.shapeOf), new RawShaderMaterial({
      glslVersion: GLSL3, vertexShader: PLACE, fragmentShader: FACE, uniforms: this.uniforms, side: FrontSide,
      polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 2}));
    this.faces.frustumCulled = false;
  }

  kind(b, frame) { return this.kinds[this.kinds.length > this.count ? frame * this.count + b : b]; }

  shown(b, frame) {
    return this.head.kind === 'pairs' ? b >> 1 === frame : this.kind(b, frame) !== ABSENT;
  }

  displacement(b, frame) {
    const {per, u} = this.head.motion;
    const at = this.head.kind === 'pairs' ? b * per : (frame * this.count + b) * per;
    return [u * this.motion[at], u * this.motion[at + 1], u * this.motion[at + 2]];
  }

  place(frame) {
    this.mapsAt(frame, this.scale, this.maps.image.data);
    this.maps.needsUpdate = true;
  }

  // 3 × 4 map of every block: I + s (A - I) about the block's origin
  mapsAt(frame, s, m = new Float32Array(12 * this.count)) {
    const {per, u, r, e} = this.head.motion, q = this.motion, o = this.origin;
    const a = new Float64Array(9), strain = new Float64Array(6);
    const first = this.head.kind === 'pairs' ? 0 : frame * this.count;
    for (let b = 0; b < this.count; ++b) {
      const at = (first + b) * per, to = 12 * b;
      if (per === 12) for (let k = 0; k < 6; ++k) strain[k] = e * q[at + 6 + k];
      linear(r * q[at + 3], r * q[at + 4], r * q[at + 5], per === 12 ? strain : null, a);
      for (let i = 0; i < 3; ++i) {
        for (let j = 0; j < 3; ++j) m[to + 4 * i + j] = (i === j) + s * (a[3 * i + j] - (i === j));
        m[to + 4 * i + 3] = o[3 * b + i] + s * u * q[at + i];
      }
    }
    return m;
  }

  // `colour(b, out, at)` writes three numbers
  paint(frame, picked, colour) {
    const out = this.values.image.data;
    for (let b = 0; b < this.count; ++b) {
      colour(b, out, 4 * b);
      out[4 * b + 3] = !this.shown(b, frame) ? HIDDEN : b === picked ? PICKED : 1;
    }
    this.values.needsUpdate = true;
  }

  // From a point to the nearest box about a block along its own axes: at most the distance to the block, as long as it is
  // not strained
  distance(p, frame) {
    const m = this.maps.image.data;
    let least = Infinity;
    for (let b = 0; b < this.count; ++b) {
      if (!this.shown(b, frame)) continue;
      const {low, high} = this.shapes[this.shapeOf[b]], k = 12 * b;
      const x = p[0] - m[k + 3], y = p[1] - m[k + 7], z = p[2] - m[k + 11];
      let squared = 0;
      for (let i = 0; i < 3; ++i) {
        const own = m[k + i] * x + m[k + 4 + i] * y + m[k + 8 + i] * z;
        squared += Math.max(0, low[i] - own, own - high[i]) ** 2;
      }
      least = Math.min(least, squared);
    }
    return Math.sqrt(least);
  }

  // The place of a point given in a block's own coordinates
  moved(b, x, y, z) {
    const m = this.maps.image.data, k = 12 * b;
    return [0, 4, 8].map((i) => m[k + i] * x + m[k + i + 1] * y + m[k + i + 2] * z + m[k + i + 3]);
  }

  // The first block on the ray o + t d, 0 <= t <= 1, and which convex part of it (`part`): against the face planes of each, in its own coordinates.
  pick(o, d, frame) {
    const m = this.maps.image.data, cut = this.uniforms.cut.value;
    let from = 0, to = 1, best = 1, found = -1;
    const along = cut.x * d[0] + cut.y * d[1] + cut.z * d[2], rest = cut.w - (cut.x * o[0] + cut.y * o[1] + cut.z * o[2]);
    if (along > 0) to = Math.min(to, rest / along);
    else if (along < 0) from = Math.max(from, rest / along);
    else if (rest < 0) return -1;
    for (let b = 0; b < this.count; ++b) {
      if (!this.shown(b, frame)) continue;
      const k = 12 * b;
      const a = m[k], e = m[k + 1], g = m[k + 2], h = m[k + 4], i = m[k + 5], j = m[k + 6], p = m[k + 8], q = m[k + 9], r = m[k + 10];
      const c0 = i * r - j * q, c1 = j * p - h * r, c2 = h * q - i * p, det = a * c0 + e * c1 + g * c2;
      if (det === 0) continue;
      const c = [c0, g * q - e * r, e * j - g * i, c1, a * r - g * p, g * h - a * j, c2, e * p - a * q, a * i - e * h];
      const t0 = o[0] - m[k + 3], t1 = o[1] - m[k + 7], t2 = o[2] - m[k + 11];
      const O0 = (c[0] * t0 + c[1] * t1 + c[2] * t2) / det, O1 = (c[3] * t0 + c[4] * t1 + c[5] * t2) / det,
            O2 = (c[6] * t0 + c[7] * t1 + c[8] * t2) / det;
      const D0 = (c[0] * d[0] + c[1] * d[1] + c[2] * d[2]) / det, D1 = (c[3] * d[0] + c[4] * d[1] + c[5] * d[2]) / det,
            D2 = (c[6] * d[0] + c[7] * d[1] + c[8] * d[2]) / det;
      for (const [part, planes] of this.shapes[this.shapeOf[b]].planesOf.entries()) {
        let enter = from, leave = Math.min(to, best);
        for (let w = 0; w < planes.length && enter <= leave; w += 4) {
          const s = planes[w] * D0 + planes[w + 1] * D1 + planes[w + 2] * D2;
          const l = planes[w + 3] - (planes[w] * O0 + planes[w + 1] * O1 + planes[w + 2] * O2);
          if (s > 0) leave = Math.min(leave, l / s);
          else if (s < 0) enter = Math.max(enter, l / s);
          else if (l < 0) leave = -1;
        }
        if (enter <= leave && enter < best) { best = enter; found = b; this.part = part; }
      }
    }
    return found;
  }
}
