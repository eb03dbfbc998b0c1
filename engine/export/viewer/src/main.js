// main.js - the page of `digbox view`: time, keys, what is picked, and window.digbox for scripts and tests.
//
//   digbox.ready                         a promise of the facts, once the first picture is drawn; then there are also
//   digbox.seek(t) .step(n) .play() .pause() .pick(body or name) .body(body or name) .screen(body) .facts() .camera(number or name)
import { Vector3 } from "three";
import { readPage } from "./data.js";
import { bodyName, bytes, fixed } from "./format.js";
import { Overlays } from "./overlays.js";
import { Panel } from "./panel.js";
import { energyCurves, forceCurves, Plot } from "./plots.js";
import { Scene } from "./scene.js";

const SPEEDS = [0.02, 0.05, 0.1, 0.25, 0.5, 1, 2, 4, 8];
const byId = (id) => document.getElementById(id);

class Player {
  constructor(replay) {
    this.replay = replay;
    this.time = replay.start;
    this.speed = 1;
    this.playing = false;
    this.picked = -1;
    this.scene = new Scene(byId("canvas"), replay, () => this.redraw());
    this.overlays = new Overlays(this.scene, replay, byId("names"));
    this.panel = new Panel(replay, { pick: (i) => this.pick(i), seek: (t) => this.seek(t) });
    this.plots = [
      new Plot(byId("energy"), byId("energy-legend"), replay.times, "Energy", "J", (t) => this.seek(t)),
      new Plot(byId("force"), byId("force-legend"), replay.times, "Force", "N", (t) => this.seek(t)),
    ];
    this.plots[0].setCurves(energyCurves(replay));
    this.plots[1].setCurves(forceCurves(replay, -1));
    this.describe();
    this.makeLayers();
    this.makeCameras();
    this.listen();
    this.theme();
  }

  describe() {
    const r = this.replay, moving = r.bodies.filter((b) => b.kind !== "static").length;
    document.title = `${r.title} – digbox`;
    byId("title").textContent = r.title;
    byId("facts").textContent = `${fixed(r.end - r.start, 2)} s · ${r.frames} frames · ${moving} moving, ${r.bodies.length - moving} fixed · ${bytes(r.page_bytes)}`;
    byId("about-run").textContent = `Written by digbox ${r.digbox}. Seed ${r.seed}. ${r.cut ? "The replay was cut short: its end is missing. " : ""}${r.number[r.frames - 1] - r.number[0] >= r.frames ? "Not every frame of the replay is here. " : ""}Positions are linear between frames.`;
    byId("scrub").max = String(r.frames - 1);
    byId("speed").innerHTML = SPEEDS.map((s) => `<option value="${s}"${s === 1 ? " selected" : ""}>${s}×</option>`).join("");
  }

  // Buttons of the header: what can be shown over the bodies.
  makeLayers() {
    const toggles = [["links", "Links", () => this.replay.spans.length > 0], ["dig", "DIG colours", () => this.replay.spans.length > 0],
      ["forces", "Forces", () => this.replay.rows("contact") + this.replay.rows("push") > 0], ["heat", "Heat", () => this.replay.heat],
      ["names", "Names", () => this.replay.bodies.some((b) => b.name)]];
    this.buttons = {};
    for (const [id, label, useful] of toggles) {
      if (!useful()) continue;
      const button = byId("layers").appendChild(document.createElement("button"));
      button.textContent = label;
      button.dataset.layer = id;
      button.addEventListener("click", () => this.toggle(id));
      this.buttons[id] = button;
    }
    this.showLayers();
  }

  // The script's cameras, and the view that is turned by hand.
  makeCameras() {
    const list = this.replay.cameras, box = byId("camera");
    this.scene.released = () => this.camera(-1);
    box.hidden = list.length === 0;
    for (const [i, name] of ["own view", ...list.map((n, k) => n || `camera ${k + 1}`)].entries()) box.add(new Option(name, String(i - 1)));
    if (list.length > 0) this.scene.follows = 0;
    box.value = String(this.scene.follows);
  }

  // Looks through one of the script's cameras, by number or name; -1: as one likes.
  camera(which) {
    const number = typeof which === "string" ? this.replay.cameras.indexOf(which) : which;
    if (number >= 0 && number < this.replay.cameras.length) this.scene.follows = number;
    else if (this.scene.follows >= 0) this.scene.free();
    byId("camera").value = String(this.scene.follows);
    this.update();
  }

