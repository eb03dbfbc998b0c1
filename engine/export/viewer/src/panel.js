// panel.js - the column at the side: state and links of the picked body, and the events, of which only the visible ones are in the page.
import { bodyName, digColour, fixed, norm, number, vector, withUnit } from "./format.js";

const LINE = 24;        // px, height of an event

const escape = (text) => String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const toDisplay = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
const css = (rgb) => `rgb(${rgb.map((c) => Math.round(255 * toDisplay(c))).join(" ")})`;

export class Panel {
  constructor(replay, { pick, seek }) {
    Object.assign(this, { replay, pick, seek, body: -1, list: replay.events });
    for (const id of ["picker", "state", "links", "links-box", "link-count", "events", "event-count", "event-kind", "event-own"]) this[id] = document.getElementById(id);
    this.fillPicker();
    this.picker.addEventListener("change", () => pick(Number(this.picker.value)));
    this["event-kind"].addEventListener("change", () => this.filter());
    this["event-own"].addEventListener("change", () => this.filter());
    this.events.addEventListener("scroll", () => this.showEvents());
    new ResizeObserver(() => this.showEvents()).observe(this.events);
    this.links.addEventListener("click", (e) => this.choose(e, "body", (i) => pick(i)));
    this.events.addEventListener("click", (e) => this.choose(e, "event", (i) => this.jump(this.list[i])));
    this.filter();
  }

  choose(e, name, then) {
    const button = e.target.closest("button");
    if (button?.dataset[name]) then(Number(button.dataset[name]));
  }

  jump(event) {
    this.seek(this.replay.times[event.frame]);
    if (event.a >= 0) this.pick(event.a);
  }

  fillPicker() {
    const option = (i) => `<option value="${i}">${escape(bodyName(this.replay, i))}</option>`;
    const dynamic = [], fixedOnes = [];
    this.replay.bodies.forEach((b, i) => (b.kind === "static" ? fixedOnes : dynamic).push(option(i)));
    this.picker.innerHTML = `<option value="-1">none picked</option><optgroup label="moving">${dynamic.join("")}</optgroup><optgroup label="fixed">${fixedOnes.join("")}</optgroup>`;
    const counts = new Map();
    for (const e of this.replay.events) counts.set(e.kind, (counts.get(e.kind) ?? 0) + 1);
    this["event-kind"].innerHTML = `<option value="">all kinds</option>${[...counts].map(([k, n]) => `<option value="${k}">${k.replaceAll("_", " ")} (${n})</option>`).join("")}`;
  }

  setBody(body) {
    this.body = body;
    this.picker.value = String(body);
    this["event-own"].disabled = body < 0;
    if (this["event-own"].checked) this.filter();
  }

  show(frame, part) {
    this.showState(frame, part);
    this.showLinks(frame);
    this.frame = frame;
    this.followEvents();
  }

  showState(frame, part) {
    if (this.body < 0) {
      this.state.innerHTML = "<p>Click a body in the scene, or choose one here.</p>";
      return;
    }
    const about = this.replay.bodies[this.body], s = this.replay.state(this.body, frame, part);
    const chips = [`<span class="chip">${escape(about.material || about.shape)}</span>`];
    if (!s.there) {
      this.state.innerHTML = `<p>${frame < about.born ? "It is not there yet." : "It was removed."}</p>`;
      return;
    }
    if (about.kind !== "static") chips.push(`<span class="chip">${s.awake ? "awake" : "asleep"}</span>`);
    if (s.dig) chips.push(`<span class="chip" style="--c:${css(digColour(s.dig))}"><i></i>DIG ${s.dig}</span>`);
    if (about.kind !== "dynamic") chips.push(`<span class="chip">${about.kind}</span>`);
    const size = Math.max(...s.position.map(Math.abs)), places = size < 10 ? 4 : size < 1e3 ? 3 : 1;
    const [x, y, z, w] = s.rotation, angle = 2 * Math.atan2(Math.hypot(x, y, z), Math.abs(w));
    const rows = [["mass", about.mass === null ? "∞" : number(about.mass), "kg"], ["position", vector(s.position, places), "m"],
      ["turned by", fixed((angle * 180) / Math.PI, 1), "°"]];
    if (about.kind !== "static") {
      rows.push(["velocity", vector(s.velocity), "m/s"], ["speed", fixed(norm(s.velocity), 4), "m/s"], ["spin", vector(s.spin), "rad/s"],
        ["force", s.force.map((f) => number(Math.abs(f) < 1e-6 * norm(s.force) ? 0 : f, 3)).join("  ").replaceAll("-", "−"), "N"]);
      const kinetic = 0.5 * (about.mass ?? 0) * norm(s.velocity) ** 2;
      rows.push(["½ m v²", number(kinetic, 3), "J"]);
    }
    if (s.temperature > 0) rows.push(["temperature", fixed(s.temperature, 1), "K"]);
    this.state.innerHTML = chips.join("") + `<dl>${rows.map(([a, b, c]) => `<dt>${a}</dt><dd>${b}</dd><dd class="unit">${c}</dd>`).join("")}</dl>`;
  }

