// build.mjs - makes the page of `digbox view`: one HTML file with all scripts in it, without data.
//
//   node build.mjs NODE_MODULES LICENSE OUT.html       (make viewer calls it)
//
// The licence texts of what is bundled stand in the page itself.
import { createRequire } from "node:module";
import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const [modules, licence, out] = process.argv.slice(2).map((path) => resolve(path));
const here = dirname(fileURLToPath(import.meta.url));
const esbuild = createRequire(join(modules, "any.js"))("esbuild");
const source = (name) => readFileSync(join(here, "src", name), "utf8");

const result = await esbuild.build({
  entryPoints: [join(here, "src", "main.js")],
  bundle: true, minify: true, write: false, format: "iife", target: ["es2022"], legalComments: "none", charset: "utf8", metafile: true,
  nodePaths: [modules], logLevel: "warning",
});
const style = await esbuild.transform(source("page.css"), { loader: "css", minify: true, charset: "utf8" });

// Every package that a byte of the bundle comes from.
const used = new Set();
for (const [path, { bytesInOutput }] of Object.entries(Object.values(result.metafile.outputs)[0].inputs)) {
  const name = path.match(/node_modules\/((?:@[^/]+\/)?[^/]+)\//)?.[1];
  if (name && bytesInOutput > 0) used.add(name);
}
const texts = [`digbox\n\n${readFileSync(licence, "utf8")}`];
for (const name of [...used].sort()) {
  const { version } = JSON.parse(readFileSync(join(modules, name, "package.json"), "utf8"));
  texts.push(`${name} ${version}\n\n${readFileSync(join(modules, name, "LICENSE"), "utf8")}`);
}
const escape = (text) => text.replace(/&/g, "&amp;").replace(/</g, "&lt;");
const script = result.outputFiles[0].text.trim().replace(/<\/(script)/gi, "<\\/$1").replace(/<!--/g, "<\\!--");

const parts = { STYLE: style.code.trim(), LICENCES: escape(texts.join("\n\n")), SCRIPT: script };
const page = source("page.html").replace(/\/\*(STYLE|LICENCES|SCRIPT)\*\//g, (_, name) => parts[name]);
writeFileSync(out, page);
