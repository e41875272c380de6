// Builds the front end into dist/: one script and one style sheet that Rust embeds, and the hash that the page's
// content security policy names. `node build.mjs --check` compares with what is committed and changes nothing.
import { createHash } from "node:crypto";
import { readFile, writeFile, mkdir } from "node:fs/promises";
import { resolve } from "node:path";
import { build } from "esbuild";

const here = new URL(".", import.meta.url);
const common = {
  absWorkingDir: here.pathname, bundle: true, minify: true, write: false, format: "iife",
  target: ["es2022", "chrome110", "firefox113", "safari16.4"], charset: "ascii", legalComments: "none",
};
// `import text from "worker:./worker"`: that script bundled alone, as a text from which the page makes a worker.
const workers = {
  name: "workers",
  setup(builder) {
    builder.onResolve({ filter: /^worker:/ }, ({ path, resolveDir }) => ({ path: resolve(resolveDir, `${path.slice(7)}.ts`), namespace: "worker" }));
    builder.onLoad({ filter: /.*/, namespace: "worker" }, async ({ path }) => {
      const { outputFiles } = await build({ ...common, entryPoints: [path] });
      return { contents: outputFiles[0].text.replaceAll("\r", ""), loader: "text", watchFiles: [path] };
    });
  },
};
const result = await build({
  ...common,
  entryPoints: ["src/main.ts", "src/style.css"],
  outdir: "dist",
  plugins: [workers],
  define: { "process.env.NODE_ENV": '"production"' },
});
const text = (end) => result.outputFiles.find((f) => f.path.endsWith(end)).text.replaceAll("\r", "");

const licence = async (path) => (await readFile(new URL(`node_modules/${path}`, here), "utf8")).trim();
const version = async (name) => JSON.parse(await readFile(new URL(`node_modules/${name}/package.json`, here), "utf8")).version;
const parts = [];
for (const [name, page] of [["plotly.js-basic-dist-min", "https://plotly.com/javascript/"], ["three", "https://threejs.org/"], ["fflate", "https://101arrowz.github.io/fflate/"]]) {
  parts.push(`## ${name} ${await version(name)}\n\n<${page}>\n\n\`\`\`text\n${await licence(`${name}/LICENSE`)}\n\`\`\`\n`);
}
const notice = `# Third-party software in the report\n\nThe page that \`retune report\` writes embeds these libraries, minified. Written by \`build.mjs\`.\n\n${parts.join("\n")}`;

const versions = `three.js ${await version("three")}, plotly.js ${await version("plotly.js-basic-dist-min")} and fflate ${await version("fflate")}`;
const licences = await Promise.all(["three", "plotly.js-basic-dist-min", "fflate"].map((name) => licence(`${name}/LICENSE`)));
const banner = `/*! retune report. Contains ${versions}, all under the MIT licence:\n${licences.join("\n\n").replaceAll("*/", "* /")}\n*/\n`;
const script = banner + text("main.js");
const style = text("style.css");
// Inside <script>, HTML ends the element at "</script" and changes its rules at "<!--": neither may occur.
for (const [name, content, banned] of [["report.js", script, /<\/script|<!--|<script/i], ["report.css", style, /<\/style|<!--/i]]) {
  const found = content.match(banned);
  if (found) throw new Error(`${name} contains ${found[0]} at ${found.index}: ${content.slice(found.index - 60, found.index + 60)}`);
}
const hash = `sha256-${createHash("sha256").update(script, "utf8").digest("base64")}`;
const files = { "dist/report.js": script, "dist/report.css": style, "dist/report.js.hash": hash, "THIRD_PARTY.md": notice };

if (process.argv.includes("--check")) {
  let same = true;
  for (const [path, content] of Object.entries(files)) {
    const committed = await readFile(new URL(path, here), "utf8").catch(() => "");
    if (committed !== content) {
      console.error(`${path} is not what a fresh build gives: run \`npm ci && npm run build\` in src/report/web and commit it`);
      same = false;
    }
  }
  process.exit(same ? 0 : 1);
}
await mkdir(new URL("dist", here), { recursive: true });
for (const [path, content] of Object.entries(files)) await writeFile(new URL(path, here), content);
console.log(`dist/report.js ${(script.length / 1e6).toFixed(2)} MB, dist/report.css ${(style.length / 1e3).toFixed(1)} kB, ${hash}`);
