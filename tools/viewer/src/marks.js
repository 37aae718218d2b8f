// Loads, motions, fixed points and monitors of a scene.
import {Mesh, Points} from 'three';
import {Layer, across, along, arrow, length} from './layers.js';

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
    for (const mark of this.list) this.draw(mark, longest[mark.kind]);
    this.solid.upload(); this.points.upload();
  }

  // An arrow ends where a load acts, and begins at a block that is moved; a cone stands below a point that is held.
  draw({kind, place, vector}, longest) {
    const tint = [...MARK_COLOURS[kind], 1], thick = 0.003 * this.size;
    if (kind === 'monitor') this.points.add(tint, place);
    if (kind === 'fixed point') this.cone(tint, place);
    if (!vector) return;
    const arm = 0.03 + 0.09 * length(vector) / longest, d = vector.map((x) => x * arm * this.size / length(vector));
    if (kind === 'motion') arrow(this.solid, tint, place, along(place, 1, d), thick);
    else arrow(this.solid, tint, along(place, -1, d), place, thick);
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
