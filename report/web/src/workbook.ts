/** All tables of the page as one workbook: SpreadsheetML, ECMA-376 part 1, sections 18.2 to 18.4. */

import { strToU8, zipSync } from "fflate";
import { textOf } from "./dom";

/** A cell: text, or a number with whether it is a share. */
export type Cell = string | { value: number; percent: boolean };
export interface Sheet { name: string; rows: Cell[][] }

/** Text inside XML: no markup, and none of the control characters that XML cannot hold. */
const xml = (text: string): string => text.replace(/[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\u{10000}-\u{10ffff}]/gu, "\ufffd").replace(/&/g, "&amp;").replace(/</g, "&lt;").replace(/>/g, "&gt;").replace(/"/g, "&quot;");

/** A name that a sheet may have, and that no other has: 31 characters, none of []:*?/\. */
function named(names: string[]): string[] {
  const used = new Set<string>();
  return names.map((wanted, i) => {
    const plain = wanted.replace(/[[\]:*?/\\]/g, " ").replace(/\s+/g, " ").trim().replace(/^'+|'+$/g, "") || `Table ${i + 1}`;
    let name = plain.slice(0, 31);
    for (let k = 2; used.has(name.toLowerCase()); k++) name = `${plain.slice(0, 31 - ` ${k}`.length)} ${k}`;
    used.add(name.toLowerCase());
    return name;
  });
}

/** `A`, `B`, ... `Z`, `AA`, ... */
export function columnName(index: number): string {
  return (index >= 26 ? columnName(Math.floor(index / 26) - 1) : "") + String.fromCharCode(65 + (index % 26));
}

function sheetXml(rows: Cell[][]): string {
  const widths = rows.reduce<number[]>((all, row) => {
    row.forEach((c, j) => { all[j] = Math.min(60, Math.max(all[j] ?? 9, typeof c === "string" ? [...c].length + 2 : 12)); });
    return all;
  }, []);
  const cell = (c: Cell, i: number, j: number): string => {
    const at = `${columnName(j)}${i + 1}`;
    if (typeof c === "string") return c ? `<c r="${at}" t="inlineStr"${i ? "" : ' s="2"'}><is><t xml:space="preserve">${xml(c)}</t></is></c>` : "";
    return `<c r="${at}"${c.percent ? ' s="1"' : ""}><v>${c.value}</v></c>`;
  };
  return `<?xml version="1.0" encoding="UTF-8" standalone="yes"?><worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main">`
    + `<sheetViews><sheetView workbookViewId="0"><pane ySplit="1" topLeftCell="A2" activePane="bottomLeft" state="frozen"/></sheetView></sheetViews>`
    + (widths.length ? `<cols>${widths.map((w, j) => `<col min="${j + 1}" max="${j + 1}" width="${w ?? 9}" customWidth="1"/>`).join("")}</cols>` : "")
    + `<sheetData>${rows.map((row, i) => `<row r="${i + 1}">${row.map((c, j) => cell(c, i, j)).join("")}</row>`).join("")}</sheetData></worksheet>`;
}

/** The bytes of an .xlsx file. */
export function workbook(sheets: Sheet[]): Uint8Array<ArrayBuffer> {
  const head = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>', names = named(sheets.map((s) => s.name));
  const main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main", office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
  const packages = "http://schemas.openxmlformats.org/package/2006", types = "application/vnd.openxmlformats-officedocument.spreadsheetml";
  const files: Record<string, string> = {
    "[Content_Types].xml": `${head}<Types xmlns="${packages}/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="xml" ContentType="application/xml"/>`
      + `<Override PartName="/xl/workbook.xml" ContentType="${types}.sheet.main+xml"/><Override PartName="/xl/styles.xml" ContentType="${types}.styles+xml"/>`
      + `${names.map((_, i) => `<Override PartName="/xl/worksheets/sheet${i + 1}.xml" ContentType="${types}.worksheet+xml"/>`).join("")}</Types>`,
    "_rels/.rels": `${head}<Relationships xmlns="${packages}/relationships"><Relationship Id="rId1" Type="${office}/officeDocument" Target="xl/workbook.xml"/></Relationships>`,
    "xl/workbook.xml": `${head}<workbook xmlns="${main}" xmlns:r="${office}"><sheets>${names.map((n, i) => `<sheet name="${xml(n)}" sheetId="${i + 1}" r:id="rId${i + 1}"/>`).join("")}</sheets></workbook>`,
    "xl/_rels/workbook.xml.rels": `${head}<Relationships xmlns="${packages}/relationships">${names.map((_, i) => `<Relationship Id="rId${i + 1}" Type="${office}/worksheet" Target="worksheets/sheet${i + 1}.xml"/>`).join("")}`
      + `<Relationship Id="rId${names.length + 1}" Type="${office}/styles" Target="styles.xml"/></Relationships>`,
    // Formats: plain, a share, a head.
    "xl/styles.xml": `${head}<styleSheet xmlns="${main}"><fonts count="2"><font><sz val="11"/><name val="Calibri"/></font><font><b/><sz val="11"/><name val="Calibri"/></font></fonts>`
      + '<fills count="2"><fill><patternFill patternType="none"/></fill><fill><patternFill patternType="gray125"/></fill></fills><borders count="1"><border/></borders>'
      + '<cellStyleXfs count="1"><xf numFmtId="0" fontId="0" fillId="0" borderId="0"/></cellStyleXfs>'
      + '<cellXfs count="3"><xf numFmtId="0" fontId="0" fillId="0" borderId="0" xfId="0"/><xf numFmtId="10" fontId="0" fillId="0" borderId="0" xfId="0" applyNumberFormat="1"/><xf numFmtId="0" fontId="1" fillId="0" borderId="0" xfId="0" applyFont="1"/></cellXfs><cellStyles count="1"><cellStyle name="Normal" xfId="0" builtinId="0"/></cellStyles></styleSheet>',
  };
  sheets.forEach((s, i) => { files[`xl/worksheets/sheet${i + 1}.xml`] = sheetXml(s.rows); });
  // One time for all: the same tables are the same bytes.
  return zipSync(Object.fromEntries(Object.entries(files).map(([name, text]) => [name, strToU8(text)])), { mtime: new Date(1980, 0, 1) }) as Uint8Array<ArrayBuffer>;
}

/** A cell of a table of the page: the number of the data behind it where there is one, else a number that the text is, else the text. */
function cellOf(cell: HTMLTableCellElement, data: unknown): Cell {
  const text = textOf(cell).trim().replace(/\s+/g, " ").replace(/^–$/, "");
  const spans = cell.querySelectorAll<HTMLElement>("[data-json]"), only = spans.length === 1 ? spans[0]! : null;
  if (only && only.textContent!.trim() === (cell.textContent ?? "").trim()) {
    const value = only.dataset["json"]!.split(".").reduce<unknown>((at, key) => (at as Record<string, unknown> | undefined)?.[key], data);
    // Shares stand in the data as such and on the page in percent.
    if (typeof value === "number") return { value, percent: text.endsWith("%") };
  }
  const plain = text.replace(/−/g, "-").replace(/^\+/, ""), percent = / ?%$/.test(plain), bare = plain.replace(/ ?%$/, "");
  if (/^-?\d+(\.\d+)?(e-?\d+)?$/.test(bare)) return { value: percent ? Number(bare) / 100 : Number(bare), percent };
  return text;
}

/** The tables of some panels, each with its caption. */
export function sheetsOf(panels: Iterable<HTMLElement>, data: unknown): Sheet[] {
  return [...panels].flatMap((panel) => [...panel.querySelectorAll("table")].map((t) => ({
    name: t.closest("[role=region]")?.getAttribute("aria-label") ?? panel.dataset["title"] ?? "", rows: [...t.rows].map((row) => [...row.cells].map((c) => cellOf(c, data))) })));
}