  toggle(id) {
    if (id === "dig" || id === "heat") this.scene.colouring = this.scene.colouring === id ? "own" : id;
    else this.overlays.on[id] = !this.overlays.on[id];
    this.showLayers();
    this.update();
  }

  showLayers() {
    for (const [id, button] of Object.entries(this.buttons)) button.setAttribute("aria-pressed", String(id === "dig" || id === "heat" ? this.scene.colouring === id : this.overlays.on[id]));
    const kinds = new Set(this.replay.spans.map((s) => this.replay.link_kinds[s.kind]));
    byId("legend").innerHTML = this.overlays.on.links ? [...kinds].map((k) => `<li style="--c:var(--${k})">${k}</li>`).join("") : "";
  }

  theme() {
    this.style = getComputedStyle(document.documentElement);
    this.scene.setTheme(!matchMedia("(prefers-color-scheme: light)").matches);
    this.overlays.setTheme(this.style);
    for (const plot of this.plots) plot.base = null;
    this.paintTicks();
    this.update();
  }

  // One mark for each event, tall for impacts and what breaks.
  paintTicks() {
    const canvas = byId("ticks"), ratio = Math.min(2, devicePixelRatio || 1), w = canvas.clientWidth, h = canvas.clientHeight;
    canvas.width = Math.max(1, w * ratio);
    canvas.height = Math.max(1, h * ratio);
    const g = canvas.getContext("2d");
    g.scale(ratio, ratio);
    g.globalAlpha = 0.8;
    const last = Math.max(1, this.replay.frames - 1), marks = { "--soft": new Set(), "--heat": new Set() };
    for (const e of this.replay.events) marks[e.kind === "broken" || e.kind === "impact" || e.kind === "removed" ? "--heat" : "--soft"].add(e.frame);
    for (const [colour, frames] of Object.entries(marks)) {
      const tall = colour === "--heat" ? 7 : 4;
      g.fillStyle = this.style.getPropertyValue(colour);
      for (const frame of frames) g.fillRect(7 + (frame / last) * (w - 14), h - tall - 1, 1, tall);
    }
  }

  listen() {
    const on = (id, type, act) => byId(id).addEventListener(type, act);
    on("play", "click", () => this.toggleplay());
    on("home", "click", () => this.seek(this.replay.start));
    on("last", "click", () => this.seek(this.replay.end));
    on("back", "click", () => this.step(-1));
    on("next", "click", () => this.step(1));
    on("scrub", "input", (e) => this.seek(this.replay.times[Number(e.target.value)]));
    on("speed", "change", (e) => { this.speed = Number(e.target.value); });
    on("camera", "change", (e) => this.camera(Number(e.target.value)));
    on("about-open", "click", () => byId("about").showModal());
    let down = null;
    on("canvas", "pointerdown", (e) => { down = e.isPrimary ? [e.clientX, e.clientY] : null; });
    on("canvas", "pointerup", (e) => {
      if (down && Math.hypot(e.clientX - down[0], e.clientY - down[1]) < (e.pointerType === "touch" ? 12 : 5)) {
        const box = e.target.getBoundingClientRect();
        this.pick(this.scene.hit(e.clientX - box.left, e.clientY - box.top));
      }
      down = null;
    });
    addEventListener("keydown", (e) => this.keyed(e));
    addEventListener("resize", () => { this.resized = true; this.redraw(); });
    matchMedia("(prefers-color-scheme: light)").addEventListener("change", () => this.theme());
    new ResizeObserver(() => {        // it also calls for the size that is there
      const { clientWidth, clientHeight } = byId("scene");
      if (clientWidth === this.size?.[0] && clientHeight === this.size[1]) return;
      this.resized = true;
      this.redraw();
    }).observe(byId("scene"));
    byId("canvas").addEventListener("webglcontextlost", (e) => { e.preventDefault(); tell("The graphics system took the picture away; reload the page."); });
  }

  keyed(e) {
    if (e.ctrlKey || e.metaKey || e.altKey || byId("about").open) return;
    const typing = e.target.matches("select"), pressing = e.target.matches("button, input[type=checkbox]");
    const keys = {
      " ": () => this.toggleplay(), ArrowLeft: () => this.step(e.shiftKey ? -10 : -1), ArrowRight: () => this.step(e.shiftKey ? 10 : 1),
      Home: () => this.seek(this.replay.start), End: () => this.seek(this.replay.end), Escape: () => this.pick(-1),
      ",": () => this.event(-1), ".": () => this.event(1), "-": () => this.faster(-1), "+": () => this.faster(1), "=": () => this.faster(1),
      c: () => this.nextCamera(), C: () => this.nextCamera(), f: () => this.focus(), F: () => this.focus(), "?": () => byId("about").showModal(),
    };
    if (!keys[e.key] || typing || (pressing && e.key === " ")) return;
    e.preventDefault();
    keys[e.key]();
  }

