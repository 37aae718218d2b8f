// One page that shows a run, a scene or pairs of quoin. No network, no module loader.
import {PerspectiveCamera, Scene, Vector3, WebGLRenderer} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {Blocks, FIXED, RIGID} from './blocks.js';
import {Marks, MARK_COLOURS} from './marks.js';
import {Section} from './section.js';
import {Ties} from './ties.js';
import {get, newtons, number, readData, vector, viridis} from './data.js';
import {Joints, STATES} from './joints.js';
import {length} from './layers.js';
import {Histories} from './plots.js';

const FREE = [[0.80, 0.48, 0.33], [0.88, 0.70, 0.44], [0.44, 0.58, 0.68], [0.58, 0.66, 0.48], [0.72, 0.45, 0.46], [0.54, 0.51, 0.66]];
const HELD = [0.76, 0.75, 0.73];
const JOINT_STATES = [[0.62, 0.62, 0.62], [0.30, 0.58, 0.78], [0.90, 0.50, 0.15], [0.66, 0.16, 0.42]];
const KINDS = [[0.84, 0.68, 0.47], [0.66, 0.72, 0.78], [0.45, 0.46, 0.48], [0.40, 0.52, 0.80]], COMPLAINED = [0.91, 0.40, 0.34];
const JOINT_STATE_NAMES = [...STATES, 'failed'], MOST_SWATCHES = 12;
const FRAMES_A_SECOND = 15;
const KIND_NAMES = ['deformable', 'rigid', 'fixed', 'prescribed', 'absent'];

class Viewer {
  constructor(data) {
    this.data = data;
    this.head = data.head;
    this.frames = this.head.times.length;
    this.blocks = new Blocks(data);
    this.group = data.section('group');
    this.state = {frame: 0, picked: -1, joint: null, point: null, mark: null, drawn: 0};
    this.ranges = {};
    this.complained = new Set(this.head.kind === 'scene' ? this.head.notes.flatMap((note) => note.blocks.filter((b) => this.blocks.kind(b, 0) < FIXED)) : []);
    this.light = matchMedia('(prefers-color-scheme: dark)');
    this.makeScene();
    this.joints = new Joints(data, this.blocks, this.size);
    this.marks = new Marks(this.head, this.blocks.uniforms.cut, this.size);
    this.section = new Section(this.blocks);
    this.ties = new Ties(data, this.blocks, this.size);
    this.scene.add(...this.joints.objects, ...this.ties.objects, ...this.marks.objects, ...this.section.objects);
    this.histories = new Histories(this.head, (time) => this.show(this.nearest(time)));
    this.fillPanel();
    this.listen();
  }

  makeScene() {
    this.renderer = new WebGLRenderer({canvas: get('canvas'), antialias: true});
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.scene = new Scene();
    this.scene.add(this.blocks.faces);
    this.camera = new PerspectiveCamera(30, 1, 1, 10);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.addEventListener('change', () => this.redraw());
    this.controls.addEventListener('start', () => { this.held = true; });
    this.frameBox(this.head.low, this.head.high);
  }

  frameBox(low, high) {
    this.low = new Vector3(...low);
    this.high = new Vector3(...high);
    this.middle = this.low.clone().add(this.high).multiplyScalar(0.5);
    this.size = this.high.clone().sub(this.low).length() || 1;
    this.camera.far = this.size * 20;
    this.controls.target.copy(this.middle);
  }

  home(direction = [-0.45, -1, 0.42]) {
    this.from = direction;
    this.held = false;
    const back = new Vector3(...direction).normalize(), right = new Vector3(0, 0, 1).cross(back).normalize(), up = back.clone().cross(right);
    const tan = Math.tan(this.camera.fov * Math.PI / 360) / (this.marks.list.length > 0 ? 1.25 : 1.08), ends = [this.low, this.high];
    const away = Math.max(...Array.from({length: 8}, (_, i) => new Vector3(ends[i & 1].x, ends[i >> 1 & 1].y, ends[i >> 2].z).sub(this.middle)).map(
        (c) => c.dot(back) + Math.max(Math.abs(c.dot(up)), Math.abs(c.dot(right)) / this.camera.aspect) / tan));
    this.controls.target.copy(this.middle);
    this.camera.position.copy(back.multiplyScalar(away || 1).add(this.middle));
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.redraw();
  }

