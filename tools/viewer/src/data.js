// The data of the page: a JSON head, and binary sections (base64 of a deflated buffer) that it names.
export const get = (id) => document.getElementById(id);

const TYPES = {i2: Int16Array, u2: Uint16Array, f4: Float32Array, u4: Uint32Array, u1: Uint8Array};

async function inflated(element) {
  const text = element.textContent;
  let raw;
  if (Uint8Array.fromBase64) {
    raw = Uint8Array.fromBase64(text);
  } else {
    const s = atob(text);
    raw = new Uint8Array(s.length);
    for (let i = 0; i < s.length; ++i) raw[i] = s.charCodeAt(i);
  }
  element.remove();
  const stream = new Blob([raw]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).arrayBuffer();
}

// {head, section(name)}; a section that is not there is undefined
export async function readData() {
  const head = JSON.parse(get('head').textContent);
  const buffer = await inflated(get('data'));
  const section = (name) => {
    const s = head.sections[name];
    return s && new TYPES[s.type](buffer, s.at, s.count);
  };
  return {head, section};
}

// Four significant digits, as a person writes them.
export function number(x) {
  if (!Number.isFinite(x)) return '–';
  return x !== 0 && (Math.abs(x) < 1e-3 || Math.abs(x) >= 1e6) ? x.toExponential(3) : String(+x.toPrecision(4));
}
export const vector = (v) => `(${Array.from(v, number).join(', ')})`;

// N with a prefix
export function newtons(x) {
  const k = x >= 1e6 ? [1e6, 'MN'] : x >= 1e3 ? [1e3, 'kN'] : [1, 'N'];
  return `${number(x / k[0])} ${k[1]}`;
}

// viridis, nine stops
const STOPS = [[68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141], [39, 173, 129],
               [92, 200, 99], [170, 220, 50], [253, 231, 37]];
export function viridis(t, out, at) {
  const x = Math.min(1, Math.max(0, t)) * 8, i = Math.min(7, Math.floor(x)), f = x - i;
  for (let k = 0; k < 3; ++k) out[at + k] = ((1 - f) * STOPS[i][k] + f * STOPS[i + 1][k]) / 255;
}
