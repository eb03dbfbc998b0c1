// data.js - what engine/export/html.c wrote: a JSON header and one packed block of arrays. Reading only; nothing here draws.

const KINDS = { f64: Float64Array, f32: Float32Array, u32: Uint32Array };

export function decodeBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

// One column of a part (engine/export/html_pack.c) into every width-th place of `out`, which are floats or integers of 32 bits.
function readColumn(bytes, from, rows, order, step, out, first, width) {
  const words = order < 0 ? new Uint32Array(out.buffer) : out;
  let before = 0, slope = 0;
  for (let i = 0, at = first; i < rows; i++, at += width) {
    let x = bytes[from + i] | (bytes[from + rows + i] << 8) | (bytes[from + 2 * rows + i] << 16) | (bytes[from + 3 * rows + i] << 24);
    if (order >= 0) {
      x = (x >>> 1) ^ -(x & 1);
      if (order > 1) x = slope = (slope + x) | 0;
      if (order > 0) x = before = (before + x) | 0;
    }
    words[at] = order < 0 ? x : x * step;
  }
}

// An array of a section: [kind, first byte, rows, [[columns, order, step], ...]].
function readSection(bytes, [kind, offset, rows, parts]) {
  const width = parts.reduce((sum, [columns]) => sum + columns, 0), out = new KINDS[kind](rows * width), size = out.BYTES_PER_ELEMENT;
  let from = offset, column = 0;
  for (const [columns, order, step] of parts) {
    for (let k = 0; k < columns; k++, column++, from += size * rows) {
      if (size === 4) {
        readColumn(bytes, from, rows, order, step, out, column, width);
        continue;
      }
      const to = new Uint8Array(out.buffer);
      for (let byte = 0; byte < 8; byte++) for (let i = 0; i < rows; i++) to[8 * (i * width + column) + byte] = bytes[from + byte * rows + i];
    }
  }
  return out;
}

// The last of `keys[first .. first + count - 1]` (rising) that is not above `wanted`; first when all are above.
export function lastNotAbove(keys, first, count, wanted) {
  let low = first, high = first + count - 1;
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (keys[middle] <= wanted) low = middle;
    else high = middle - 1;
  }
  return low;
}

// Rotates v by the unit quaternion q (x y z w).
export function rotate(q, v) {
  const [x, y, z, w] = q;
  const tx = 2 * (y * v[2] - z * v[1]), ty = 2 * (z * v[0] - x * v[2]), tz = 2 * (x * v[1] - y * v[0]);
  return [v[0] + w * tx + y * tz - z * ty, v[1] + w * ty + z * tx - x * tz, v[2] + w * tz + x * ty - y * tx];
}

export class Replay {
  constructor(head, bytes) {
    Object.assign(this, head);                      // title, frames, bodies, meshes, shapes, events, ...
    this.head = head;
    for (const [name, section] of Object.entries(head.sections)) {      // an array is made when it is asked for
      Object.defineProperty(this, name, { configurable: true, get() {
        const value = readSection(bytes, section);
        Object.defineProperty(this, name, { value });
        return value;
      } });
    }
    this.start = this.times[0];
    this.end = this.times[this.frames - 1];
    this.readLinks();
    this.events = Array.from({ length: this.rows("event") }, (_, i) => {
      const [frame, time, kind, a, b, speed, impulse, dig, otherDig, link, layer, stress] = this.event.subarray(12 * i, 12 * i + 12);
      return { frame, time, kind: head.event_kinds[kind], a, b, speed, impulse, dig, otherDig, link: head.link_kinds[link], layer, stress };
    });
  }

  // Rows of a section; 0 when there is none.
  rows(name) { return this.head.sections[name]?.[2] ?? 0; }

  // A link holds over a span of frames; its efforts (N, or the layer's unit) stand one after the other.
  readLinks() {
    const n = this.link.length / 6;
    this.spans = [];
    let effort = 0, end = 0;
    for (let i = 0; i < n; i++) {
      const [a, b, kind, where, first, count] = this.link.subarray(6 * i, 6 * i + 6);
      const bound = where > 255;
      this.spans.push({ a, b, kind, layer: where & 255, bound, first, last: first + count - 1, effort, end: bound ? end : -1 });
      effort += count;
      if (bound) end += 3 * count;
    }
    this.spansOf = this.bodies.map(() => []);
    this.spans.forEach((s, i) => {
      this.spansOf[s.a]?.push(i);
      if (s.b !== s.a) this.spansOf[s.b]?.push(i);
    });
    // which spans begin and end at a frame: moving on by a frame touches only those
    this.spansAtCache = { frame: -1, list: [] };
  }

  spansAt(frame) {
    if (this.spansAtCache.frame !== frame) {
      this.spansAtCache = { frame, list: this.spans.filter((s) => s.first <= frame && frame <= s.last) };
    }
    return this.spansAtCache.list;
  }

