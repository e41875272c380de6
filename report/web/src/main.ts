/** Builds the page from its data. */

import { charts } from "./charts";
import { textOfPage } from "./decode";
import { badge, h, soft, type Child } from "./dom";
import { fixed, minuses, percent, powers, quoted, slug } from "./format";
import { diagnosesSection, outcomeWords } from "./sections/diagnosis";
import { frfsSection } from "./sections/frfs";
import { identificationSection } from "./sections/identification";
import { liveSection } from "./sections/live";
import { modesSection } from "./sections/modes";
import { pairsSection } from "./sections/pairs";
import { posteriorSection } from "./sections/posterior";
import { provenanceSection } from "./sections/provenance";
import { stepsSection } from "./sections/steps";
import { structureSection } from "./sections/structure";
import { hasUpdate, updateName, updateSection } from "./sections/update";
import { viewers } from "./viewer";
import { sheetsOf, workbook } from "./workbook";
import type { Comparison, ReportData, TestRecord, Verdict } from "./types";

interface Tab { id: string; name: string; build: () => HTMLElement }

function tabsOf(data: ReportData, save: () => void, saveTables: () => void): Tab[] {
  const tabs: (Tab | false | undefined)[] = [
    data.identification && { id: "identification", name: "Identification", build: () => identificationSection(data.identification!, data.modes) },
    data.structure && { id: "structure", name: "Structure", build: () => structureSection(data.structure!, data.localization) },
    data.structure && (data.modes.model.length > 0 || data.modes.test.length > 0)
      && { id: "modes", name: "Mode shapes", build: () => modesSection(data.structure!, data.modes, data.comparison) },
    !!data.live?.length && { id: "live", name: "Live", build: () => liveSection(data) },
    data.comparison && { id: "pairs", name: "Pairs", build: () => pairsSection(data.comparison!, data.modes, data.structure) },
    data.frfs && data.frfs.channels.length > 0 && { id: "frfs", name: "FRFs", build: () => frfsSection(data.frfs!) },
    data.posterior && data.posterior.parameters.length > 0 && { id: "posterior", name: "Posterior", build: () => posteriorSection(data.posterior!) },
    data.update && hasUpdate(data.update) && { id: "update", name: updateName(data.update), build: () => updateSection(data.update!) },
    data.steps && data.steps.steps.length > 0 && { id: "steps", name: "Error falling", build: () => stepsSection(data.steps!) },
    data.diagnosis && { id: "diagnosis", name: "Diagnosis", build: () => diagnosesSection(data.earlier_diagnoses ?? [], data.diagnosis!, data.structure, data.meta.verdict?.sentence ?? "") },
    { id: "provenance", name: "Provenance", build: () => provenanceSection(data.meta, save, saveTables) },
  ];
  return tabs.filter((t): t is Tab => !!t);
}

/** What stands beside the sentence: of a diagnosis its outcome, of a comparison whether the model explains the test. */
function levelWords(data: ReportData, level: Verdict["level"]): string {
  if (data.diagnosis) return outcomeWords(data.diagnosis);
  if (!data.comparison) return { good: "in order", warning: "look closer", bad: "not in order", neutral: "for information" }[level];
  return { good: "the model explains the test", warning: "look closer", bad: "the model does not explain the test", neutral: "for information" }[level];
}

function glance(c: Comparison): HTMLElement | null {
  if (!c.pairs.length) return null;
  const judged = c.pairs.filter((p) => p.passes != null);
  const errors = c.pairs.map((p) => p.error).filter(Number.isFinite);
  const macs = c.pairs.map((p) => p.mac).filter((m): m is number => m != null);
  const worst = errors.reduce((a, b) => (Math.abs(b) > Math.abs(a) ? b : a), 0);
  const facts: [string, string][] = [
    ["paired modes", String(c.pairs.length)],
    ...(judged.length ? [["meet the criteria", `${judged.filter((p) => p.passes).length} of ${judged.length}`] as [string, string]] : []),
    ...(errors.length ? [["largest frequency error", percent(worst)] as [string, string]] : []),
    ...(macs.length ? [["lowest MAC", fixed(Math.min(...macs), 2)] as [string, string]] : []),
  ];
  return h("dl", { class: "glance" }, facts.map(([k, v]) => h("div", {}, h("dt", {}, k), h("dd", {}, v))));
}

