// Vectors, and what is drawn over the blocks: coloured triangles, lines and points.
import {BufferAttribute, BufferGeometry, DoubleSide, GLSL3, RawShaderMaterial} from 'three';

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
export const along = (a, t, d) => [a[0] + t * d[0], a[1] + t * d[1], a[2] + t * d[2]];
export const length = (a) => Math.hypot(...a);
export function across(n) {  // two unit vectors at right angles to n
  const x = Math.abs(n[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0], a = cross(n, x), l = length(a) || 1;
  const u = a.map((v) => v / l);
  return [u, cross(n, u)];
}

const FLAT = {
  glslVersion: GLSL3, depthTest: false, transparent: true, side: DoubleSide,
  vertexShader: `precision highp float; uniform mat4 viewMatrix, projectionMatrix; uniform vec4 cut; uniform float size;
    in vec3 position; in vec4 tint; out vec4 shown; out vec3 place;
    void main() { shown = tint; place = position; gl_PointSize = size;
      gl_Position = projectionMatrix * viewMatrix * vec4(position, 1.0); }`,
  fragmentShader: `precision highp float; uniform vec4 cut; uniform float size; in vec4 shown; in vec3 place; out vec4 colour;
    void main() { if (dot(cut.xyz, place) > cut.w) discard;
      if (size > 1.0 && length(gl_PointCoord - 0.5) > 0.5) discard;
      colour = shown; }`};

export class Layer {  // coloured triangles, lines or points that are made anew
  constructor(Kind, cut, size, order, more = {}) {
    this.object = new Kind(new BufferGeometry(), new RawShaderMaterial({...FLAT, ...more, uniforms: {cut, size: {value: size}}}));
    this.object.frustumCulled = false;
    this.object.visible = false;
    this.object.renderOrder = order;
    this.clear();
  }
  clear() {
    this.count = 0;  // corners
    this.places = new Float32Array(3 * 1024);
    this.tints = new Float32Array(4 * 1024);
  }
  add(tint, ...corners) {
    if (3 * (this.count + corners.length) > this.places.length) {
      const [places, tints] = [this.places, this.tints];
      (this.places = new Float32Array(2 * places.length)).set(places);
      (this.tints = new Float32Array(2 * tints.length)).set(tints);
    }
    for (const corner of corners) {
      this.places.set(corner, 3 * this.count);
      this.tints.set(tint, 4 * this.count++);
    }
  }
  addEach(tints, ...corners) { corners.forEach((corner, i) => this.add(tints[i], corner)); }
  upload() {
    this.object.geometry.dispose();
    this.object.geometry = new BufferGeometry();
    this.object.geometry.setAttribute('position', new BufferAttribute(this.places.subarray(0, 3 * this.count), 3));
    this.object.geometry.setAttribute('tint', new BufferAttribute(this.tints.subarray(0, 4 * this.count), 4));
    this.object.visible = this.count > 0;
  }
}

// Without `headed`, a rod
export function arrow(layer, tint, from, to, thick, sides = 6, headed = true) {
  const d = minus(to, from), l = length(d);
  if (!(l > 0)) return;
  const n = d.map((x) => x / l), [u, v] = across(n), head = headed ? Math.min(0.45 * l, 5 * thick) : 0, neck = along(to, -head, n);
  const ring = (at, r) => Array.from({length: sides}, (_, i) => {
    const t = 2 * Math.PI * i / sides;
    return along(along(at, r * Math.cos(t), u), r * Math.sin(t), v);
  });
  const a = ring(from, thick), b = ring(neck, thick), c = ring(neck, 2.2 * thick);
  for (let i = 0; i < sides; ++i) {
    const j = (i + 1) % sides, shade = 0.8 + 0.2 * Math.cos(2 * Math.PI * i / sides), t = [...tint.slice(0, 3).map((x) => x * shade), tint[3]];
    layer.add(t, a[i], a[j], b[j], a[i], b[j], b[i], c[i], c[j], to);
  }
}
