/** Elements without markup: every text goes in as a text node, so a name from a file can never become code. */

import { MISSING, slug } from "./format";

type Attributes = Record<string, string | number | boolean | null | undefined | ((event: Event) => void)>;
export type Child = Node | string | null | undefined | false | Child[];

function append(parent: Node, child: Child): void {
  if (child == null || child === false) return;
  if (Array.isArray(child)) for (const c of child) append(parent, c);
  else parent.appendChild(typeof child === "string" ? document.createTextNode(child) : child);
}

function fill<E extends globalThis.Element>(element: E, attributes: Attributes, children: Child[]): E {
  for (const [name, value] of Object.entries(attributes)) {
    if (value == null || value === false) continue;
    if (typeof value === "function") element.addEventListener(name.replace(/^on/, ""), value);
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  append(element, children);
  return element;
}

/** An HTML element; attributes that are functions become listeners. */
export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  return fill(document.createElement(tag), attributes, children);
}

/** Text that may break after the signs that join the parts of a name; copied, it is the same text. */
export function soft(text: string): Child[] {
  return text.split(/(?<=[@+_.:/]|[a-z]-)(?=[A-Za-z])/).flatMap((part, i) => (i ? [h("wbr"), part] : [part]));
}

/** An SVG element. */
export function s<K extends keyof SVGElementTagNameMap>(
  tag: K, attributes: Attributes = {}, ...children: Child[]
): SVGElementTagNameMap[K] {
  return fill(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

/** A number of the page that names its place in the data, so that a test can hold one against the other. */
export function num(text: string, path: string, scale = 1): HTMLElement {
  return text === MISSING
    ? h("span", { class: "num missing", title: "not available" }, text)
    : h("span", { class: "num", "data-json": path, "data-scale": scale === 1 ? null : scale }, text);
}

/** Whether the page is dark now. */
export function isDark(): boolean {
  return document.documentElement.dataset["theme"] === "dark";
}

/** A cell of a CSV file: quoted where it must be; what a spreadsheet would take for a formula stays text. */
export function csvCell(text: string): string {
  const plain = text.trim().replace(/\s+/g, " ").replace(/−/g, "-").replace(/^–$/, "");
  const safe = /^[=@+\t]/.test(plain) && !/^\+[\d.]+( %)?$/.test(plain) || /^-(?![\d.])/.test(plain) ? `'${plain}` : plain;
  return /[",\n]/.test(safe) ? `"${safe.replace(/"/g, '""')}"` : safe;
}

/** What a cell of a table says, without signs that only decorate it. */
export function textOf(cell: HTMLTableCellElement): string {
  if (cell.dataset["csv"] != null) return cell.dataset["csv"];
  const own = cell.cloneNode(true) as HTMLElement;
  own.querySelectorAll('[aria-hidden="true"]').forEach((e) => e.remove());
  return own.textContent ?? "";
}

/** A button that saves a table of the page as CSV. */
export function csvButton(name: string, of: () => HTMLTableElement | null): HTMLElement {
  return h("button", { type: "button", class: "csv", title: `Save “${name}” as CSV`, "aria-label": `Save ${name} as CSV`, onclick: () => {
    const rows = [...(of()?.rows ?? [])].map((row) => [...row.cells].map((c) => csvCell(textOf(c))).join(","));
    const link = h("a", { href: URL.createObjectURL(new Blob([`\ufeff${rows.join("\r\n")}\r\n`], { type: "text/csv" })), download: `${slug(name)}.csv` });
    link.click();
    URL.revokeObjectURL(link.href);
  } }, "CSV");
}

export interface Column { head: Child; numeric?: boolean; title?: string }

/** A table that scrolls sideways inside its own box. */
export function table(caption: string, columns: Column[], rows: Child[][], options: { id?: string } = {}): HTMLElement {
  const own = h("table", { id: options.id ?? null },
    h("caption", { class: "visually-hidden" }, caption),
    h("thead", {}, h("tr", {}, columns.map((c) =>
      h("th", { scope: "col", class: c.numeric ? "right" : null, title: c.title ?? null }, c.head)))),
    h("tbody", {}, rows.map((row) => h("tr", {}, row.map((cell, i) =>
      h("td", { class: columns[i]?.numeric ? "right" : null, "data-head": headOf(columns[i]) }, cell))))));
  return h("div", { class: "tabled" }, csvButton(caption, () => own), h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": caption }, own));
}

/** What stands before a cell where a narrow screen has no room for a row of heads. */
const headOf = (column: Column | undefined): string | null =>
  column?.numeric && typeof column.head === "string" ? column.head : null;

/** A titled card. */
export function card(title: string, note: Child, ...children: Child[]): HTMLElement {
  return h("section", { class: "card" },
    h("header", { class: "card-head" }, h("h3", {}, title), note ? h("p", { class: "note" }, note) : null),
    ...children);
}

/** One of several exclusive choices as a row of buttons. */
export function choice<T extends string>(
  label: string, options: { value: T; text: string }[], initial: T, change: (value: T) => void,
): HTMLElement {
  const buttons = options.map(({ value, text }) =>
    h("button", { type: "button", class: "segment", "aria-pressed": String(value === initial), "data-value": value,
      onclick: () => {
        for (const b of buttons) b.setAttribute("aria-pressed", String(b.dataset["value"] === value));
        change(value);
      } }, soft(text)));
  return h("div", { class: "segments", role: "group", "aria-label": label }, buttons);
}

/** A check box with its label. */
export function toggle(text: string, initial: boolean, change: (on: boolean) => void, id?: string): HTMLElement {
  const box = h("input", { type: "checkbox", id: id ?? null, onchange: () => change(box.checked) });
  box.checked = initial;
  return h("label", { class: "toggle" }, box, text);
}

/** A pill with a sign and a word: never colour alone. */
export function badge(level: "good" | "warning" | "bad" | "neutral", text: string): HTMLElement {
  const sign = { good: "✓", warning: "!", bad: "✕", neutral: "•" }[level];
  return h("span", { class: `badge ${level}` }, h("span", { "aria-hidden": "true", class: "sign" }, sign), text);
}
