// sample.mjs - a page without a replay: bodies whose motion is known in closed form, in the format of engine/export/html.c.
//
//   node sample.mjs TEMPLATE.html OUT.html [BODIES FRAMES]
//
// Body 0 is the floor; "flyer" falls freely, "turner" turns about y at 1 rad/s, "late" is there from frame 30 to 90; the
// others, if any, circle.
import { readFileSync, writeFileSync } from "node:fs";
import { deflateRawSync } from "node:zlib";

const [template, out, bodyText = "4", frameText = "121"] = process.argv.slice(2);
const count = Number(bodyText), frames = Number(frameText), step = 1 / 60;

const lists = {};
const put = (name, ...values) => (lists[name] ??= []).push(...values);
const bodies = [], shapes = [], meshes = [], events = [];
const mesh = (form, ...size) => meshes.push({ form, size: [...size, 0, 0].slice(0, 3), vertices: [0, 0], normals: null, indices: [0, 0] }) - 1;

function add(name, kind, form, pose, more = {}) {
  const body = bodies.length, first = (lists.key_frame ?? []).length;
  const { born = 0, died = frames, colour = [0.6, 0.3, 0.1], pattern = "wood", roughness = 0.6, metallic = 0 } = more;
  shapes.push({ body, mesh: form, p: [0, 0, 0], q: [0, 0, 0, 1], colour, roughness, metallic, pattern, opacity: 1 });
  let before = "";
  for (let f = born; f < died; f++) {
    const { p, q = [0, 0, 0, 1], v = [0, 0, 0], w = [0, 0, 0], force = [0, 0, 0], dig = 0 } = pose(f * step);
    const now = JSON.stringify([p, q, v, w, force, dig]);
    if (now === before) continue;
    before = now;
    put("key_frame", f);
    put("key_pose", ...p, ...q);
    put("key_motion", ...v, ...w, ...force);
    put("key_dig", dig);
    put("key_flags", 1);
  }
  bodies.push({ name, material: "oak", kind, mass: kind === "static" ? null : 2, centre: [0, 0, 0], born, died, shape: meshes[form].form, keys: [first, lists.key_frame.length - first] });
  return body;
}

const plane = mesh("plane"), box = mesh("box", 0.4, 0.4, 0.4), ball = mesh("sphere", 0.25), pill = mesh("capsule", 0.12, 0.3);
add("floor", "static", plane, () => ({ p: [0, 0, 0] }), { colour: [0.55, 0.53, 0.5], pattern: "tile" });
add("flyer", "dynamic", ball, (t) => ({ p: [-1, 20 - 0.5 * 9.81 * t * t, 0], v: [0, -9.81 * t, 0], force: [0, -19.62, 0], dig: 1 }), { pattern: "stripe", colour: [0.1, 0.3, 0.7] });
add("turner", "dynamic", box, (t) => ({ p: [0, 0.2, 0], q: [0, Math.sin(t / 2), 0, Math.cos(t / 2)], w: [0, 1, 0], dig: 2 }));
add("late", "dynamic", pill, (t) => ({ p: [1, 0.3 + t, 0], v: [0, 1, 0], dig: 3 }), { born: 30, died: 90, pattern: "plain", colour: [0.8, 0.1, 0.1] });
for (let i = 4; i < count; i++) {
  const r = 1 + 0.03 * i, form = [box, ball, pill][i % 3];
  add(i % 2 ? `b${i}` : "", "dynamic", form, (t) => ({ p: [r * Math.cos(i + t), 0.3 + 0.02 * i, r * Math.sin(i + t)], q: [0, Math.sin(t), 0, Math.cos(t)], v: [-r * Math.sin(i + t), 0, r * Math.cos(i + t)], force: [-r, 0, 0], dig: 1 + (i % 9) }),
    { pattern: ["wood", "stripe", "plain", "brick"][i % 4], colour: [[0.6, 0.33, 0.12], [0.15, 0.4, 0.75], [0.8, 0.2, 0.15], [0.55, 0.2, 0.12]][i % 4], metallic: i % 7 === 0 ? 0.9 : 0, roughness: i % 7 === 0 ? 0.3 : 0.6 });
}

