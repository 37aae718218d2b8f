// Contact points, and what they add up to by pair of blocks: polygons, resultants, openings.
import {LineSegments, Mesh, Points} from 'three';
import {Cracks} from './cracks.js';
import {viridis} from './data.js';
import {Layer, across, along, arrow, dot, length, minus} from './layers.js';

export const STATES = ['open', 'stick', 'slip'];
const STATE_COLOURS = [[0.75, 0.75, 0.75], [0.0, 0.45, 0.7], [0.84, 0.37, 0.0]], FAILED = [0.66, 0.16, 0.42];
const MANY = 3000;  // joints, whose arrows have three sides, and none where they are short

// Convex outline of points seen along n (Andrew's monotone chain)
function outline(points, n) {
  const [u, v] = across(n);
  const flat = points.map((p) => ({p, x: dot(p, u), y: dot(p, v)})).sort((a, b) => a.x - b.x || a.y - b.y);
  const half = (list) => {
    const chain = [];
    for (const q of list) {
      while (chain.length > 1) {
        const [a, b] = chain.slice(-2);
        if ((b.x - a.x) * (q.y - a.y) > (b.y - a.y) * (q.x - a.x)) break;
        chain.pop();
      }
      chain.push(q);
    }
    return chain.slice(0, -1);
  };
  return [...half(flat), ...half(flat.reverse())].map((q) => q.p);
}

// The joints of one kept time: contact points of a pair one after the other
function jointsOf(c, from, to) {
  const joints = [];
  for (let i = from; i < to;) {
    const a = c.pair[2 * i], b = c.pair[2 * i + 1];
    const joint = {a, b, points: [], force: [0, 0, 0], normal: [0, 0, 0], centre: [0, 0, 0], area: 0, normalForce: 0,
                   opening: 0, state: 0, failed: false, slip: 0};
    for (; i < to && c.pair[2 * i] === a && c.pair[2 * i + 1] === b; ++i) {
      const at = Array.from(c.point.subarray(3 * i, 3 * i + 3)), n = c.normal.subarray(3 * i, 3 * i + 3),
            f = c.force.subarray(3 * i, 3 * i + 3), pressing = dot(f, n);
      joint.points.push({index: i, at, force: Array.from(f), normal: Array.from(n), gap: c.gap[i], area: c.area[i],
                         slip: c.slip[i], state: c.state[i] & 3, failed: c.state[i] > 3});
      for (let k = 0; k < 3; ++k) {
        joint.force[k] += f[k]; joint.normal[k] += Math.abs(pressing) * n[k]; joint.centre[k] += pressing * at[k];
      }
      joint.normalForce += pressing; joint.area += c.area[i];
      joint.opening = Math.max(joint.opening, c.gap[i]);
      joint.slip = Math.max(joint.slip, c.slip[i]);
      joint.state = Math.max(joint.state, c.state[i] & 3);
      joint.failed = joint.failed || c.state[i] > 3;
    }
    if (length(joint.normal) === 0)  // nothing bears
      for (const p of joint.points) joint.normal = joint.normal.map((x, k) => x + p.normal[k]);
    const l = length(joint.normal) || 1, n = joint.points.length;
    joint.normal = joint.normal.map((x) => x / l);
    joint.centre = joint.normalForce > 0 ? joint.centre.map((x) => x / joint.normalForce)
        : [0, 1, 2].map((k) => joint.points.reduce((s, p) => s + p.at[k], 0) / n);
    joint.pressure = joint.normalForce > 0 ? joint.normalForce / joint.area : 0;  // infinite of an edge that bears
    joint.shear = length(along(joint.force, -dot(joint.force, joint.normal), joint.normal));
    joint.outline = outline(joint.points.map((p) => p.at), joint.normal);
    joints.push(joint);
  }
  return joints;
}

// Amber to crimson: seen on light and dark
export function forceTint(share) {
  const mix = (a, b) => a + share * (b - a);
  return [mix(0.95, 0.75), mix(0.65, 0.05), mix(0.2, 0.25), 1];
}

export class Joints {
  constructor(data, blocks, size) {
    const {head, section} = data;
    this.head = head;
    this.blocks = blocks;
    this.size = size;
    this.times = head.contactTimes;
    this.first = section('contact_first');
    this.columns = Object.fromEntries(['point', 'normal', 'force', 'gap', 'area', 'slip', 'pair', 'state'].map((n) => [n, section(`contact_${n}`)]));
    const cut = blocks.uniforms.cut;
    this.layers = {polygons: new Layer(Mesh, cut, 1, 1), lines: new Layer(LineSegments, cut, 1, 2),
                   arrows: new Layer(Mesh, cut, 1, 3), points: new Layer(Points, cut, 7, 4)};
    this.widest = {crack: null, width: 0};  // of the frame that is shown
    this.objects = Object.values(this.layers).map((layer) => layer.object);
    this.show = {polygons: false, forces: 'none', cracks: false, points: false, pressure: false};
    this.frame = 0;
    this.largest = this.high = 0;
    this.measure();
  }