  // ---- colours
  scalar(name, b, f) {
    if (name === 'displacement') return length(this.blocks.displacement(b, f));
    if (name === 'pressure') return this.pressures[b];
    const {low, high} = this.head.scalars[name];
    return low + this.data.section(name)[f * this.blocks.count + b] * (high - low) / 65535;
  }

  unknown(name, b) { return name === 'compression' && this.blocks.kind(b, this.state.frame) === RIGID; }

  unit(name) { return {displacement: 'm', pressure: 'Pa'}[name] || this.head.scalars[name].unit; }

  range(name) {
    if (this.ranges[name]) return this.ranges[name];
    let high = 0, low = 0;
    if (name === 'pressure') high = this.joints.high;
    else if (name !== 'displacement') ({low, high} = this.head.scalars[name]);
    else for (let f = 0; f < this.frames; ++f) for (let b = 0; b < this.blocks.count; ++b) {
      if (this.blocks.kind(b, f) < FIXED) high = Math.max(high, this.scalar(name, b, f));
    }
    return (this.ranges[name] = [low, high > low ? high : low + 1]);
  }

  // The worst state of the joints of each block: 0 open, 1 stick, 2 slip, 3 failed
  jointStates() {
    const worst = new Int8Array(this.blocks.count);
    for (const j of this.joints.list) for (const b of [j.a, j.b]) worst[b] = Math.max(worst[b], j.failed ? 3 : j.state);
    return worst;
  }

  // The largest mean pressure on the joints of each block, Pa
  jointPressures() {
    const most = new Float64Array(this.blocks.count);
    for (const j of this.joints.list) for (const b of [j.a, j.b]) most[b] = Math.max(most[b], j.pressure);
    return most;
  }

  colouring() {
    const name = get('colour').value, f = this.state.frame, put = (c, out, at) => { for (let k = 0; k < 3; ++k) out[at + k] = c[k]; };
    if (name === 'group') return (b, out, at) => put(FREE[this.group[b] % FREE.length], out, at);
    const held = (b) => this.blocks.kind(b, f) >= FIXED || this.unknown(name, b);
    if (name === 'block') return (b, out, at) => put(held(b) ? HELD : FREE[b % FREE.length], out, at);
    if (name === 'kind') return (b, out, at) => put(this.complained.has(b) ? COMPLAINED : KINDS[this.blocks.kind(b, f)] || HELD, out, at);
    if (name === 'joint') {
      const worst = this.jointStates();
      return (b, out, at) => put(held(b) ? HELD : JOINT_STATES[worst[b]], out, at);
    }
    const [low, high] = this.range(name);
    if (name === 'pressure') this.pressures = this.jointPressures();
    return (b, out, at) => {
      if (held(b)) put(HELD, out, at); else viridis((this.scalar(name, b, f) - low) / (high - low), out, at);
    };
  }

  // Of what stands for a colour, where colours are few
  swatches(name) {
    if (name === 'group') return this.head.groups.map((group, i) => [FREE[i % FREE.length], group]);
    if (name === 'joint') return JOINT_STATE_NAMES.map((state, i) => [JOINT_STATES[i], state]);
    if (name !== 'kind') return [];
    const there = new Set();
    for (let b = 0; b < this.blocks.count; ++b) there.add(this.blocks.kind(b, this.state.frame));
    return [...KINDS.map((colour, i) => [colour, KIND_NAMES[i]]).filter((_, i) => there.has(i)),
            ...(this.complained.size > 0 ? [[COMPLAINED, 'see the notes']] : [])];
  }

  paint() {
    this.blocks.paint(this.state.frame, this.state.picked, this.colouring());
    this.changed = true;
    get('swatches').replaceChildren(...[...this.swatches(get('colour').value).slice(0, MOST_SWATCHES), ...this.markSwatches()].map(([colour, name]) => {
      const entry = Object.assign(document.createElement('span'), {textContent: name}), box = document.createElement('i');
      box.style.background = `rgb(${colour.map((x) => Math.round(255 * x))})`;
      entry.prepend(box);
      return entry;
    }));
    const name = get('colour').value, ranged = ['displacement', 'pressure'].includes(name) || name in this.head.scalars;
    get('legend').hidden = !ranged;
    if (ranged) {
      const [low, high] = this.range(name);
      get('legend-low').textContent = number(low);
      get('legend-high').textContent = `${name === 'pressure' ? '≥ ' : ''}${number(high)} ${this.unit(name)}`;
    }
  }

