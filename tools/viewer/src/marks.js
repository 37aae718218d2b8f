// Loads, motions, fixed points and monitors of a scene.
import {Mesh, Points} from 'three';
import {Layer, across, along, arrow, length, minus} from './layers.js';

export const MARK_COLOURS = {load: [0.8, 0.1, 0.15], traction: [0.85, 0.35, 0.1], 'body load': [0.75, 0.5, 0.05],
                             water: [0.1, 0.6, 0.75], motion: [0.1, 0.35, 0.8], 'fixed point': [0.1, 0.5, 0.2], monitor: [0.5, 0.1, 0.6]};

export class Marks {
  constructor(head, cut, size) {
    this.list = (head.marks || []).map((mark) => ({...mark, place: mark.at.map((x, k) => x - head.offset[k])}));
    this.size = size;
    this.solid = new Layer(Mesh, cut, 1, 5);
    this.points = new Layer(Points, cut, 9, 6);
    this.objects = [this.solid.object, this.points.object];
    const longest = {};
    for (const {kind, vector} of this.list) if (vector) longest[kind] = Math.max(longest[kind] || 0, length(vector));
    this.highest = this.list.flatMap(({rim}) => rim || []).reduce((most, corner) => Math.max(most, corner[3]), 0);
    for (const mark of this.list) this.draw(mark, longest[mark.kind], head.offset);
    this.solid.upload(); this.points.upload();
  }

  // An arrow ends where a load acts, and begins at a block that is moved; a cone stands below a point that is held.
  draw({kind, place, vector, rim}, longest, offset) {
    const tint = [...MARK_COLOURS[kind], 1], thick = 0.003 * this.size;
    if (kind === 'monitor') this.points.add(tint, place);
    if (kind === 'fixed point') this.cone(tint, place);
    if (rim) this.water(rim, offset, vector.map((x) => -x / length(vector)));
    if (!vector) return;
    const arm = 0.03 + 0.09 * length(vector) / longest, d = vector.map((x) => x * arm * this.size / length(vector));
    if (kind === 'motion') arrow(this.solid, tint, place, along(place, 1, d), thick);
    else arrow(this.solid, tint, along(place, -1, d), place, thick);
  }

  // Translucent, as high above its face as the pressure is there
  water(rim, offset, outwards) {
    const foot = rim.map((c) => minus(c, offset)), top = foot.map((p, i) => along(p, 0.12 * this.size * rim[i][3] / this.highest, outwards));
    const tint = [...MARK_COLOURS.water, 0.3], at = (list) => [0, 1, 2].map((k) => list.reduce((sum, p) => sum + p[k], 0) / list.length);
    const middle = at(top);
    foot.forEach((p, i) => {
      const j = (i + 1) % foot.length;
      this.solid.add(tint, p, foot[j], top[j], p, top[j], top[i], middle, top[i], top[j]);
    });
  }

  cone(tint, tip) {
    const [u, v] = across([0, 0, 1]), r = 0.012 * this.size, foot = along(tip, -2 * r, [0, 0, 1]);
    const rim = (i) => along(along(foot, r * Math.cos(i * Math.PI / 4), u), r * Math.sin(i * Math.PI / 4), v);
    for (let i = 0; i < 8; ++i) {
      const shade = [...tint.slice(0, 3).map((x) => x * (0.8 + 0.2 * Math.cos(i * Math.PI / 4))), 1];
      this.solid.add(shade, tip, rim(i), rim(i + 1));
    }
  }

  show(on) { for (const layer of [this.solid, this.points]) layer.object.visible = on && layer.count > 0; }
}
