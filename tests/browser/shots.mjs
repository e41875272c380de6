// Screenshots of every section, to be looked at: node shots.mjs OUT [page ...]; a page is the name of a fixture or an .html file.
import { mkdir } from "node:fs/promises";
import { basename, resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { open, launch, pages } from "./browser.mjs";

const [out, ...wanted] = process.argv.slice(2);
await mkdir(out, { recursive: true });
const browser = await launch();
for (const asked of wanted.length ? wanted : ["wing"]) {
  const address = asked.endsWith(".html") ? pathToFileURL(resolve(asked)).href : pages(asked);
  const name = basename(asked, ".html");
  for (const [kind, viewport, scheme] of [
    ["wide-light", { width: 1400, height: 900 }, "light"], ["wide-dark", { width: 1400, height: 900 }, "dark"],
    ["phone-light", { width: 390, height: 844 }, "light"], ["phone-dark", { width: 390, height: 844 }, "dark"],
  ]) {
    const { page, context } = await open(browser, address, { viewport, colorScheme: scheme });
    for (const tab of await page.locator('[role="tab"]').all()) {
      await tab.click();
      await page.waitForTimeout(900);
      const id = (await tab.getAttribute("id")).replace("tab-", "");
      await page.screenshot({ path: `${out}/${name}-${kind}-${id}.png`, fullPage: true });
    }
    await context.close();
  }
}
await browser.close();