/** The first clause of a sentence is the headline; what follows is said once, below it, in smaller type. */
export function headline(sentence: string): [string, string] {
  const end = /[;.:]\s/.exec(sentence);
  return end && sentence.length > 70 ? [sentence.slice(0, end.index), sentence.slice(end.index)] : [sentence, ""];
}

/** The days on which the tests were measured; which test has which stands in the section on provenance. */
function measured(tests: TestRecord[]): HTMLElement | null {
  const days = [...new Set(tests.flatMap((t) => (t.date ? [t.date] : [])))].sort();
  if (!tests.length) return null;
  const of = tests.length === 1 ? tests[0]!.content : `${tests.length} tests`;
  const when = days.length === 0 ? "" : days.length === 1 ? `measured on ${days[0]}` : `measured from ${days[0]} to ${days.at(-1)}`;
  return of || when ? h("p", { class: "subtitle measured", id: "measured" }, [of, when].filter(Boolean).join(", ")) : null;
}

function head(data: ReportData, theme: Child): HTMLElement {
  const { title, subtitle, verdict } = data.meta;
  const [first, rest] = headline(quoted(powers(verdict?.sentence ?? "")));
  return h("header", { class: "top" },
    h("div", { class: "title-row" },
      h("div", {}, h("p", { class: "brand" }, "retune report"), h("h1", {}, title || "Report"), subtitle ? h("p", { class: "subtitle" }, subtitle) : null, measured(data.meta.tests ?? [])),
      theme),
    verdict ? h("section", { class: `verdict ${verdict.level}`, "aria-label": "Verdict", id: "verdict" },
      h("div", { class: "verdict-text" }, badge(verdict.level, levelWords(data, verdict.level)), h("div", { class: "said" }, h("p", { class: "sentence", title: first.length > 120 ? first : null }, soft(first)),
        rest ? h("p", { class: "rest" }, h("span", { class: "visually-hidden" }, rest.slice(0, 2)), h("span", { class: "rest-text" }, soft(rest.slice(2)))) : null),
        data.comparison ? glance(data.comparison) : null),
      verdict.number ? h("div", { class: "verdict-number" }, h("span", { class: verdict.number.length > 9 ? "big long" : "big" }, minuses(verdict.number)), h("span", { class: "big-label" }, soft(verdict.number_label))) : null) : null);
}

function themeButton(): HTMLElement {
  const root = document.documentElement;
  const system = matchMedia("(prefers-color-scheme: dark)");
  const isDark = (): boolean => root.dataset["theme"] === "dark";
  root.dataset["theme"] = system.matches ? "dark" : "light";
  const say = (): void => {
    button.textContent = isDark() ? "☀ Light" : "☾ Dark";
  };
  const button = h("button", { type: "button", class: "theme", id: "theme", "aria-label": "Switch between dark and light",
    onclick: () => {
      root.dataset["theme"] = isDark() ? "light" : "dark";
      say();
      retheme();
    } });
  say();
  system.addEventListener("change", () => {
    root.dataset["theme"] = system.matches ? "dark" : "light";
    say();
    retheme();
  });
  return button;
}

function retheme(): void {
  for (const v of viewers) v.retheme();
  for (const c of charts) c.refresh();
  document.dispatchEvent(new Event("retheme"));
}

/** Moves the row of tabs, and nothing else, until a tab is in sight: in a frame `scrollIntoView` would move the page and what is around it. */
function reveal(tab: HTMLElement): void {
  const row = tab.parentElement!, from = tab.offsetLeft - row.offsetLeft, to = from + tab.offsetWidth;
  if (from < row.scrollLeft) row.scrollLeft = from;
  else if (to > row.scrollLeft + row.clientWidth) row.scrollLeft = to - row.clientWidth;
}

