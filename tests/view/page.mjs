// page.mjs - the page of `digbox view` in headless Chromium: where bodies are, keys, picking, events, labels, and that it asks for nothing.
//
//   NODE_MODULES=... CHROMIUM=... node page.mjs SAMPLE.html RUN.html RUN.csv RUN.jsonl [PICTURES]
//
// SAMPLE is made by sample.mjs, so that what must come out is known in closed form; RUN is a replay's page and its exports.
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { checks, launch, openPage } from "./browser.mjs";

const [sample, run, table, told, pictures] = process.argv.slice(2);
const c = checks(), browser = await launch();
const ask = (page, f, arg) => page.evaluate(f, arg);
const shot = async (page, name) => { if (pictures) await page.screenshot({ path: join(pictures, name) }); };
const seek = (page, t) => ask(page, (s) => window.digbox.seek(s), t);
const body = (page, name) => ask(page, (n) => window.digbox.body(n), name);

async function judgeMotion(page) {
  for (const t of [0, 0.5, 1, 1.7, 2]) {
    await seek(page, t);
    const flyer = await body(page, "flyer"), turner = await body(page, "turner");
    c.near(`flyer at ${t} s`, flyer.position, [-1, 20 - 0.5 * 9.81 * t * t, 0], 2e-6);
    c.near(`its velocity at ${t} s`, flyer.velocity, [0, -9.81 * t, 0], 2e-6);
    c.near(`turner's rotation at ${t} s`, turner.rotation, [0, Math.sin(t / 2), 0, Math.cos(t / 2)], 1e-6);
    c.near(`what is drawn of flyer at ${t} s`, await ask(page, () => window.digbox.drawn("flyer")), flyer.position, 0);
  }
  const half = 1 / 120, y = (t) => 20 - 0.5 * 9.81 * t * t;
  await seek(page, 1 + half);
  c.near("flyer between two frames", (await body(page, "flyer")).position, [-1, (y(1) + y(1 + 2 * half)) / 2, 0], 4e-6);
  for (const [t, there] of [[0.45, false], [0.5, true], [1.48, true], [1.51, false]]) {
    await seek(page, t);
    c.check(`late is ${there ? "" : "not "}there at ${t} s`, (await body(page, "late")).there === there);
    c.check(`late is ${there ? "" : "not "}drawn at ${t} s`, ((await ask(page, () => window.digbox.drawn("late"))) !== null) === there);
  }
  c.check("a time before the start is the start", (await seek(page, -5)) === 0);
  c.check("a time after the end is the end", Math.abs((await seek(page, 99)) - 2) < 1e-9);
}

async function judgeLinks(page) {
  await seek(page, 0.5);
  const links = await ask(page, () => window.digbox.links());
  c.check("two links at 0.5 s", links.length === 2, links);
  const joint = links.find((l) => l.kind === "joint"), contact = links.find((l) => l.kind === "contact");
  c.check("the joint holds flyer and turner with 30 N", joint?.a === 1 && joint.b === 2 && joint.effort === 30, joint);
  c.check("the contact is with the outside", contact?.bound === true && Math.abs(contact.effort - 19.62) < 1e-5, contact);
  await seek(page, 1.2);
  c.check("one link at 1.2 s", (await ask(page, () => window.digbox.links().length)) === 1);
}

async function judgeCameras(page) {
  const camera = (which) => ask(page, (w) => window.digbox.camera(w), which);
  await seek(page, 0);
  c.check("the script's first camera is looked through", (await camera()).number === 0 && (await page.inputValue("#camera")) === "0");
  c.near("it stands", (await camera()).at, [4, 3, 7], 1e-6);
  c.near("its angle", [(await camera()).fov], [0.6], 1e-6);
  await page.selectOption("#camera", { label: "mover" });
  for (const t of [0.5, 1, 1 + 1 / 120, 2]) {
    await seek(page, t);
    const now = await camera();
    c.near(`mover at ${t} s`, now.at, [3 + t, 2, 4], 1e-5);
    c.near(`what it looks at at ${t} s`, now.look_at, [0, t, 0], 1e-5);
  }
  c.near("its angle", [(await camera()).fov], [0.5], 1e-6);
  const lit = await ask(page, () => window.digbox.light());
  c.check("the light at the end is the script's", lit.sky === "night" && lit.lamps.length === 1 && !lit.shadows, lit);
  await seek(page, 1);
  c.check("and before it another", (await ask(page, () => window.digbox.light().sky)) === "clear");
  const box = await page.locator("#canvas").boundingBox();
  await page.mouse.move(box.x + 300, box.y + 200);
  await page.mouse.down();
  await page.mouse.move(box.x + 380, box.y + 220);
  await page.mouse.up();
  const own = await camera();
  c.check("turning the view leaves the script's camera", own.number === -1 && (await page.inputValue("#camera")) === "-1", own);
  await seek(page, 2);
  c.near("which then stays", (await camera()).at, own.at, 1e-9);
  await page.focus("#canvas");
  await page.keyboard.press("c");
  c.check("C takes the next camera", (await camera()).number === 0);
}

