// plots.js - curves over time on a 2D canvas, with a cursor; press or drag to seek.
import { withUnit } from "./format.js";

const PAD = { left: 58, right: 10, top: 8, bottom: 18 };

// 1, 2 or 5 times a power of ten, so that about `count` steps fill the range.
export function niceStep(range, count) {
  const rough = range / count, power = 10 ** Math.floor(Math.log10(rough)), x = rough / power;
  return (x < 1.5 ? 1 : x < 3.5 ? 2 : x < 7.5 ? 5 : 10) * power;
}

export class Plot {
  // curves: () => [{ label, colour (name of a style variable), values (one a frame), dashed }]
  constructor(canvas, legend, times, title, unit, seek) {
    Object.assign(this, { canvas, legend, times, title, unit, seek });
    const jump = (e) => {
      const box = canvas.getBoundingClientRect();
      const part = (e.clientX - box.left - PAD.left) / Math.max(1, box.width - PAD.left - PAD.right);
      seek(times[0] + Math.min(1, Math.max(0, part)) * (times[times.length - 1] - times[0]));
    };
    canvas.addEventListener("pointerdown", (e) => { canvas.setPointerCapture(e.pointerId); jump(e); });
    canvas.addEventListener("pointermove", (e) => { if (e.buttons & 1) jump(e); });
  }

  setCurves(curves, note) {
    this.curves = curves;
    this.note = note;
    let low = 0, high = 0;
    for (const { values } of curves) {
      for (const v of values) {
        if (v < low) low = v;
        if (v > high) high = v;
      }
    }
    if (!(high > low)) high = low + 1;
    this.low = low;
    this.high = high + 0.05 * (high - low);
    if (low < 0) this.low = low - 0.05 * (high - low);
    this.base = null;
  }

  point(t, v) {
    const { width, height, low, high, times } = this, from = times[0], span = times[times.length - 1] - from || 1;
    return [PAD.left + ((t - from) / span) * (width - PAD.left - PAD.right), height - PAD.bottom - ((v - low) / (high - low)) * (height - PAD.top - PAD.bottom)];
  }

  // The curves themselves, drawn once for a size and a theme.
  paintBase(style) {
    const ratio = Math.min(2, globalThis.devicePixelRatio || 1);
    this.width = this.canvas.clientWidth;
    this.height = this.canvas.clientHeight;
    this.canvas.width = Math.max(1, Math.round(this.width * ratio));
    this.canvas.height = Math.max(1, Math.round(this.height * ratio));
    this.base = document.createElement("canvas");
    this.base.width = this.canvas.width;
    this.base.height = this.canvas.height;
    const g = this.base.getContext("2d");
    g.scale(ratio, ratio);
    this.paintAxes(g, style);
    for (const curve of this.curves) this.paintCurve(g, curve, style);
    this.key = `${this.width} ${this.height}`;
  }

  paintAxes(g, style) {
    const soft = style.getPropertyValue("--soft"), line = style.getPropertyValue("--line");
    g.font = '11px system-ui, "DejaVu Sans", sans-serif';
    g.fillStyle = soft;
    g.strokeStyle = line;
    const up = niceStep(this.high - this.low, Math.max(2, this.height / 34));
    g.textAlign = "right";
    g.textBaseline = "middle";
    for (let v = Math.ceil(this.low / up) * up; v <= this.high; v += up) {
      const [, y] = this.point(this.times[0], v);
      g.beginPath();
      g.moveTo(PAD.left, Math.round(y) + 0.5);
      g.lineTo(this.width - PAD.right, Math.round(y) + 0.5);
      g.stroke();
      g.fillText(withUnit(Math.abs(v) < 1e-9 * up ? 0 : v, this.unit), PAD.left - 6, y);
    }
    const last = this.times[this.times.length - 1], span = last - this.times[0];
    g.textAlign = "center";
    g.textBaseline = "alphabetic";
    const step = span > 0 ? niceStep(span, Math.max(2, this.width / 90)) : 1;
    for (let t = Math.ceil(this.times[0] / step) * step; t <= last + 1e-9; t += step) {
      const [x] = this.point(t, this.low);
      g.fillText(`${Number(t.toPrecision(6))} s`, Math.min(x, this.width - PAD.right - 12), this.height - 4);
    }
  }

