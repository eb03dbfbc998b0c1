// open.mjs - what it takes to open a page of `digbox view` in headless Chromium, from its address to its first picture:
// wall time, processor time of the page's process and of the process that draws, and what the page says of itself.
//
//   NODE_MODULES=... CHROMIUM=... node open.mjs PAGE.html [REPEATS]        (make bench SCENE=page calls it)
//
// Every time in a browser of its own. The medians stand in the last line; on a machine that does other things only processor time counts.
import { readFileSync, statSync } from "node:fs";
import { launch, openPage } from "./browser.mjs";

const [path, repeats = "3"] = process.argv.slice(2), rows = [];

// CPU seconds of pages and of what draws. The browser's own windows (of its address bar) are pages too, which are not ours.
async function cpu(session) {
  const { processInfo } = await session.send("SystemInfo.getProcessInfo");
  const own = processInfo.filter((p) => !readFileSync(`/proc/${p.id}/cmdline`, "utf8").includes("--top-chrome-webui"));
  const of = (kind) => own.filter((p) => p.type === kind).reduce((sum, p) => sum + p.cpuTime, 0);
  return { page: of("renderer"), draws: of("GPU"), all: processInfo.reduce((sum, p) => sum + p.cpuTime, 0) };
}

// Until the browser has done what it does after its start.
async function settle(session) {
  for (let before = -1, now = 0, tries = 0; now - before > 0.02 && tries < 60; tries++) {
    await new Promise((done) => setTimeout(done, 500));
    [before, now] = [now, (await cpu(session)).all];
  }
  return cpu(session);
}

for (let i = 0; i < Number(repeats); i++) {
  const browser = await launch(), session = await browser.newBrowserCDPSession();
  await (await browser.newContext()).newPage();         // wakes the windows
  const before = await settle(session), began = performance.now();
  const { page, errors } = await openPage(browser, path);
  const facts = await page.evaluate(() => window.digbox.ready);
  await page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  const wall = (performance.now() - began) / 1000, after = await cpu(session);
  if (errors.length > 0) throw new Error(errors.join("; "));
  rows.push([wall, after.page - before.page, after.draws - before.draws, facts.read_ms / 1000, facts.begin_ms / 1000]);
  await browser.close();
}

const median = (list) => list.sort((a, b) => a - b)[list.length >> 1], column = (k) => median(rows.map((r) => r[k])).toFixed(2);
console.log(`${(statSync(path).size / 1e6).toFixed(2)} MB: ${column(0)} s to the first picture; CPU: ${column(1)} s page (its scripts: data ${column(3)} s, all ${column(4)} s of wall time), ${column(2)} s process that draws`);