  markSwatches() {
    if (!get('marks').checked) return [];
    const kinds = [...new Set(this.marks.list.map((mark) => mark.kind))];
    return kinds.map((kind) => [MARK_COLOURS[kind], kind]);
  }

  // ---- time
  nearest(time) {
    let best = 0;
    this.head.times.forEach((t, i) => { if (Math.abs(t - time) <= Math.abs(this.head.times[best] - time)) best = i; });
    return best;
  }

  show(f) {
    this.state.frame = f;
    this.state.joint = this.state.point = this.state.mark = null;
    get('time').value = f;
    const label = this.head.labels[f];
    get('time-value').textContent = this.head.kind === 'pairs' ? `${f + 1} of ${this.frames}: ${label}` : `t = ${number(this.head.times[f])} s`;
    get('stage').textContent = this.head.kind === 'pairs' ? '' : label;
    if (this.head.kind === 'pairs') {
      const pair = this.head.pairs[f];
      this.frameBox(pair.low, pair.high);
      this.home([1, -1.6, 0.7]);
    }
    this.blocks.place(f);
    this.joints.update(f);
    this.ties.update(f);
    this.paint();
    const kept = this.joints.kept(f);
    get('kept').textContent = kept >= 0 && this.joints.times[kept] !== f ? `Contacts of t = ${number(this.head.times[this.joints.times[kept]])} s` : '';
    this.histories.show(this.head.times[f]);
    this.tellCracks();
    this.tell();
    this.redraw();
  }

  step(by) { this.show((this.state.frame + by + this.frames) % this.frames); }

  play() {
    if (this.playing) { clearInterval(this.playing); this.playing = null; }
    else this.playing = setInterval(() => this.step(1), 1000 / FRAMES_A_SECOND);
    get('play').textContent = this.playing ? '❚❚' : '▶';
  }

