// Ties: rods in the colour of their force; slack ones grey, broken ones gone.
import {Mesh} from 'three';
import {forceTint} from './joints.js';
import {Layer, arrow, length, minus} from './layers.js';

const SLACK = [0.55, 0.55, 0.55, 1], PRESSED = [0.1, 0.4, 0.8, 1];

export class Ties {
  constructor({head, section}, blocks, size) {
    this.head = head;
    this.blocks = blocks;
    this.size = size;
    [this.ends, this.force, this.broken, this.first] = ['ends', 'force', 'broken', 'first'].map((n) => section(`tie_${n}`));
    this.layer = new Layer(Mesh, blocks.uniforms.cut, 1, 2);
    this.objects = [this.layer.object];
    this.largest = (this.force || []).reduce((most, f) => Math.max(most, Math.abs(f)), 0);
    this.list = [];
  }

  // Enlarged displacements move the ends, where the ties are those of the start
  update(frame) {
    this.list = [];
    this.layer.clear();
    const own = this.first ? this.first[frame + 1] - this.first[frame] : 0, same = own > 0 && own === this.first[1];
    for (let i = 0; i < own; ++i) {
      const at = this.first[frame] + i, force = this.force[at];
      const [p, q] = [0, 3].map((k) => Array.from(this.ends.subarray(6 * at + k, 6 * at + k + 3), (x, d) => {
        const start = same ? this.ends[6 * i + k + d] : x;
        return start + this.blocks.scale * (x - start);
      }));
      if (this.broken[at]) continue;
      const reach = length(minus(this.ends.subarray(6 * at + 3, 6 * at + 6), this.ends.subarray(6 * at, 6 * at + 3)));
      this.list.push({name: this.head.ties[i] || `tie ${i}`, force, reach, place: p.map((x, k) => (x + q[k]) / 2)});
      const tint = force > 0 ? forceTint(force / this.largest) : force < 0 ? PRESSED : SLACK;
      arrow(this.layer, tint, p, q, 0.0025 * this.size, 6, false);
    }
    this.layer.upload();
  }
}
