// overlays.js - what is drawn beside and over the bodies: sheets, DIG links by kind, contact forces, pushes, joints, struts, the way of the picked body, names.
import {
  BufferAttribute, BufferGeometry, Color, ConeGeometry, CylinderGeometry, DoubleSide, DynamicDrawUsage, InstancedMesh, Line, LineBasicMaterial, Matrix4,
  Mesh, MeshBasicMaterial, MeshStandardMaterial, Quaternion, SphereGeometry, Vector3,
} from "three";
import { rotate } from "./data.js";
import { digColour } from "./format.js";

const Y = new Vector3(0, 1, 0);

// Many instances of one small solid; begin, add, end. Grows by doubling.
class Many {
  constructor(scene, geometry, material, order) {
    Object.assign(this, { scene, geometry, material, order, count: 0, matrix: new Matrix4(), turn: new Quaternion(), along: new Vector3() });
    this.grow(64);
  }

  grow(capacity) {
    const old = this.mesh;
    this.mesh = new InstancedMesh(this.geometry, this.material, capacity);
    this.mesh.instanceMatrix.setUsage(DynamicDrawUsage);
    this.mesh.setColorAt(0, new Color(1, 1, 1));
    this.mesh.frustumCulled = false;
    this.mesh.renderOrder = this.order;
    if (old) {
      this.mesh.instanceMatrix.array.set(old.instanceMatrix.array);
      this.mesh.instanceColor.array.set(old.instanceColor.array);
      this.scene.remove(old);
      old.dispose();
    }
    this.scene.add(this.mesh);
  }

  begin() { this.count = 0; }

  // A solid that stands along y between -1/2 and 1/2, stretched from a to b with a radius.
  add(a, b, radius, colour) {
    this.along.subVectors(b, a);
    const length = this.along.length();
    if (length > 0) this.turn.setFromUnitVectors(Y, this.along.divideScalar(length));
    else this.turn.identity();
    this.put(new Vector3().addVectors(a, b).multiplyScalar(0.5), new Vector3(radius, Math.max(length, 1e-9), radius), colour);
  }

  put(place, size, colour) {
    if (this.count === this.mesh.instanceMatrix.count) this.grow(2 * this.count);
    this.mesh.setMatrixAt(this.count, this.matrix.compose(place, this.turn, size));
    this.mesh.setColorAt(this.count++, colour);
  }

  end() {
    this.mesh.count = this.count;
    this.mesh.visible = this.count > 0;
    this.mesh.instanceMatrix.needsUpdate = true;
    this.mesh.instanceColor.needsUpdate = true;
  }
}

const onTop = (opacity) => new MeshBasicMaterial({ transparent: true, opacity, depthTest: false, depthWrite: false, toneMapped: false, fog: false });

export class Overlays {
  constructor(stage, replay, names) {
    Object.assign(this, { stage, replay, names });
    this.on = { links: true, forces: false, names: false };
    const rod = () => new CylinderGeometry(1, 1, 1, 10, 1), scene = stage.scene;
    this.rods = new Many(scene, rod(), onTop(0.92), 10);
    this.dots = new Many(scene, new SphereGeometry(1, 14, 10), onTop(1), 11);
    this.shafts = new Many(scene, rod(), onTop(0.95), 12);
    this.heads = new Many(scene, new ConeGeometry(1, 1, 14), onTop(0.95), 12);
    this.struts = new Many(scene, rod(), new MeshStandardMaterial({ roughness: 0.45 }), 0);
    this.struts.mesh.castShadow = true;
    this.threads = new Many(scene, rod(), new MeshStandardMaterial({ roughness: 0.7 }), 0);
    this.sheet = new Mesh(new BufferGeometry(), new MeshStandardMaterial({ roughness: 0.85, vertexColors: true, side: DoubleSide }));
    this.sheet.castShadow = true;       // and receives none: it has no thickness to keep its own off
    this.sheet.frustumCulled = false;
    this.woven = [];        // bodies that are its vertices
    scene.add(this.sheet);
    this.trail = new Line(new BufferGeometry(), new LineBasicMaterial({ color: 0x5ea1ff, depthTest: false, transparent: true, opacity: 0.75, fog: false }));
    this.trail.renderOrder = 9;
    this.trail.frustumCulled = false;
    scene.add(this.trail);
    this.labels = [];
    this.colours = {};
  }

