// Histories beside the scene, their cursor tied to the time that is shown.
import uPlot from 'uplot';
import {get} from './data.js';

const WIDTH = () => Math.max(200, get('panel').clientWidth - 24);

export class Histories {
  // `go(time)`: a click on the plot
  constructor(head, go) {
    this.table = head.history;
    this.names = Object.keys(this.table).filter((name) => name !== 'time' && name !== 'step');
    this.still = this.names.length > 0 && Math.max(...this.table.time) === Math.min(...this.table.time);
    this.x = this.still ? this.table.step : this.table.time;
    this.go = go;
    this.now = 0;
    const select = get('column');
    this.names.forEach((name) => select.add(new Option(name, name)));
    if (this.names.includes('kinetic')) select.value = 'kinetic';
    get('histories').hidden = this.names.length === 0;
    select.addEventListener('change', () => this.plot());
    this.plot();
  }

  plot() {
    this.chart?.destroy();
    if (this.names.length === 0) return;
    const name = get('column').value, ink = getComputedStyle(document.body).color;
    const axis = {stroke: ink, grid: {stroke: '#8884', width: 1}, ticks: {stroke: '#8884', width: 1}};
    this.chart = new uPlot({
      width: WIDTH(), height: 170, cursor: {drag: {x: false, y: false}}, legend: {show: false}, scales: {x: {time: false}},
      axes: [{...axis, label: this.still ? 'step' : 't, s', labelSize: 16, size: 30},
             {...axis, size: 66, values: (_, list) => list.map((v) => (Math.abs(v) >= 1e6 ? v.toExponential(1) : String(+v.toPrecision(6))))}],
      series: [{}, {stroke: '#2c8fb0', width: 1.6, points: {show: this.x.length < 3}}],
      hooks: {draw: [(u) => this.drawNow(u)], ready: [(u) => {
        u.over.addEventListener('click', () => { if (u.cursor.idx != null && !this.still) this.go(this.x[u.cursor.idx]); });
      }]},
    }, [this.x, this.table[name]], get('history'));
    this.tell();
  }

  drawNow(u) {
    if (this.still) return;
    const x = u.valToPos(this.now, 'x', true);
    u.ctx.strokeStyle = '#c0392b';
    u.ctx.beginPath();
    u.ctx.moveTo(x, u.bbox.top);
    u.ctx.lineTo(x, u.bbox.top + u.bbox.height);
    u.ctx.stroke();
  }

  tell() {
    if (this.names.length === 0) return;
    let best = 0;
    this.x.forEach((t, i) => { if (Math.abs(t - this.now) < Math.abs(this.x[best] - this.now)) best = i; });
    if (this.still) best = this.x.length - 1;
    get('column-value').textContent = String(+this.table[get('column').value][best].toPrecision(5));
  }

  show(time) {
    this.now = time;
    this.chart?.redraw(false);
    this.tell();
  }

  fit() { this.chart?.setSize({width: WIDTH(), height: 170}); }
}