async function judgeKeys(page) {
  const frame = () => ask(page, () => window.digbox.frame());
  await page.focus("#canvas");
  await page.keyboard.press("Home");
  c.check("Home is the start", (await frame()) === 0);
  await page.keyboard.press("ArrowRight");
  await page.keyboard.press("ArrowRight");
  c.check("→ → is frame 2", (await frame()) === 2);
  await page.keyboard.press("ArrowLeft");
  c.check("← is frame 1", (await frame()) === 1);
  await page.keyboard.press("Shift+ArrowRight");
  c.check("shift → is ten frames", (await frame()) === 11);
  await page.keyboard.press("End");
  c.check("End is the end", (await frame()) === 120);
  await page.keyboard.press("Home");
  await page.keyboard.press(".");
  c.check(". is the first event, at frame 30", (await frame()) === 30);
  await page.keyboard.press(".");
  await page.keyboard.press(",");
  c.check(", goes back to it", (await frame()) === 30);
  await page.keyboard.press("Escape");
  c.check("Esc picks none", (await ask(page, () => window.digbox.picked())) === -1);
  await page.keyboard.press("Home");
  await page.keyboard.press(" ");
  await page.waitForFunction(() => window.digbox.time() > 0.05);
  await page.keyboard.press(" ");
  const [t, playing] = await ask(page, () => [window.digbox.time(), window.digbox.playing()]);
  c.check("space plays and pauses", t > 0.05 && !playing, [t, playing]);
  await page.waitForTimeout(100);
  c.check("paused time stands still", (await ask(page, () => window.digbox.time())) === t);
  await page.fill("#scrub", "90");
  c.check("the slider seeks", (await frame()) === 90);
}

async function judgePicking(page) {
  await seek(page, 0.5);
  const [x, y] = await ask(page, () => window.digbox.screen("turner"));
  await page.mouse.click(x, y);
  c.check("a click picks turner", (await ask(page, () => window.digbox.picked())) === 2);
  const text = await page.innerText("#state");
  c.check("the panel shows its state", /DIG 2/.test(text) && /0\.200/.test(text) && /rad\/s/.test(text), text);
  c.check("the panel lists its links", (await page.locator("#links button").count()) === 2);
  await page.locator("#links button").filter({ hasText: "flyer" }).click();
  c.check("a link leads to the other body", (await ask(page, () => window.digbox.picked())) === 1);
  await page.locator("#events button").filter({ hasText: "late is removed" }).click();
  c.check("an event jumps to its time", (await ask(page, () => window.digbox.frame())) === 90);
  await page.selectOption("#event-kind", "contact_begin");
  c.check("events are chosen by kind", (await page.locator("#events button").count()) === 1);
  await page.selectOption("#event-kind", "");
  const box = await page.locator("#energy").boundingBox();
  await page.mouse.click(box.x + 58 + (box.width - 68) / 2, box.y + 40);
  c.check("a press on the plot seeks", Math.abs((await ask(page, () => window.digbox.time())) - 1) < 0.02);
}

// Share of the picture that is of its most frequent colour, and how many colours it has (4 bits a channel).
const picture = (page, t) => ask(page, (s) => {
  window.digbox.seek(s);
  const from = document.getElementById("canvas"), to = document.createElement("canvas");
  to.width = 240;
  to.height = 120;
  const g = to.getContext("2d", { willReadFrequently: true });
  g.drawImage(from, 0, 0, 240, 120);
  const { data } = g.getImageData(0, 0, 240, 120), counts = new Map();
  for (let i = 0; i < data.length; i += 4) {
    const key = ((data[i] >> 4) << 8) | ((data[i + 1] >> 4) << 4) | (data[i + 2] >> 4);
    counts.set(key, (counts.get(key) ?? 0) + 1);
  }
  return { colours: counts.size, most: Math.max(...counts.values()) / (240 * 120), text: from.toDataURL().length };
}, t);

async function judgePage(page) {
  const seen = await picture(page, 0.5);
  c.check("the picture has many colours", seen.colours > 30 && seen.most < 0.8, seen);
  const unnamed = await ask(page, () => [...document.querySelectorAll("button, select, input")].filter((e) => e.offsetParent &&
    !(e.getAttribute("aria-label") || e.textContent.trim() || e.labels?.[0]?.textContent.trim())).map((e) => e.outerHTML));
  c.check("every control has a name", unnamed.length === 0, unnamed);
  const licences = await ask(page, () => document.querySelector("#about pre").textContent);
  c.check("the licences of what is bundled stand in the page", /three 0\.\d+/.test(licences) && (licences.match(/Permission is hereby granted/g) ?? []).length >= 2);
  for (const layer of ["links", "dig", "forces", "names"]) {
    await page.click(`[data-layer=${layer}]`);
    await page.click(`[data-layer=${layer}]`);
  }
}