  showLinks(frame) {
    this["links-box"].hidden = this.body < 0;
    if (this.body < 0) return;
    const r = this.replay, own = r.spansOf[this.body].map((i) => r.spans[i]).filter((s) => s.first <= frame && frame <= s.last);
    const key = own.map((s) => `${s.a} ${s.b} ${s.kind}`).join();
    this["link-count"].textContent = own.length ? `(${own.length})` : "";
    if (key !== this.linkKey) {
      this.links.innerHTML = own.map((s) => {
        const other = s.a === this.body ? s.b : s.a;
        return `<li><button data-body="${other}"><i style="--c:var(--${r.link_kinds[s.kind]})"></i><span>${escape(bodyName(r, other))}</span><span></span></button></li>`;
      }).join("") || "<li>none now</li>";
      this.linkKey = key;
    }
    own.forEach((s, i) => {
      const unit = s.layer === 0 ? withUnit(r.effortAt(s, frame), "N") : r.layers[s.layer];
      this.links.children[i].querySelector("span:last-child").textContent = `${r.link_kinds[s.kind]}, ${unit}`;
    });
  }

  filter() {
    const kind = this["event-kind"].value, own = this["event-own"].checked && this.body >= 0;
    this.list = this.replay.events.filter((e) => (!kind || e.kind === kind) && (!own || e.a === this.body || e.b === this.body));
    this["event-count"].textContent = `(${this.list.length}${this.replay.events_left_out ? ` of ${this.replay.events.length + this.replay.events_left_out}` : ""})`;
    this.nowAt = null;
    this.shownFrom = null;
    this.followEvents();
    this.showEvents();
  }

  // Index of the last event that is not after the frame, -1 = none.
  current() {
    let low = -1, high = this.list.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.list[middle].frame <= (this.frame ?? 0)) low = middle;
      else high = middle - 1;
    }
    return low;
  }

  // The list goes along with the time, unless it is in somebody's hands.
  followEvents() {
    const at = this.current();
    if (at === this.nowAt) return;
    this.nowAt = at;
    const box = this.events, top = Math.max(0, at) * LINE;
    if (!box.matches(":hover, :focus-within") && (top < box.scrollTop || top > box.scrollTop + box.clientHeight - 2 * LINE)) box.scrollTop = Math.max(0, top - box.clientHeight / 2);
    this.shownFrom = null;
    this.showEvents();
  }

  showEvents() {
    const box = this.events, first = Math.max(0, Math.floor(box.scrollTop / LINE) - 2), count = Math.ceil(box.clientHeight / LINE) + 4;
    const key = `${first} ${count} ${this.nowAt} ${this.list.length}`;
    if (key === this.shownFrom) return;
    this.shownFrom = key;
    const now = this.nowAt >= 0 ? this.list[this.nowAt]?.frame : -1, end = Math.min(this.list.length, first + count);
    const lines = [];
    for (let i = first; i < end; i++) {
      const e = this.list[i];
      lines.push(`<li style="top:${i * LINE}px"${e.frame === now ? ' class="now"' : ""}><button data-event="${i}"><time>${fixed(e.time, 3)} s</time><span title="${escape(this.sentence(e))}">${escape(this.sentence(e))}</span></button></li>`);
    }
    lines.push(`<li style="top:${this.list.length * LINE}px;height:1px"></li>`);
    box.innerHTML = lines.join("");
  }

  sentence(e) {
    const a = bodyName(this.replay, e.a), b = bodyName(this.replay, e.b), speed = `${number(e.speed, 3)} m/s`;
    switch (e.kind) {
      case "contact_begin": return `${a} touches ${b}${e.speed > 0 ? `, ${speed}` : ""}`;
      case "contact_end": return `${a} leaves ${b}`;
      case "impact": return `${a} hits ${b}, ${speed}`;
      case "broken": return `${a} – ${b} breaks`;
      case "slept": return e.a >= 0 ? `${a} falls asleep` : `DIG ${e.dig} falls asleep`;
      case "woke": return e.a >= 0 ? `${a} wakes` : `DIG ${e.dig} wakes`;
      case "removed": return `${a} is removed`;
      case "merged": return `DIG ${e.otherDig} joins DIG ${e.dig}`;
      case "split": return `DIG ${e.otherDig} splits off DIG ${e.dig}`;
      case "link": return `${a} – ${b}: ${e.link}`;
      case "unlink": return `${a} – ${b}: no ${e.link} any more`;
      case "limit_reached": return `${a} reaches a limit`;
      case "out_of_world": return `${a} leaves the world`;
      default: return `${e.kind.replaceAll("_", " ")}: ${a}${e.b >= 0 ? `, ${b}` : ""}`;
    }
  }
}