  faster(by) {
    const at = Math.min(SPEEDS.length - 1, Math.max(0, SPEEDS.indexOf(this.speed) + by));
    this.speed = SPEEDS[at];
    byId("speed").value = String(this.speed);
  }

  // The next event of the list in the panel, in the direction of `by`.
  event(by) {
    const { list } = this.panel, { frame } = this.replay.locate(this.time);
    const next = by > 0 ? list.find((e) => e.frame > frame) : list.findLast((e) => e.frame < frame);
    if (next) this.panel.jump(next);
  }

  nextCamera() {
    const { length } = this.replay.cameras;
    if (length > 0) this.camera(this.scene.follows + 1 < length ? this.scene.follows + 1 : -1);
  }

  focus() {
    this.camera(-1);
    const { frame, part } = this.replay.locate(this.time), c = this.picked >= 0 && this.overlays.centre(this.picked, frame, part);
    if (!c) return this.scene.lookAtAll();
    return this.scene.lookAt(c, 0.16 * this.scene.size);
  }

  seek(t) {
    this.time = Math.min(this.replay.end, Math.max(this.replay.start, Number.isFinite(t) ? t : this.replay.start));
    this.update();
  }

  // Whole frames; from between two frames a step of 1 goes to the later one.
  step(n) {
    this.pause();
    const { frame, part } = this.replay.locate(this.time);
    const to = n < 0 && part > 0 ? frame + n + 1 : frame + n;
    this.seek(this.replay.times[Math.min(this.replay.frames - 1, Math.max(0, to))]);
  }

  toggleplay() { if (this.playing) this.pause(); else this.play(); }

  play() {
    if (this.time >= this.replay.end) this.time = this.replay.start;
    this.playing = true;
    this.clock = null;
    this.showPlaying();
    this.redraw();
  }

  pause() {
    this.playing = false;
    this.showPlaying();
  }

