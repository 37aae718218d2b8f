// Where the plane of a section cuts the blocks: their faces there, and outlines.
import {LineSegments, Mesh, Vector4} from 'three';
import {Layer, across, dot} from './layers.js';

export class Section {
  constructor(blocks) {
    this.blocks = blocks;
    const none = {value: new Vector4(0, 0, 0, 1)}, solid = {depthTest: true, transparent: false};
    this.faces = new Layer(Mesh, none, 1, 0, {...solid, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1});
    this.rims = new Layer(LineSegments, none, 1, 0, solid);
    this.objects = [this.faces.object, this.rims.object];
  }

  // Outlines of block b in the plane n · x = w, one of each convex part that it crosses
  outlines(b, n, w) {
    const number = this.blocks.shapeOf[b], shape = this.blocks.head.shapes[number], corners = shape.p.length / 3, at = [], height = [];
    let above = 0;
    for (let v = 0; v < corners; ++v) {
      const p = this.blocks.moved(b, shape.p[3 * v], shape.p[3 * v + 1], shape.p[3 * v + 2]);
      at.push(p);
      height.push(dot(n, p) - w);
      above += height[v] > 0;
    }
    if (above === 0 || above === corners) return [];
    return this.blocks.shapes[number].parts.map((part) => this.outline(part.map((f) => shape.f[f]), at, height, n)).filter((o) => o.length > 2);
  }

  outline(faces, at, height, n) {
    const found = [];
    for (const face of faces) face.forEach((i, k) => {
      const j = face[(k + 1) % face.length], t = height[i] / (height[i] - height[j]);
      if ((height[i] > 0) !== (height[j] > 0) && i < j) found.push(at[i].map((x, d) => x + t * (at[j][d] - x)));
    });
    const [u, v] = across(n), middle = [0, 1, 2].map((d) => found.reduce((s, p) => s + p[d], 0) / found.length);
    const angle = (p) => { const d = p.map((x, k) => x - middle[k]); return Math.atan2(dot(d, v), dot(d, u)); };
    return found.map((p) => ({p, angle: angle(p)})).sort((p, q) => p.angle - q.angle).map((e) => e.p);
  }

  // `solid`: their faces, too, not outlines alone
  update(frame, shown, solid) {
    const cut = this.blocks.uniforms.cut.value, n = [cut.x, cut.y, cut.z], values = this.blocks.values.image.data;
    this.faces.clear(); this.rims.clear();
    if (shown) for (let b = 0; b < this.blocks.count; ++b) {
      if (!this.blocks.shown(b, frame)) continue;
      const tint = [...Array.from(values.subarray(4 * b, 4 * b + 3), (x) => 0.9 * x), 1];
      for (const o of this.outlines(b, n, cut.w)) {
        for (let i = 1; solid && i + 1 < o.length; ++i) this.faces.add(tint, o[0], o[i], o[i + 1]);
        o.forEach((p, i) => this.rims.add([0.1, 0.1, 0.1, 1], p, o[(i + 1) % o.length]));
      }
    }
    this.faces.upload(); this.rims.upload();
  }
}