  effortAt(span, frame) { return this.effort[span.effort + frame - span.first]; }
  endAt(span, frame) {
    const at = span.end + 3 * (frame - span.first);
    return [this.link_end[at], this.link_end[at + 1], this.link_end[at + 2]];
  }

  // Frame before or at t, and how far t is on the way to the next one, 0 .. 1.
  locate(t) {
    const frame = lastNotAbove(this.times, 0, this.frames, t);
    if (t <= this.times[frame] || frame + 1 >= this.frames) return { frame, part: 0 };
    return { frame, part: Math.min(1, (t - this.times[frame]) / (this.times[frame + 1] - this.times[frame])) };
  }

  alive(body, frame) { return this.bodies[body].born <= frame && frame < this.bodies[body].died; }

  // Index into the keys: a key holds until the next one of its body.
  key(body, frame) {
    const [first, count] = this.bodies[body].keys;
    return count ? lastNotAbove(this.key_frame, first, count, frame) : -1;
  }

  // Position of the body's origin (relative to `place`) and rotation into out[0..6]; false when it is not there.
  pose(body, frame, part, out) {
    if (!this.alive(body, frame)) return false;
    const k = this.key(body, frame);
    if (k < 0) return false;
    const from = this.key_pose.subarray(7 * k, 7 * k + 7);
    for (let i = 0; i < 7; i++) out[i] = from[i];
    if (!(part > 0) || !this.alive(body, frame + 1)) return true;
    const l = this.key(body, frame + 1);
    if (l === k) return true;
    const to = this.key_pose.subarray(7 * l, 7 * l + 7);
    let dot = 0;
    for (let i = 3; i < 7; i++) dot += from[i] * to[i];
    const side = dot < 0 ? -1 : 1;                  // q and -q are one rotation: take the near one
    let length = 0;
    for (let i = 0; i < 7; i++) out[i] = from[i] + part * ((i < 3 ? 1 : side) * to[i] - from[i]);
    for (let i = 3; i < 7; i++) length += out[i] * out[i];
    length = Math.sqrt(length) || 1;
    for (let i = 3; i < 7; i++) out[i] /= length;
    return true;
  }

  // All that is known of a body at a frame, in the world's coordinates.
  state(body, frame, part = 0) {
    const p = new Float64Array(7);
    const about = this.bodies[body];
    if (!this.pose(body, frame, part, p)) return { name: about.name, there: false };
    const k = this.key(body, frame);
    const rotation = [...p.subarray(3, 7)];
    const position = [p[0] + this.place[0], p[1] + this.place[1], p[2] + this.place[2]];
    const centre = rotate(rotation, about.centre);
    const m = this.key_motion.subarray(9 * k, 9 * k + 9);
    return {
      name: about.name, there: true, position, rotation, centre: centre.map((c, i) => c + position[i]),
      velocity: [...m.subarray(0, 3)], spin: [...m.subarray(3, 6)], force: [...m.subarray(6, 9)],
      dig: this.key_dig[k], awake: (this.key_flags[k] & 1) === 1, mode: this.modes[this.key_flags[k] >> 1],
      temperature: this.key_temperature ? this.key_temperature[k] : 0,
    };
  }

  // What the script says of a camera at a frame: at, look_at, up (null: not said), fov; null when it is not there yet.
  cameraAt(number, frame) {
    const rows = this.moment("camera", frame).subarray(11 * number, 11 * number + 11);
    if (rows.length < 11) return null;
    const vector = (bit, from) => (rows[0] & bit ? [...rows.subarray(from, from + 3)] : null);
    return { at: vector(1, 1), look_at: vector(2, 4), up: vector(4, 7), fov: rows[10] };
  }

  // The light at a frame; null: nothing is said.
  lightAt(frame) { return this.lights.findLast((l) => l.frame <= frame) ?? null; }

  // Floats of a list that is kept by frame ("contact", "line", "strut", "push", "sheet").
  moment(name, frame) {
    const width = { contact: 6, line: 7, strut: 8, push: 6, camera: 11, sheet: 5 }[name];
    const at = this[`${name}_at`], first = at[2 * frame], count = at[2 * frame + 1];
    return this[name].subarray(width * first, width * (first + count));
  }
}

async function inflate(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate-raw"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Bytes of the page are told by who has the text: asking the document for itself would write it anew.
// Reads the two elements of the page; null when the page holds none.
export async function readPage(document) {
  const head = document.getElementById("digbox-head"), data = document.getElementById("digbox-data");
  if (!head || !data) return null;
  const text = data.textContent;
  const replay = new Replay(JSON.parse(head.textContent), await inflate(decodeBase64(text.trim())));
  replay.page_bytes = text.length + [...document.scripts].reduce((sum, s) => sum + (s === data ? 0 : s.textContent.length), 0);
  data.textContent = "";                            // the text is not needed twice
  return replay;
}
