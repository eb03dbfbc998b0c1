// format.js - numbers for people: four digits, SI prefixes where they help, and names of bodies.

export function number(x, digits = 4) {
  if (!Number.isFinite(x)) return "–";
  if (x === 0) return "0";
  const size = Math.abs(x);
  if (size >= 1e6 || size < 1e-4) return x.toExponential(2).replace("e+", "e");
  return String(Number(x.toPrecision(digits)));
}

const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"]];

export function withUnit(x, unit) {
  if (!Number.isFinite(x)) return `– ${unit}`;
  const size = Math.abs(x);
  if (size < 1e-9) return `0 ${unit}`;
  const [scale, prefix] = PREFIXES.find(([s]) => size >= s) ?? PREFIXES[PREFIXES.length - 1];
  return `${Number((x / scale).toPrecision(3))} ${prefix}${unit}`;
}

export function fixed(x, places) {
  const text = x.toFixed(places);
  return text.replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−");
}

export const norm = (v) => Math.hypot(v[0], v[1], v[2]);
export const vector = (v, places = 3) => v.map((x) => fixed(x, places)).join("  ");
export const bodyName = (replay, i) => (i < 0 ? "the outside" : replay.bodies[i].name || `${replay.bodies[i].shape || "body"} ${i}`);

export function bytes(n) {
  return n >= 1e6 ? `${(n / 1e6).toFixed(1)} MB` : `${Math.max(1, Math.round(n / 1e3))} kB`;
}

// The colour of a DIG, linear RGB: golden-ratio steps round the circle, as dig_colour in engine/render/batch.c.
export function digColour(dig) {
  const hue = ((0.08 + 0.61803398874989485 * dig) % 1) * 6;
  return [0, 1, 2].map((i) => {
    const d = Math.abs(((hue + 6 - 2 * i) % 6) - 3) - 1;
    const full = Math.min(1, Math.max(0, d));
    return 0.05 + 0.75 * full * full;
  });
}

// Dark violet to pale yellow, linear RGB, as heat_colour in engine/render/heat.c.
const STOPS = [[0.010, 0.006, 0.050], [0.130, 0.010, 0.210], [0.520, 0.035, 0.090], [0.930, 0.270, 0.020], [0.970, 0.920, 0.420]];
export function heatColour(share) {
  const x = 4 * Math.min(1, Math.max(0, share)), k = Math.min(3, Math.floor(x));
  return STOPS[k].map((s, i) => s + (x - k) * (STOPS[k + 1][i] - s));
}
