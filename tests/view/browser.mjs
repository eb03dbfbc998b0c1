// browser.mjs - headless Chromium for the tests of the page: opens a file, notes every error and every request that leaves it.
//
// NODE_MODULES is the folder with playwright-core; CHROMIUM the browser.
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const { chromium } = createRequire(join(resolve(process.env.NODE_MODULES), "any.js"))("playwright-core");

export async function launch() {
  return chromium.launch({ executablePath: process.env.CHROMIUM, headless: true, timeout: 60000,
    args: ["--no-sandbox", "--disable-gpu", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"] });
}

// { page, errors, requests }: errors of the console and of scripts, and addresses that were asked for beyond the file itself.
export async function openPage(browser, path, { width = 1280, height = 720, dark = true, touch = false } = {}) {
  const context = await browser.newContext({ viewport: { width, height }, colorScheme: dark ? "dark" : "light", offline: true, hasTouch: touch });
  const page = await context.newPage(), errors = [], requests = [];
  page.setDefaultTimeout(60000);
  page.on("console", (m) => { if (m.type() === "error" || (m.type() === "warning" && !/GPU stall|software WebGL|GL Driver Message/i.test(m.text()))) errors.push(`${m.type()}: ${m.text()}`); });
  page.on("pageerror", (e) => errors.push(`script: ${e.message}`));
  const address = pathToFileURL(resolve(path)).href;
  page.on("request", (r) => { if (r.url() !== address && !/^(data|blob):/.test(r.url())) requests.push(r.url()); });
  await page.goto(address, { waitUntil: "load" });
  await page.evaluate(() => window.digbox.ready);
  return { page, errors, requests };
}

// check(what, true or false), then done(): prints the line that counts.
export function checks() {
  let passed = 0, failed = 0;
  return {
    check(what, fine, detail = "") {
      if (fine) passed++;
      else { failed++; console.log(`not so: ${what}${detail === "" ? "" : ` (${JSON.stringify(detail)})`}`); }
    },
    near(what, got, want, tolerance) {
      const fine = Array.isArray(got) && got.length === want.length && got.every((x, i) => Math.abs(x - want[i]) <= tolerance);
      this.check(`${what} is ${JSON.stringify(want)} +- ${tolerance}`, fine, got);
    },
    done() {
      console.log(`${passed} passed, ${failed} failed`);
      process.exitCode = failed ? 1 : 0;
    },
  };
}