  // ---- picking
  ray(px, py) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const x = 2 * (px - box.left) / box.width - 1, y = 1 - 2 * (py - box.top) / box.height;
    const near = new Vector3(x, y, -1).unproject(this.camera), far = new Vector3(x, y, 1).unproject(this.camera);
    return [near.toArray(), far.sub(near).toArray()];
  }

  pick(px, py) { return this.blocks.pick(...this.ray(px, py), this.state.frame); }

  onPage(place) {
    const p = new Vector3(...place).project(this.camera), box = this.renderer.domElement.getBoundingClientRect();
    return [box.left + (p.x + 1) / 2 * box.width, box.top + (1 - p.y) / 2 * box.height];
  }

  // What of the list lies nearest to a place of the page, within 14 pixels
  closest(list, place, px, py) {
    let best = null, least = 14;
    for (const entry of list) {
      const [x, y] = this.onPage(place(entry)), far = Math.hypot(x - px, y - py);
      if (far < least) { least = far; best = entry; }
    }
    return best;
  }

  click(px, py) {
    const {show, list} = this.joints, moved = (j) => this.joints.shift(j, this.state.frame);
    this.state.joint = this.state.point = null;
    if (show.points || show.forces === 'points') {
      const all = list.flatMap((joint) => joint.points.map((point) => ({joint, point})));
      const found = this.closest(all, ({joint, point}) => moved(joint)(point.at), px, py);
      if (found) ({joint: this.state.joint, point: this.state.point} = found);
    } else if (show.forces === 'joints' || show.polygons || show.cracks) {
      this.state.joint = this.closest(list, (j) => moved(j)(j.centre), px, py);
    }
    this.state.mark = this.closest([...(get('marks').checked ? this.marks.list : []), ...this.ties.list], (mark) => mark.place, px, py);
    this.state.picked = this.state.joint || this.state.mark ? -1 : this.pick(px, py);
    this.state.part = this.blocks.part;
    this.paint(); this.tell(); this.redraw();
  }

  rowsOfBlock(b) {
    const {frame: f, part} = this.state, u = this.blocks.displacement(b, f), parts = this.blocks.shapes[this.blocks.shapeOf[b]].parts.length;
    const rows = [['block', `${b} · ${KIND_NAMES[this.blocks.kind(b, f)]} · ${this.head.groups[this.group[b]]}`],
                  ...(parts > 1 && part >= 0 ? [['convex part', `${part + 1} of ${parts}`]] : []),
                  ['displacement', `${number(length(u))} m`], ['u', `${vector(u)} m`]];
    for (const name of Object.keys(this.head.scalars).filter((s) => !this.unknown(s, b))) rows.push([name, `${number(this.scalar(name, b, f))} ${this.unit(name)}`]);
    const own = this.joints.list.filter((j) => j.a === b || j.b === b);
    rows.push(['joints', String(own.length)]);
    const most = (of) => own.reduce((m, j) => Math.max(m, of(j)), 0), force = most((j) => length(j.force));
    if (force > 0) rows.push(['largest joint force', newtons(force)], ['largest joint pressure', `${number(most((j) => j.pressure))} Pa`]);
    return rows;
  }

  rowsOfJoint(j) {
    const n = this.head.names;
    return [['joint', `${n[j.a]} – ${n[j.b]}`], ['state', (j.failed ? 'failed, ' : '') + STATES[j.state]],
            ['resultant on the second', newtons(length(j.force))], ['normal, shear', `${newtons(j.normalForce)}, ${newtons(j.shear)}`],
            ['area', `${number(j.area)} m²`], ['mean pressure', `${number(j.pressure)} Pa`],
            ['opening', `${number(this.openingOf(j))} m`], ['slip', `${number(j.slip)} m`], ['points', String(j.points.length)]];
  }

  // The widest that it gapes, m: of faces that lay on each other at the start, else of the contact points
  openingOf(j) {
    if (!this.joints.show.cracks) return Math.max(0, j.opening);
    const cracks = this.joints.opened(), maps = this.blocks.mapsAt(this.state.frame, 1);
    const own = cracks.of.get(j.a * this.blocks.count + j.b) || [];
    return Math.max(0, j.opening, ...own.flatMap((crack) => cracks.widths(crack, maps)));
  }

  rowsOfMark(mark) {
    if (mark.reach) return [['force', newtons(mark.force)], ['length', `${number(mark.reach)} m`]];
    const size = mark.vector ? [['largest', `${number(length(mark.vector))} ${mark.unit}`], ['vector', `${vector(mark.vector)} ${mark.unit}`]] : [];
    return [['block', mark.block], ['at', `${vector(mark.at)} m`], ...size];
  }

  rowsOfPoint(p) {
    const o = this.head.offset;
    return [['contact point', vector(p.at.map((x, k) => x + o[k])) + ' m'], ['point state', (p.failed ? 'failed, ' : '') + STATES[p.state]],
            ['force', newtons(length(p.force))], ['gap', `${number(p.gap)} m`], ['area share', `${number(p.area)} m²`]];
  }

  rowsOfPair(p) {
    if (p.error) return [['error', p.error]];
    const feature = (f) => `${f.kind} ${f.vertices.join(' ')}`;
    return [['status', p.status], ['type', p.type], ['gap', `${p.gap} m`], ['normal', vector(p.normal)],
            ['feature of A', feature(p.features.a)], ['feature of B', feature(p.features.b)],
            ['contact points', String(p.points.length)], ['area', `${number(p.area)} m²`], ['indeterminate', String(p.indeterminate)],
            ['certificate', `residuals ${number(p.certificate.residual_a)}, ${number(p.certificate.residual_b)} m`],
            ['iterations', String(p.iterations)]];
  }

  tell() {
    const {picked, joint, point, mark} = this.state;
    let title = 'Click a block, a force or a contact.', rows = [];
    if (this.head.kind === 'pairs') { title = this.head.labels[this.state.frame]; rows = this.rowsOfPair(this.head.pairs[this.state.frame]); }
    else if (joint) { title = 'Joint'; rows = [...(point ? this.rowsOfPoint(point) : []), ...this.rowsOfJoint(joint)]; }
    else if (mark) { title = mark.kind || mark.name; rows = this.rowsOfMark(mark); }
    else if (picked >= 0) { title = this.head.names[picked] || `block ${picked}`; rows = this.rowsOfBlock(picked); }
    get('picked-title').textContent = title;
    get('picked').replaceChildren(...rows.map(([key, value]) => {
      const row = document.createElement('tr'), k = document.createElement('th'), v = document.createElement('td');
      k.textContent = key; v.textContent = value;
      row.append(k, v);
      return row;
    }));
  }

  // ---- drawing
  draw() {
    if (this.changed) this.section.update(this.state.frame, get('axis').value !== '', !get('glass').checked);
    this.changed = false;
    // Depth is told apart the better the farther its near end is
    this.camera.near = Math.max(this.size / 5000, 0.5 * this.blocks.distance(this.camera.position.toArray(), this.state.frame));
    this.camera.updateProjectionMatrix();
    this.renderer.setClearColor(this.light.matches ? 0x15181c : 0xf5f6f8);
    this.blocks.uniforms.eye.value.copy(this.camera.position);
    this.renderer.render(this.scene, this.camera);
    this.state.drawn += 1;
  }

  redraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => { this.asked = false; this.draw(); });
  }

  cut() {
    const k = 'xyz'.indexOf(get('axis').value), t = +get('cut').value / 1000, v = this.blocks.uniforms.cut.value;
    if (get('axis').value === '') v.set(0, 0, 0, 1);
    else {
      const a = [0, 0, 0], sign = this.camera.position.getComponent(k) < this.middle.getComponent(k) ? -1 : 1;
      a[k] = sign;  // the side of the eye is taken away
      v.set(...a, sign * (this.low.getComponent(k) + t * (this.high.getComponent(k) - this.low.getComponent(k))));
    }
    this.changed = true;
    this.redraw();
  }

  // ---- the page
  fillPanel() {
    const {head} = this;
    get('title').textContent = document.title = head.title;
    get('facts').textContent = [head.kind === 'pairs' ? `${this.frames} pairs` : `${head.blocks} block${head.blocks > 1 ? 's' : ''}`, ...(head.facts || [])].join(', ');
    get('notes').replaceChildren(...head.notes.map((note) => this.noteLine(note)));
    get('time').max = this.frames - 1;
    get('bar').hidden = this.frames < 2;
    const colours = {block: 'block', group: head.kind === 'pairs' ? 'A and B' : 'material', joint: 'joint state', kind: 'kind', displacement: 'displacement'};
    if (head.kind === 'pairs') { delete colours.joint; delete colours.kind; delete colours.displacement; get('contact-panel').hidden = get('scale-row').hidden = true; }
    if (this.joints.high > 0) colours.pressure = 'joint pressure';
    Object.entries(colours).forEach(([value, name]) => get('colour').add(new Option(name, value)));
    Object.keys(head.scalars).forEach((name) => get('colour').add(new Option(name, name)));
    if (head.kind === 'pairs') { get('colour').value = 'group'; this.glass(true); }
    get('mark-row').hidden = this.marks.list.length === 0;
    get('marks').checked = this.marks.list.length > 0;
    if (head.kind === 'scene') get('colour').value = 'kind';
    get('largest').textContent = [['longest arrow', this.joints.largest], ['largest tie force', this.ties.largest]]
        .filter(([, force]) => force > 0).map(([what, force]) => `${what}: ${newtons(force)}`).join('; ');
  }

  // What a run or `quoin check` says of blocks: a click picks the first of them
  noteLine({text, blocks = []}) {
    const line = Object.assign(document.createElement('li'), {textContent: text});
    if (blocks.length > 0) {
      line.tabIndex = 0;
      line.addEventListener('click', () => {
        this.state.joint = this.state.point = this.state.mark = null;
        this.state.picked = blocks[0]; this.state.part = -1;
        this.paint(); this.tell(); this.redraw();
      });
    }
    return line;
  }

  tellCracks() {
    const {show, widest, cracks} = this.joints;
    const {crack, width} = widest, names = this.head.names;
    get('widest').textContent = !show.cracks ? '' : !crack ? 'no crack'
        : `widest crack: ${number(width)} m, ${names[crack.a]} – ${names[crack.b]}; of the run: ${number(cracks.widest)} m`;
  }

  glass(on) {
    get('glass').checked = on;
    this.blocks.uniforms.glass.value = on ? 1 : 0;
    this.changed = true;
    this.redraw();
  }

  contacts() {
    const show = this.joints.show;
    show.forces = get('forces').value;
    for (const name of ['polygons', 'cracks', 'points']) show[name] = get(name).checked;
    this.joints.update(this.state.frame);
    this.tellCracks();
    this.glass(show.forces !== 'none' || show.polygons || show.cracks || show.points);
  }

  listen() {
    const on = (id, event, act) => get(id).addEventListener(event, act);
    on('time', 'input', () => this.show(+get('time').value));
    on('play', 'click', () => this.play());
    on('home', 'click', () => this.home());
    on('colour', 'change', () => {
      this.joints.show.pressure = get('colour').value === 'pressure';
      this.joints.update(this.state.frame); this.paint(); this.redraw();
    });
    on('edges', 'change', () => { this.blocks.uniforms.edge.value = get('edges').checked ? 1 : 0; this.redraw(); });
    on('glass', 'change', () => this.glass(get('glass').checked));
    for (const id of ['forces', 'polygons', 'cracks', 'points']) on(id, 'change', () => this.contacts());
    for (const id of ['axis', 'cut']) on(id, 'input', () => this.cut());
    on('scale', 'input', () => {
      this.blocks.scale = 10 ** +get('scale').value;
      get('scale-value').textContent = `× ${number(this.blocks.scale)}`;
      this.blocks.place(this.state.frame); this.joints.update(this.state.frame); this.ties.update(this.state.frame); this.changed = true; this.redraw();
    });
    on('marks', 'change', () => { this.marks.show(get('marks').checked); this.paint(); this.redraw(); });
    let down = null;  // where one finger or button went down; null: moved, or there are two
    const canvas = this.renderer.domElement, far = (e) => Math.hypot(e.clientX - down[0], e.clientY - down[1]);
    canvas.addEventListener('pointerdown', (e) => { down = e.isPrimary ? [e.clientX, e.clientY] : null; });
    canvas.addEventListener('pointerup', (e) => {
      if (down && far(e) < (e.pointerType === 'touch' ? 12 : 5)) this.click(e.clientX, e.clientY);
      down = null;
    });
    addEventListener('keydown', (e) => this.key(e));
    this.light.addEventListener('change', () => { this.histories.plot(); this.redraw(); });
    new ResizeObserver(() => { this.fit(); this.draw(); this.histories.fit(); }).observe(get('view'));
  }

  key(event) {
    if (event.target.matches('select, input[type=range]') || event.ctrlKey || event.metaKey || event.altKey) return;
    const views = {1: [-0.45, -1, 0.42], 2: [0, -1, 0], 3: [1, 0, 0], 4: [0, -0.001, 1]};
    const tick = (id) => { get(id).checked = !get(id).checked; get(id).dispatchEvent(new Event('change')); };
    const keys = {ArrowRight: () => this.step(1), ArrowLeft: () => this.step(-1), Home: () => this.show(0),
                  End: () => this.show(this.frames - 1), ' ': () => this.play(), h: () => this.home(),
                  e: () => tick('edges'), g: () => tick('glass'), p: () => tick('polygons'), c: () => tick('cracks'),
                  f: () => { get('forces').value = get('forces').value === 'none' ? 'joints' : 'none'; this.contacts(); },
                  Escape: () => { this.state.picked = -1; this.state.joint = this.state.mark = null; this.paint(); this.tell(); this.redraw(); }};
    const act = views[event.key] ? () => this.home(views[event.key]) : keys[event.key];
    if (!act) return;
    event.preventDefault();
    act();
  }

  fit() {
    const box = get('view').getBoundingClientRect(), aspect = box.width / box.height;
    const turned = Math.abs(aspect - this.camera.aspect) > 0.2;
    this.renderer.setSize(box.width, box.height, false);
    this.camera.aspect = aspect;
    this.camera.updateProjectionMatrix();
    if (turned || !this.held) this.home(this.from); else this.redraw();
  }
}

async function start() {
  const viewer = new Viewer(await readData());
  viewer.fit();
  viewer.home();
  viewer.show(0);
  viewer.draw();
  window.quoin = viewer;  // for tests
  document.documentElement.dataset.ready = 'yes';
}

start().catch((error) => { get('title').textContent = `This page can't be shown: ${error.message}`; console.error(error); });