  showPlaying() {
    byId("play").classList.toggle("playing", this.playing);
    byId("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
  }

  pick(body) {
    if (typeof body === "string") body = this.replay.bodies.findIndex((b) => b.name === body);
    this.picked = body >= 0 && body < this.replay.bodies.length ? body : -1;
    this.scene.picked = this.picked;
    this.panel.setBody(this.picked);
    this.plots[1].setCurves(forceCurves(this.replay, this.picked), this.picked >= 0 ? `on ${bodyName(this.replay, this.picked)}`.replace(/[<&]/g, "") : "");
    this.update();
  }

  // Everything that depends on the time or on what is picked; the picture itself follows at the next redraw.
  update() {
    const r = this.replay, { frame, part } = r.locate(this.time);
    this.scene.place(frame, part);
    this.overlays.update(frame, part, this.picked);
    byId("scrub").value = String(frame);
    byId("scrub").style.setProperty("--done", `${(100 * (frame + part)) / Math.max(1, r.frames - 1)}%`);
    byId("scrub").setAttribute("aria-valuetext", `${fixed(this.time, 3)} s`);
    const clock = byId("clock");
    clock.innerHTML = `<b>${fixed(this.time, 3)}</b> <small>of ${fixed(r.end, 2)} s, frame ${r.number[frame]}</small>`;
    this.panel.show(frame, part);
    for (const plot of this.plots) plot.draw(this.style, frame, this.time);
    this.redraw();
  }

  fit() {
    const { clientWidth, clientHeight } = byId("scene");
    this.size = [clientWidth, clientHeight];
    this.scene.resize(Math.max(1, clientWidth), Math.max(1, clientHeight));
  }

  redraw() {
    this.waiting ??= requestAnimationFrame((now) => this.frame(now));
  }

  frame(now) {
    this.waiting = null;
    if (this.resized) {
      this.resized = false;
      this.fit();
      this.paintTicks();
      for (const plot of this.plots) plot.base = null;
      this.update();
    }
    if (this.playing) this.advance(now);
    this.draw();
  }

  advance(now) {
    const passed = this.clock === null ? 0 : (now - this.clock) / 1000;
    this.clock = now;
    this.time += Math.min(passed, 0.25) * this.speed;
    if (this.time >= this.replay.end) {
      if (byId("loop").checked) {
        this.time = this.replay.start;
      } else {
        this.time = this.replay.end;
        this.pause();
      }
    }
    this.update();
  }

  draw() {
    const { frame, part } = this.replay.locate(this.time);
    if (this.overlays.outgrown()) this.overlays.update(frame, part, this.picked);
    this.scene.draw();
    this.overlays.placeNames(frame, part, this.picked);
  }
}

function tell(text) {
  const box = byId("message");
  box.textContent = text;
  box.hidden = false;
}

// What window.digbox offers.
function interfaceOf(player, facts) {
  const { replay } = player;
  const index = (b) => (typeof b === "string" ? replay.bodies.findIndex((x) => x.name === b) : b);
  const here = () => replay.locate(player.time);
  const state = (b) => {
    const { frame, part } = here();
    return index(b) >= 0 && index(b) < replay.bodies.length ? replay.state(index(b), frame, part) : null;
  };
  const draw = () => {
    player.update();
    player.draw();
  };
  return {
    facts: () => facts,
    time: () => player.time,
    frame: () => here().frame,
    picked: () => player.picked,
    playing: () => player.playing,
    seek: (t) => { player.seek(t); draw(); return player.time; },
    step: (n = 1) => { player.step(n); draw(); return player.time; },
    play: () => player.play(),
    pause: () => player.pause(),
    pick: (b) => { player.pick(b); draw(); return player.picked; },
    cameras: () => [...replay.cameras],
    camera: (which) => {
      if (which !== undefined) player.camera(which);
      draw();
      const { position, fov } = player.scene.camera, { target } = player.scene.controls, world = (v) => v.toArray().map((x, i) => x + replay.place[i]);
      return { number: player.scene.follows, at: world(position), look_at: world(target), fov: (fov * Math.PI) / 180 };
    },
    light: () => replay.lightAt(here().frame),
    show: (layer, on) => { if (player.buttons[layer] && (player.buttons[layer].getAttribute("aria-pressed") === "true") !== on) player.toggle(layer); },
    body: state,
    bodies: () => replay.bodies.map((b) => b.name),
    drawn: (b) => { const g = player.scene.groups[index(b)]; return g.visible ? g.position.toArray().map((x, i) => x + replay.place[i]) : null; },
    links: () => replay.spansAt(here().frame).map((s) => ({ a: s.a, b: s.b, kind: replay.link_kinds[s.kind], layer: replay.layers[s.layer], bound: s.bound, effort: replay.effortAt(s, here().frame) })),
    events: () => player.panel.list,
    screen: (b) => {
      const s = state(b), box = byId("canvas").getBoundingClientRect();
      const at = s?.there && player.scene.project(new Vector3(...s.centre.map((x, i) => x - replay.place[i])));
      return at ? [box.left + at[0], box.top + at[1]] : null;
    },
  };
}

async function begin() {
  const began = performance.now();
  const replay = await readPage(document);
  if (!replay) return tell("This page holds no replay. digbox view REPLAY -o page.html makes one that does.");
  const read = performance.now();
  let player;
  try {
    player = new Player(replay);
  } catch (e) {
    return tell(`This browser cannot draw the scene (${e.message}). WebGL 2 is needed.`);
  }
  const wanted = new URLSearchParams(location.hash.slice(1));
  player.fit();
  player.scene.lookAtAll();
  if (wanted.has("camera")) player.camera(wanted.get("camera"));
  player.seek(Number(wanted.get("t") ?? replay.start));
  if (wanted.has("body")) player.pick(/^\d+$/.test(wanted.get("body")) ? Number(wanted.get("body")) : wanted.get("body"));
  player.draw();
  cancelAnimationFrame(player.waiting);     // all that asked for a picture so far has it
  player.waiting = null;
  const facts = { format: replay.format, frames: replay.frames, bodies: replay.bodies.length, bytes: replay.head.bytes, start: replay.start, end: replay.end, read_ms: read - began, begin_ms: performance.now() - began, load_ms: performance.now() };
  Object.assign(window.digbox, interfaceOf(player, facts));
  return facts;
}

window.digbox = { ready: begin().catch((e) => tell(`This page cannot be read (${e.message}). A newer browser may do it, or it was damaged.`)) };