  // The colours of the page's style, for kinds of links.
  setTheme(style) {
    for (const kind of [...this.replay.link_kinds, "accent", "heat"]) this.colours[kind] = new Color(style.getPropertyValue(`--${kind}`).trim() || "#888");
    this.trail.material.color.copy(this.colours.accent);
  }

  // Shares of what is seen for one newton: nine of ten contact forces stay below a quarter of it.
  measureForces() {
    const c = this.replay.contact, n = c.length / 6, sizes = [];
    const stride = Math.max(1, Math.floor(n / 4000));
    for (let i = 0; i < n; i += stride) sizes.push(Math.hypot(c[6 * i + 3], c[6 * i + 4], c[6 * i + 5]));
    sizes.sort((x, y) => x - y);
    const large = sizes[Math.floor(0.9 * (sizes.length - 1))] || 1;
    return 0.15 / large;
  }

  centre(body, frame, part) {
    const p = new Float64Array(7);
    if (!this.replay.pose(body, frame, part, p)) return null;
    const c = rotate(p.subarray(3, 7), this.replay.bodies[body].centre);
    return new Vector3(p[0] + c[0], p[1] + c[1], p[2] + c[2]);
  }

  // Whether the camera has come so much nearer, or gone so far, that lines have to be drawn anew.
  outgrown() {
    const now = this.stage.measureOfLines();
    return now > 1.2 * this.unit || this.unit > 1.2 * now;
  }

  update(frame, part, picked) {
    this.unit = this.stage.measureOfLines();
    this.drawLinks(frame, part, picked);
    this.drawForces(frame);
    this.drawSolids(frame);
    this.drawSheets(frame, part);
    this.drawTrail(picked);
  }

  drawLinks(frame, part, picked) {
    const { rods, dots, replay } = this, thin = 0.0022 * this.unit, faint = new Color();
    const seen = new Map();
    const at = (body) => {
      if (!seen.has(body)) seen.set(body, this.centre(body, frame, part));
      return seen.get(body);
    };
    rods.begin();
    dots.begin();
    if (this.on.links) {
      for (const span of replay.spansAt(frame)) {
        const a = at(span.a), b = span.bound ? new Vector3(...replay.endAt(span, frame)) : at(span.b);
        if (!a || !b) continue;
        const own = picked < 0 || span.a === picked || span.b === picked;
        const colour = own ? this.colours[replay.link_kinds[span.kind]] : faint.copy(this.colours[replay.link_kinds[span.kind]]).multiplyScalar(0.45);
        rods.add(a, b, own ? thin : 0.6 * thin, colour);
        if (span.bound) dots.put(b, new Vector3(1.6 * thin, 1.6 * thin, 1.6 * thin), colour);
      }
      const node = new Color(0xffffff);
      for (const [body, place] of seen) if (place) dots.put(place, new Vector3(1, 1, 1).multiplyScalar(body === picked ? 4 * thin : 2.6 * thin), body === picked ? this.colours.accent : node);
    }
    rods.end();
    dots.end();
  }

  arrow(from, force, colour) {
    const size = force.length();
    if (!(size > 0)) return;
    const longest = 0.6 * this.unit, length = Math.min(longest, this.unit * size * (this.forceScale ??= this.measureForces())), wide = 0.0032 * this.unit;
    const along = force.clone().divideScalar(size), head = Math.min(0.5 * length, 6 * wide);
    const neck = from.clone().addScaledVector(along, length - head), tip = from.clone().addScaledVector(along, length);
    this.shafts.add(from, neck, wide, colour);
    this.heads.add(neck, tip, 2.4 * wide, colour);
  }

  drawForces(frame) {
    this.shafts.begin();
    this.heads.begin();
    if (this.on.forces) {
      for (const [list, colour] of [["contact", this.colours.contact], ["push", this.colours.heat]]) {
        const v = this.replay.moment(list, frame);
        for (let i = 0; i < v.length; i += 6) this.arrow(new Vector3(v[i], v[i + 1], v[i + 2]), new Vector3(v[i + 3], v[i + 4], v[i + 5]), colour);
      }
    }
    this.shafts.end();
    this.heads.end();
  }

