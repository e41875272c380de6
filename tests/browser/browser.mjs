// Chromium, and how a page of the report is opened in it.
import { existsSync, mkdtempSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";

export const chromium = [process.env.CHROMIUM, "/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"]
  .find((path) => path && existsSync(path));

const target = process.env.CARGO_TARGET_DIR ?? fileURLToPath(new URL("../../target", import.meta.url));
export const folder = join(target, "report_fixture");
/** Address of a fixture page, opened from disk as a reader would. */
export const pages = (name) => pathToFileURL(join(folder, `${name}.html`)).href;

export async function launch() {
  const { chromium: driver } = await import("playwright-core");
  return driver.launch({
    executablePath: chromium,
    headless: true,
    args: ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
      "--disable-sync", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--ignore-gpu-blocklist",
      `--crash-dumps-dir=${mkdtempSync(join(tmpdir(), "retune-"))}`],
  });
}

/** Opens a page; `errors` collects what goes wrong in it and every request that would leave it. */
export async function open(browser, address, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1400, height: 900 }, ...options });
  const page = await context.newPage();
  const errors = [];
  page.on("console", (m) => {
    // The software renderer of a headless browser reports its own read-back stalls; they say nothing about the page.
    if (["error", "warning"].includes(m.type()) && !/GPU stall due to ReadPixels|swiftshader|SwiftShader/i.test(m.text())) errors.push(m.text());
  });
  page.on("pageerror", (e) => errors.push(String(e.stack ?? e)));
  page.on("request", (r) => {
    if (!/^(file|blob|data):/.test(r.url())) errors.push(`asks the network: ${r.url()}`);
  });
  const start = performance.now();
  await page.goto(address);
  await page.waitForSelector('html[data-ready="true"]', { timeout: 20000 });
  return { page, context, errors, milliseconds: performance.now() - start };
}