for (let f = 0; f < frames; f++) {
  const t = f * step;
  put("times", t);
  put("number", f);
  put("energy", 2 * 0.5 * (9.81 * t) ** 2, 2 * 9.81 * (20 - 0.5 * 9.81 * t * t), 0, 0, 0, 0, 0, 0, 0, 2 * 9.81 * 20);
  put("contact_at", f, 1);
  put("contact", 0, 0, 0, 0, 19.62, 0);
  put("line_at", 0, 0);
  put("strut_at", 0, 0);
  put("push_at", 0, 0);
  put("sheet_at", 0, 0);
  const row = (lists.camera?.length ?? 0) / 11;         // "still" is there from the start, "mover" from 0.5 s on; it says no up
  put("camera", 7, 4, 3, 7, 0, 1, 0, 0, 1, 0, 0.6);
  if (f >= 30) put("camera", 3, 3 + t, 2, 4, 0, t, 0, 0, 0, 0, 0.5);
  put("camera_at", row, f >= 30 ? 2 : 1);
}
put("link", 2, 0, 0, 256, 0, frames, 1, 2, 1, 0, 0, 60);
for (let f = 0; f < frames; f++) { put("effort", 19.62); put("link_end", 0, 0, 0); }
for (let f = 0; f < 60; f++) put("effort", f);
events.push([30, 0.5, 0, 3, 0, 1.5, 0.1, 3, 0, 0, 0, 0], [60, 1, 11, 1, 2, 0, 0, 1, 2, 1, 0, 0], [90, 1.5, 7, 3, -1, 0, 0, 0, 0, 0, 0, 0]);

// Every part with all its bits: the bytes of a column one after the other.
const kinds = { f64: Float64Array, f32: Float32Array, u32: Uint32Array };
const widths = { energy: 10, key_pose: 7, key_motion: 9, link: 6, link_end: 3, contact: 6, line: 7, strut: 8, push: 6, camera: 11, sheet: 5, event: 12,
  contact_at: 2, line_at: 2, strut_at: 2, push_at: 2, camera_at: 2, sheet_at: 2, vertex: 3, normal: 3 };
const typeOf = { times: "f64", energy: "f64", event: "f64", number: "u32", key_frame: "u32", key_dig: "u32", key_flags: "u32", link: "u32", contact_at: "u32", line_at: "u32", strut_at: "u32", push_at: "u32", camera_at: "u32", sheet_at: "u32", index: "u32" };
const sections = {}, blocks = [];
let offset = 0;
put("event", ...events.flat());
for (const name of ["times", "energy", "number", "key_frame", "key_pose", "key_motion", "key_dig", "key_flags", "link", "effort", "link_end", "contact_at", "contact",
  "line_at", "line", "strut_at", "strut", "push_at", "push", "camera_at", "camera", "sheet_at", "sheet", "event", "vertex", "normal", "index"]) {
  const kind = typeOf[name] ?? "f32", width = widths[name] ?? 1, array = new kinds[kind](lists[name] ?? []), rows = array.length / width;
  const bytes = new Uint8Array(array.buffer), size = array.BYTES_PER_ELEMENT, planes = Buffer.alloc(bytes.length);
  sections[name] = [kind, offset, rows, [[width, -1, 1]]];
  for (let i = 0; i < bytes.length; i++) {
    const byte = i % size, column = Math.floor(i / size) % width, row = Math.floor(i / size / width);
    planes[(column * size + byte) * rows + row] = bytes[i];
  }
  blocks.push(planes);
  offset += planes.length;
}
const head = {
  format: 2, title: "sample", digbox: "sample", origin: null, seed: 1, step, frames, cut: false, bytes: offset, place: [0, 0, 0], up: [0, 1, 0],
  low: [-2, 0, -2], high: [2, 2.5, 2], heat: null, link_kinds: ["contact", "joint", "port", "range"], layers: ["mechanical", "electrical", "thermal", "hydraulic", "range"],
  modes: ["moving", "resting", "fixed"], events_left_out: 0,
  event_kinds: ["contact_begin", "contact_end", "impact", "broken", "moved", "slept", "woke", "removed", "merged", "split", "link", "unlink", "message", "limit_reached", "out_of_world", "entered", "left"],
  cameras: ["still", "mover"], lights: [{ frame: 0, sky: "clear", shadows: true, sun: [1, 2, 1], lamps: [] },
    { frame: 90, sky: "night", shadows: false, sun: [0, 1, 0], lamps: [{ power: 80, at: [0, 2, 0], colour: [1, 0.6, 0.3] }] }],
  bodies, meshes, shapes, sections,
};
const data = `<script type="application/json" id="digbox-head">${JSON.stringify(head).replace(/</g, "\\u003c")}</script>\n`
  + `<script type="application/base64" id="digbox-data">${deflateRawSync(Buffer.concat(blocks)).toString("base64")}</script>`;
writeFileSync(out, readFileSync(template, "utf8").replace("<!--DIGBOX-DATA-->", () => data));