  // Struts, ropes, springs and edges of the room.
  drawSolids(frame) {
    const a = new Vector3(), b = new Vector3(), colour = new Color();
    const struts = this.replay.moment("strut", frame), lines = this.replay.moment("line", frame);
    this.struts.begin();
    for (let i = 0; i < struts.length; i += 8) {
      const stress = struts[i + 7];
      colour.setRGB(0.30, 0.32, 0.35);
      if (stress >= 0) colour.lerp(this.colours.heat, Math.min(1, stress) ** 2 * 0.9);
      this.struts.add(a.fromArray(struts, i), b.fromArray(struts, i + 3), struts[i + 6], colour);
    }
    this.struts.end();
    this.threads.begin();
    const packed = new Uint32Array(lines.buffer, lines.byteOffset, lines.length);
    for (let i = 0; i < lines.length; i += 7) {
      colour.setHex(packed[i + 6]);
      this.threads.add(a.fromArray(lines, i), b.fromArray(lines, i + 3), 0.0016 * this.unit, colour);
    }
    this.threads.end();
  }

  // Which bodies are the corners of quads; made anew when a sheet tears.
  weave(rows) {
    const packed = new Uint32Array(rows.buffer, rows.byteOffset, rows.length), vertex = new Map(), index = [], own = [], c = new Color();
    const at = (body, colour) => {
      if (!vertex.has(body)) {
        vertex.set(body, vertex.size);
        own.push(...c.setHex(colour).toArray());
      }
      return vertex.get(body);
    };
    for (let i = 0; i < rows.length; i += 5) {
      const [a, b, d, e] = [0, 1, 2, 3].map((k) => at(rows[i + k], packed[i + 4]));
      index.push(a, b, d, a, d, e);
    }
    this.woven = [...vertex.keys()];
    this.ownColours = own;
    this.sheet.geometry.dispose();
    this.sheet.geometry = new BufferGeometry().setIndex(index)
      .setAttribute("position", new BufferAttribute(new Float32Array(own.length), 3))
      .setAttribute("color", new BufferAttribute(new Float32Array(own), 3));
  }

  // Sheets are surfaces between their particles, which are not drawn themselves.
  drawSheets(frame, part) {
    const rows = this.replay.moment("sheet", frame), { groups, colouring } = this.stage, key = `${rows.byteOffset} ${rows.length}`;
    if (key !== this.wovenBy) this.weave(rows);
    this.wovenBy = key;
    this.sheet.visible = rows.length > 0;
    if (!rows.length) return;
    const { position, color } = this.sheet.geometry.attributes, tint = new Color();
    this.woven.forEach((body, i) => {
      const p = this.centre(body, frame, part), dig = colouring === "dig" ? this.replay.state(body, frame).dig : 0;
      groups[body].visible = false;
      if (p) position.setXYZ(i, p.x, p.y, p.z);
      tint.fromArray(this.ownColours, 3 * i);
      if (dig) tint.lerp(new Color().setRGB(...digColour(dig)), 0.85);
      color.setXYZ(i, tint.r, tint.g, tint.b);
    });
    position.needsUpdate = color.needsUpdate = true;
    this.sheet.geometry.computeVertexNormals();
  }

  drawTrail(picked) {
    if (this.trailOf === picked) return;
    this.trailOf = picked;
    this.trail.visible = false;
    if (picked < 0 || this.replay.bodies[picked].kind === "static") return;
    const points = [];
    for (let f = this.replay.bodies[picked].born; f < Math.min(this.replay.frames, this.replay.bodies[picked].died); f++) {
      const c = this.centre(picked, f, 0);
      if (c) points.push(c.x, c.y, c.z);
    }
    this.trail.geometry.dispose();
    this.trail.geometry = new BufferGeometry().setAttribute("position", new BufferAttribute(new Float32Array(points), 3));
    this.trail.visible = points.length > 3;
  }

  // HTML over the canvas; at most 80, those of the front.
  placeNames(frame, part, picked) {
    const wanted = [];
    this.replay.bodies.forEach((b, i) => {
      if (!(i === picked || (this.on.names && b.name && b.shape !== "plane"))) return;
      const c = this.replay.alive(i, frame) && this.centre(i, frame, part), at = c && this.stage.project(c);
      if (at) wanted.push({ text: b.name || `${b.shape} ${i}`, at, far: c.distanceTo(this.stage.camera.position) });
    });
    wanted.sort((x, y) => x.far - y.far).splice(80);
    while (this.labels.length < wanted.length) this.labels.push(this.names.appendChild(document.createElement("span")));
    this.labels.forEach((label, i) => {
      label.hidden = i >= wanted.length;
      if (label.hidden) return;
      if (label.textContent !== wanted[i].text) label.textContent = wanted[i].text;
      label.style.transform = `translate(${wanted[i].at[0].toFixed(1)}px, ${wanted[i].at[1].toFixed(1)}px) translate(-50%, -170%)`;
    });
  }
}