const quiet = ({ errors, requests }, what) => {
  c.check(`${what}: no error`, errors.length === 0, errors);
  c.check(`${what}: asks for nothing`, requests.length === 0, requests);
};

// ---- known motions ----
const known = await openPage(browser, sample);
await judgeMotion(known.page);
await judgeLinks(known.page);
await judgePage(known.page);
await judgeCameras(known.page);
await judgePicking(known.page);
await judgeKeys(known.page);
quiet(known, "sample");
await shot(known.page, "sample.png");
await known.page.context().close();

// ---- a narrow screen that is touched, in the light ----
const narrow = await openPage(browser, sample, { width: 390, height: 780, dark: false, touch: true });
await narrow.page.locator("#next").tap();
c.check("a tap steps", (await ask(narrow.page, () => window.digbox.frame())) === 1);
c.check("nothing is wider than a narrow screen", await ask(narrow.page, () => document.documentElement.scrollWidth <= window.innerWidth));
quiet(narrow, "narrow");
await shot(narrow.page, "narrow.png");
await narrow.page.context().close();

// ---- a replay: the page says what the table of digbox export says ----
const real = await openPage(browser, run);
const [heading, ...rows] = readFileSync(table, "utf8").trim().split(/\r?\n/).map((line) => line.split(","));
const column = (row, name) => Number(row[heading.indexOf(name)]);
const frames = 1 + Math.max(...rows.map((row) => column(row, "frame")));
c.check("the script's cameras", (await ask(real.page, () => window.digbox.cameras())).join() === "chase,all");
for (const row of rows.filter((r) => r[heading.indexOf("name")] === "ball" && column(r, "frame") % 23 === 0)) {
  await seek(real.page, column(row, "time"));
  const eye = await ask(real.page, () => window.digbox.camera("chase")), ball = ["x", "y", "z"].map((k) => column(row, k));
  c.near(`the camera's target at ${column(row, "time")} s`, eye.look_at, ball, 1e-5);
  c.near(`its place at ${column(row, "time")} s`, eye.at, [ball[0] + 1, ball[1] - 0.2, ball[2] + 2], 1e-5);
}
const lit = await ask(real.page, () => window.digbox.light());
c.near("the script's sun", lit.sun, [-1, 1, 0.2].map((k) => k / Math.sqrt(2.04)), 1e-6);
c.check("its lamp and sky", lit.lamps[0].power === 80 && lit.sky === "overcast", lit);
c.check("as many frames", (await ask(real.page, () => window.digbox.facts().frames)) === frames);
for (const frame of [0, Math.floor(frames / 3), Math.floor((2 * frames) / 3), frames - 1]) {
  for (const row of rows.filter((r) => column(r, "frame") === frame)) {
    await seek(real.page, column(row, "time"));
    const s = await body(real.page, column(row, "body")), what = `${row[heading.indexOf("name")]} at frame ${frame}`;
    c.near(`position of ${what}`, s.position, ["x", "y", "z"].map((k) => column(row, k)), 1e-5);
    c.near(`rotation of ${what}`, s.rotation, ["qx", "qy", "qz", "qw"].map((k) => column(row, k)), 1e-6);
    c.near(`velocity of ${what}`, s.velocity, ["vx", "vy", "vz"].map((k) => column(row, k)), 1e-5);
    c.check(`DIG of ${what}`, s.dig === column(row, "dig"), [s.dig, column(row, "dig")]);
  }
}
// links and events, as the JSON lines tell them; efforts have 12 bits
const told_frames = readFileSync(told, "utf8").trim().split("\n").map((line) => JSON.parse(line)).filter((line) => line.links);
for (const { frame, time, links } of told_frames.filter((line) => line.frame % 17 === 0)) {
  await seek(real.page, time);
  const seen = await ask(real.page, () => window.digbox.links());
  c.check(`${links.length} links at frame ${frame}`, seen.length === links.length, seen);
  for (const l of links) {
    const effort = Math.hypot(...l.effort), same = seen.find((s) => s.a === l.a && s.b === l.b && s.kind === l.kind);
    c.near(`effort of the ${l.kind} of ${l.a} and ${l.b} at frame ${frame}`, [same?.effort], [effort], 2 ** -12 * effort);
  }
}
const kinds = (list) => [...new Set(list)].sort().map((k) => `${k} ${list.filter((x) => x === k).length}`).join();
c.check("the events are those of the replay", kinds(await ask(real.page, () => window.digbox.events().map((e) => e.kind))) === kinds(told_frames.flatMap((l) => l.events.map((e) => e.kind))),
  kinds(told_frames.flatMap((l) => l.events.map((e) => e.kind))));
await ask(real.page, () => { window.digbox.show("forces", true); window.digbox.pick("ball"); });
c.check("its events name the ball", (await ask(real.page, () => window.digbox.events().filter((e) => e.kind === "contact_begin").length)) > 0);
quiet(real, "replay");
await shot(real.page, "replay.png");
console.log(`read ${(await ask(real.page, () => window.digbox.facts().read_ms)).toFixed(1)} ms`);
await browser.close();
c.done();