function start(): void {
  const root = document.getElementById("report")!;
  const text = textOfPage(document.getElementById("report-data"));
  const data = JSON.parse(text) as ReportData;
  const save = (): void => {
    const link = h("a", { href: URL.createObjectURL(new Blob([text], { type: "application/json" })), download: `${slug(data.meta.title)}.json` });
    link.click();
    URL.revokeObjectURL(link.href);
  };
  const saveTables = (): void => {
    for (const t of tabs) build(t);
    const bytes = workbook(sheetsOf([...panels.values()], data));
    const link = h("a", { href: URL.createObjectURL(new Blob([bytes], { type: "application/vnd.openxmlformats-officedocument.spreadsheetml.sheet" })), download: `${slug(data.meta.title)}.xlsx` });
    link.click();
    URL.revokeObjectURL(link.href);
  };
  const tabs = tabsOf(data, save, saveTables);
  const built = new Set<string>();
  const panels = new Map(tabs.map((t) => [t.id, h("section", { role: "tabpanel", id: `panel-${t.id}`, class: "panel", "aria-labelledby": `tab-${t.id}`, "data-title": t.name, hidden: true })]));
  const build = (t: Tab): void => {
    if (built.has(t.id)) return;
    built.add(t.id);
    panels.get(t.id)!.append(h("h2", { class: "panel-title" }, t.name), t.build());
  };
  const buttons = tabs.map((t) => h("button", { type: "button", role: "tab", id: `tab-${t.id}`, "aria-controls": `panel-${t.id}`, onclick: () => open(t.id, true) }, t.name));
  const open = (id: string, push: boolean): void => {
    // What follows a slash is the section's own.
    const tab = tabs.find((t) => t.id === id.split("/")[0]) ?? tabs[0]!;
    for (const [i, t] of tabs.entries()) {
      const on = t === tab;
      buttons[i]!.setAttribute("aria-selected", String(on));
      buttons[i]!.tabIndex = on ? 0 : -1;
      panels.get(t.id)!.hidden = !on;
      if (on) reveal(buttons[i]!);
    }
    build(tab);
    if (push && location.hash !== `#${tab.id}`) history.replaceState(null, "", `#${tab.id}`);
  };
  const list = h("div", { role: "tablist", class: "tabs", "aria-label": "Sections",
    onkeydown: (event: Event) => {
      const e = event as KeyboardEvent;
      const at = buttons.findIndex((b) => b.getAttribute("aria-selected") === "true");
      const to = { ArrowRight: at + 1, ArrowLeft: at - 1, Home: 0, End: tabs.length - 1 }[e.key];
      if (to == null) return;
      e.preventDefault();
      const i = (to + tabs.length) % tabs.length;
      open(tabs[i]!.id, true);
      buttons[i]!.focus();
    } }, buttons);
  root.replaceChildren(head(data, themeButton()), h("nav", { class: "tabs-bar", "aria-label": "Report" }, list), h("main", {}, [...panels.values()]));
  open(location.hash.slice(1), false);
  addEventListener("hashchange", () => open(location.hash.slice(1), false));

  // Paper shows every section, in light colours, at the width of a page.
  let before: { theme: string | undefined; hidden: boolean[] } | null = null;
  addEventListener("beforeprint", () => {
    if (before) return;
    before = { theme: document.documentElement.dataset["theme"], hidden: [...panels.values()].map((p) => !!p.hidden) };
    document.documentElement.dataset["theme"] = "light";
    document.documentElement.classList.add("printing");
    for (const t of tabs) build(t);
    for (const p of panels.values()) p.hidden = false;
    for (const v of viewers) v.retheme();
    document.dispatchEvent(new Event("retheme"));
    for (const c of charts) c.redraw(c.root.clientWidth);
    for (const v of viewers) v.drawForPaper();
  });
  addEventListener("afterprint", () => {
    if (!before) return;
    document.documentElement.dataset["theme"] = before.theme ?? "light";
    document.documentElement.classList.remove("printing");
    [...panels.values()].forEach((p, i) => (p.hidden = before!.hidden[i]!));
    before = null;
    retheme();
  });
  globalThis.retuneReport = { viewers, data };
  document.documentElement.dataset["ready"] = "true";
}

start();

/** For the console and for the tests: the data, and the viewers of the page in the order of their sections. */
declare global {
  var retuneReport: { viewers: typeof viewers; data: ReportData };
}
