// Joints that have opened: where faces of two blocks lay on each other at the start, how far they are apart now.
import {FIXED} from './blocks.js';
import {cross, dot, length, minus} from './layers.js';

const APART = 1e-3;  // of a block's size: faces no farther from each other lie on each other

// Faces of a block at the start: corners, outward normal
function facesOf(head, blocks, b) {
  const shape = head.shapes[blocks.shapeOf[b]], o = blocks.origin.subarray(3 * b, 3 * b + 3);
  return shape.f.map((face, f) => ({
    corners: face.map((v) => [0, 1, 2].map((k) => shape.p[3 * v + k] + o[k])),
    normal: blocks.shapes[blocks.shapeOf[b]].planes.slice(4 * f, 4 * f + 3)}));
}

// The part of polygon p inside the convex polygon q, both about the normal n [Sutherland & Hodgman 1974]
function clipped(p, q, n) {
  q.forEach((from, i) => {
    const out = cross(minus(q[(i + 1) % q.length], from), n), height = p.map((c) => dot(minus(c, from), out));
    p = p.flatMap((c, k) => {
      const m = (k + 1) % p.length, kept = height[k] <= 0 ? [c] : [];
      if (height[k] * height[m] < 0) kept.push(c.map((x, d) => x + height[k] / (height[k] - height[m]) * (p[m][d] - x)));
      return kept;
    });
  });
  return p;
}

function area(p, n) {
  let sum = 0;
  for (let i = 1; i + 1 < p.length; ++i) sum += dot(cross(minus(p[i], p[0]), minus(p[i + 1], p[0])), n) / 2;
  return sum;
}

export class Cracks {
  // `pairs`: two numbers of blocks for each contact point of the run
  constructor(head, blocks, pairs) {
    this.blocks = blocks;
    this.list = [];
    this.of = new Map();
    const known = new Map(), faces = (b) => known.get(b) ?? known.set(b, facesOf(head, blocks, b)).get(b);
    const first = new Set();
    for (let i = 0; i < pairs.length; i += 2) {
      const key = pairs[i] * head.blocks + pairs[i + 1];
      if (first.has(key)) continue;
      first.add(key);
      this.add(pairs[i], pairs[i + 1], faces(pairs[i]), faces(pairs[i + 1]), key);
    }
  }

  add(a, b, facesA, facesB, key) {
    for (const f of facesA) for (const g of facesB) {
      if (dot(f.normal, g.normal) > -0.9999) continue;
      const size = length(minus(f.corners[0], f.corners[1]));
      if (Math.abs(dot(minus(g.corners[0], f.corners[0]), f.normal)) > APART * size) continue;
      const outline = clipped(f.corners, g.corners.slice().reverse(), f.normal);
      if (outline.length < 3 || area(outline, f.normal) < APART * size * size) continue;
      const o = this.blocks.origin, own = (c) => (p) => p.map((x, k) => x - o[3 * c + k]);
      const crack = {a, b, normal: f.normal, ofA: outline.map(own(a)), ofB: outline.map(own(b))};
      this.list.push(crack);
      this.of.set(key, [...(this.of.get(key) || []), crack]);
    }
  }

  // Of each corner of the outline, m; not enlarged. `m`: the maps of all blocks, as they stand
  widths({a, b, normal, ofA, ofB}, m) {
    const n = [0, 0, 0];
    for (let i = 0; i < 3; ++i) for (let j = 0; j < 3; ++j) n[i] += m[12 * a + 4 * i + j] * normal[j];
    const size = length(n), found = [];
    for (let k = 0; k < ofA.length; ++k) {
      let apart = 0;
      for (let i = 0; i < 3; ++i) {
        const p = 12 * a + 4 * i, q = 12 * b + 4 * i, x = ofA[k], y = ofB[k];
        apart += n[i] * (m[q] * y[0] + m[q + 1] * y[1] + m[q + 2] * y[2] + m[q + 3] - m[p] * x[0] - m[p + 1] * x[1] - m[p + 2] * x[2] - m[p + 3]);
      }
      found.push(apart / size);
    }
    return found;
  }

  // The widest of all frames, m; and widths that 16 bits of a displacement can't tell from none
  measure(frames) {
    if (this.widest !== undefined) return;
    const {u, r} = this.blocks.head.motion;
    let reach = 0;
    this.blocks.shapeOf.forEach((s, b) => { if (this.blocks.kind(b, 0) < FIXED) reach = Math.max(reach, this.blocks.shapes[s].reach); });
    this.least = 4 * (u + r * reach);
    this.widest = 0;
    const maps = new Float32Array(12 * this.blocks.count);
    for (let f = 0; f < frames; ++f) {
      this.blocks.mapsAt(f, 1, maps);
      for (const crack of this.list) for (const width of this.widths(crack, maps)) if (width > this.widest) this.widest = width;
    }
  }

  // Faces and rim of what is open, in the colour of its width. {crack, width} of the widest of this frame
  draw(frame, faces, lines) {
    const maps = this.blocks.mapsAt(frame, 1), {moved} = this.blocks;
    let most = {crack: null, width: 0};
    for (const crack of this.list) {
      const widths = this.widths(crack, maps), width = Math.max(...widths);
      if (width < this.least || !this.blocks.shown(crack.a, frame) || !this.blocks.shown(crack.b, frame)) continue;
      if (width > most.width) most = {crack, width};
      const tint = (w) => { const t = Math.sqrt(Math.max(0, w) / this.widest); return [0.98 - 0.2 * t, 0.8 * (1 - t) + 0.02, 0.1, 0.6]; };
      const ends = [crack.ofA.map((p) => moved.call(this.blocks, crack.a, ...p)), crack.ofB.map((p) => moved.call(this.blocks, crack.b, ...p))];
      for (let i = 0; i < widths.length; ++i) {
        const j = (i + 1) % widths.length, [p, q, s, t] = [ends[0][i], ends[0][j], ends[1][j], ends[1][i]];
        faces.addEach([tint(widths[i]), tint(widths[j]), tint(widths[j])], p, q, s);
        faces.addEach([tint(widths[i]), tint(widths[j]), tint(widths[i])], p, s, t);
        if (i > 0 && i + 1 < widths.length) faces.addEach([tint(widths[0]), tint(widths[i]), tint(widths[j])], ends[0][0], ends[0][i], ends[0][i + 1]);
        for (const end of ends) lines.add([...tint(Math.max(widths[i], widths[j])).slice(0, 3), 1], end[i], end[j]);
      }
    }
    return most;
  }
}