  // Of all kept times: the largest resultant, N, and the pressure that one joint in fifty exceeds, Pa
  measure() {
    const {pair, force, normal, area} = this.columns, pressures = [];
    const sum = [0, 0, 0];
    let pressing = 0, all = 0;
    for (let k = 0; k < this.times.length; ++k) for (let i = this.first[k]; i < this.first[k + 1]; ++i) {
      const same = i > this.first[k] && pair[2 * i] === pair[2 * i - 2] && pair[2 * i + 1] === pair[2 * i - 1];
      if (!same) { sum.fill(0); pressing = all = 0; pressures.push(0); }
      for (let d = 0; d < 3; ++d) { sum[d] += force[3 * i + d]; pressing += force[3 * i + d] * normal[3 * i + d]; }
      all += area[i];
      this.largest = Math.max(this.largest, length(sum));
      pressures[pressures.length - 1] = pressing / all;
    }
    const sorted = Float64Array.from(pressures.filter((p) => p > 0 && p < Infinity)).sort();
    this.high = sorted.length > 0 ? sorted[Math.ceil(0.98 * sorted.length) - 1] : 0;
  }

  // The kept time nearest to a frame
  kept(frame) {
    let best = -1;
    this.times.forEach((t, k) => { if (best < 0 || Math.abs(t - frame) < Math.abs(this.times[best] - frame)) best = k; });
    return best;
  }

  // Joints of the frame, added up when they are asked for
  get list() {
    const k = this.kept(this.frame);
    if (k !== this.known) {
      this.known = k;
      this.found = k < 0 ? [] : jointsOf(this.columns, this.first[k], this.first[k + 1]);
    }
    return this.found;
  }

  update(frame) {
    const {polygons, forces, points} = this.show;
    this.frame = frame;
    for (const layer of Object.values(this.layers)) layer.clear();
    if (this.head.kind === 'pairs') this.drawPair(this.head.pairs[frame], frame);
    else if (polygons || points || forces !== 'none') this.list.forEach((joint) => this.draw(joint, this.shift(joint, frame)));
    if (this.show.cracks) this.widest = this.opened().draw(frame, this.layers.polygons, this.layers.lines);
    for (const layer of Object.values(this.layers)) layer.upload();
  }

  opened() {
    if (!this.cracks) {
      this.cracks = new Cracks(this.head, this.blocks, this.columns.pair);
      this.cracks.measure(this.head.times.length);
    }
    return this.cracks;
  }

  // Enlarged displacements take the joint along with its second block that moves
  shift(joint, frame) {
    const d = this.blocks.displacement(this.blocks.kind(joint.b, frame) < 2 ? joint.b : joint.a, frame);
    return (p) => along(p, this.blocks.scale - 1, d);
  }

  draw(joint, moved) {
    const {polygons, lines, arrows, points} = this.layers, show = this.show;
    if (show.polygons) {
      const tint = [...(joint.failed ? FAILED : STATE_COLOURS[joint.state]), 0.45];
      if (show.pressure) { viridis(joint.pressure / this.high, tint, 0); tint[3] = 0.8; }
      const o = joint.outline.map(moved);
      for (let i = 1; i + 1 < o.length; ++i) polygons.add(tint, o[0], o[i], o[i + 1]);
      o.forEach((p, i) => lines.add([...tint.slice(0, 3), 1], p, o[(i + 1) % o.length]));
    }
    if (show.forces === 'joints') this.force(arrows, moved(joint.centre), joint.force, this.largest);
    for (const p of joint.points) {
      if (show.forces === 'points') this.force(arrows, moved(p.at), p.force, this.largest);
      if (show.points) points.add([...(p.failed ? FAILED : STATE_COLOURS[p.state]), 1], moved(p.at));
    }
  }

  force(layer, at, f, largest) {
    const share = length(f) / (largest || 1);
    const many = this.list.length > MANY;
    if (share < (many ? 0.02 : 0.005)) return;
    const half = 0.06 * this.size / (largest || 1);
    arrow(layer, forceTint(share), along(at, -half, f), along(at, half, f), (0.0012 + 0.0026 * share) * this.size, many ? 3 : 6);
  }

  drawPair(pair, frame) {
    const {polygons, lines, arrows, points} = this.layers, at = (p) => minus(p, pair.offset);
    const size = length(minus(pair.high, pair.low));
    const o = (pair.polygon || []).map(at);
    for (let i = 1; i + 1 < o.length; ++i) polygons.add([0.0, 0.45, 0.7, 0.45], o[0], o[i], o[i + 1]);
    o.forEach((p, i) => lines.add([0, 0.3, 0.6, 1], p, o[(i + 1) % o.length]));
    if (pair.features) ['a', 'b'].forEach((side, s) => {
      const f = pair.features[side].vertices, corner = (v) => pair.corners[s].slice(3 * v, 3 * v + 3);
      const tint = [[0.85, 0.1, 0.1, 1], [0.5, 0.0, 0.6, 1]][s];
      const corners = f.length > 2 ? outline(f.map(corner), pair.normal) : f.map(corner);
      corners.forEach((c, i) => { points.add(tint, c); if (f.length > 1) lines.add(tint, c, corners[(i + 1) % f.length]); });
    });
    if (pair.point_a && pair.normal) {
      arrow(arrows, [0.1, 0.5, 0.2, 1], at(pair.point_a), along(at(pair.point_a), 0.25 * size, pair.normal), 0.004 * size);
      lines.add([0, 0, 0, 1], at(pair.point_a), at(pair.point_b));
      (pair.points || []).forEach((p) => points.add([0, 0.45, 0.7, 1], at(p.point_b)));
    }
  }
}