  // Frames that fall on one column of pixels become a bar from their lowest to their highest.
  paintCurve(g, { values, colour, dashed }, style) {
    g.strokeStyle = style.getPropertyValue(`--${colour}`);
    g.lineWidth = 1.5;
    g.lineJoin = "round";
    g.setLineDash(dashed ? [4, 3] : []);
    g.beginPath();
    const n = values.length, columns = Math.max(1, this.width - PAD.left - PAD.right), bundle = Math.max(1, Math.floor(n / columns / 2));
    for (let i = 0; i < n; i += bundle) {
      let low = values[i], high = values[i];
      for (let k = i + 1; k < Math.min(n, i + bundle); k++) {
        low = Math.min(low, values[k]);
        high = Math.max(high, values[k]);
      }
      g.lineTo(...this.point(this.times[i], low));
      if (high > low) g.lineTo(...this.point(this.times[i], high));
    }
    g.stroke();
  }

  draw(style, frame, t) {
    if (!this.base || this.key !== `${this.canvas.clientWidth} ${this.canvas.clientHeight}`) this.paintBase(style);
    const g = this.canvas.getContext("2d");
    g.setTransform(1, 0, 0, 1, 0, 0);
    g.clearRect(0, 0, this.canvas.width, this.canvas.height);
    g.drawImage(this.base, 0, 0);
    const ratio = this.canvas.width / Math.max(1, this.width);
    g.scale(ratio, ratio);
    const [x] = this.point(t, 0);
    g.strokeStyle = style.getPropertyValue("--accent");
    g.beginPath();
    g.moveTo(x, PAD.top);
    g.lineTo(x, this.height - PAD.bottom);
    g.stroke();
    for (const { values, colour } of this.curves) {
      g.fillStyle = style.getPropertyValue(`--${colour}`);
      g.beginPath();
      g.arc(...this.point(this.times[frame], values[frame]), 3, 0, 7);
      g.fill();
    }
    this.showLegend(frame);
  }

  showLegend(frame) {
    const parts = this.curves.map(({ label, colour, values }) => `<span style="--c:var(--${colour})">${label} ${withUnit(values[frame], this.unit)}</span>`);
    this.legend.innerHTML = `<b>${this.title}</b>${parts.join("")}${this.note ? `<span style="--c:transparent">${this.note}</span>` : ""}`;
    this.canvas.setAttribute("aria-valuetext", this.curves.map(({ label, values }) => `${label} ${withUnit(values[frame], this.unit)}`).join(", "));
  }
}

// Kinetic, potential, ... of every frame; what is nowhere in the run is left out. Potential energy counts from its lowest value.
export function energyCurves(replay) {
  const n = replay.frames, of = (i) => Float64Array.from({ length: n }, (_, f) => replay.energy[10 * f + i]);
  const rows = [["kinetic", "kinetic", 0], ["potential", "potential", 1], ["elastic", "elastic", 2], ["heat", "heat", 3], ["electric", "port", 4], ["lost", "lost", 7], ["total", "total", 9]];
  const curves = rows.map(([label, colour, i]) => ({ label, colour, values: of(i), dashed: label === "total" || label === "lost" }));
  const potential = curves[1].values, heat = curves[3].values, ground = potential.reduce((a, b) => Math.min(a, b), Infinity), cold = heat[0];
  for (let f = 0; f < n; f++) {
    potential[f] -= ground;
    heat[f] -= cold;
    curves[6].values[f] -= ground + cold;
  }
  return curves.filter(({ values, label }) => label === "kinetic" || label === "total" || values.some((v) => Math.abs(v) > 1e-12));
}

// Of the picked body: the resultant on it and the sum of its links' forces. Of no body: the sum and the largest of all contacts.
export function forceCurves(replay, body) {
  const n = replay.frames, first = new Float64Array(n), second = new Float64Array(n);
  if (body >= 0) {
    for (let f = 0; f < n; f++) {
      const k = replay.alive(body, f) ? replay.key(body, f) : -1;
      if (k >= 0) first[f] = Math.hypot(...replay.key_motion.subarray(9 * k + 6, 9 * k + 9));
    }
    for (const s of replay.spansOf[body]) {
      const span = replay.spans[s];
      if (span.layer === 0) for (let f = span.first; f <= span.last; f++) second[f] += replay.effortAt(span, f);
    }
    return [{ label: "resultant", colour: "kinetic", values: first }, { label: "links, sum", colour: "contact", values: second }];
  }
  for (const span of replay.spans) {
    if (span.layer !== 0) continue;
    for (let f = span.first; f <= span.last; f++) {
      const effort = replay.effortAt(span, f);
      first[f] += effort;
      second[f] = Math.max(second[f], effort);
    }
  }
  return [{ label: "all links", colour: "kinetic", values: first }, { label: "largest", colour: "contact", values: second }];
}
