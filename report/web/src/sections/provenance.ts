/** Where everything comes from, so that somebody else can repeat it. */

import { badge, card, h, soft, table } from "../dom";
import type { Meta, Named } from "../types";

function pairs(list: Named[]): HTMLElement {
  return h("dl", { class: "facts wide" }, list.map((n) => [h("dt", {}, n.name), h("dd", {}, n.text)]));
}

export function provenanceSection(meta: Meta, download: () => void, tables: () => void): HTMLElement {
  return h("div", { class: "stack" },
    meta.warnings.length ? card("Read this first", null, h("ul", { class: "warnings" }, meta.warnings.map((w) => h("li", {}, w)))) : null,
    meta.tests?.length ? card("Tests", null, table("Tests", [{ head: "Test" }, { head: "Measured on" }, { head: "Configuration" }, { head: "What it has" }],
      meta.tests.map((t) => [h("strong", {}, soft(t.name)), t.date ?? "–", t.configuration ?? "–", t.content]), { id: "tests-table" })) : null,
    meta.data_items.length ? card("Data", null, table("Data", [{ head: "What" }, { head: "Origin" }, { head: "Source" }],
      meta.data_items.map((d) => [h("strong", {}, d.name), badge(d.origin === "measured" ? "good" : "neutral", d.origin), d.source]), { id: "data-table" })) : null,
    meta.commands.length ? card("To repeat it", null, h("pre", { tabindex: 0 }, meta.commands.map((c) => `$ ${c}`).join("\n"))) : null,
    meta.files.length ? card("Files", null, table("Files", [{ head: "Role" }, { head: "File" }, { head: "SHA-256" }],
      meta.files.map((f) => [f.role, h("code", {}, f.path), f.sha256 ? h("code", { class: "hash" }, f.sha256) : "–"]))) : null,
    meta.not_live ? card("Why this page does not compute with the model", null, h("p", { id: "not-live" }, meta.not_live)) : null,
    h("div", { class: "columns" },
      meta.versions.length || meta.created ? card("Versions", null, pairs([...meta.versions, ...(meta.created ? [{ name: "created", text: meta.created }] : [])])) : null,
      meta.seeds.length ? card("Seeds", null, pairs(meta.seeds)) : null),
    card("Data of this page", "everything shown here as JSON; every table as a sheet of one workbook, with all digits",
      h("div", { class: "toolbar live-actions" }, h("button", { type: "button", id: "save-data", onclick: download }, "Save the data"), h("button", { type: "button", id: "save-tables", onclick: tables }, "Save all tables (.xlsx)"))),
    h("p", { class: "note" }, "Drawn with three.js and plotly.js, packed with fflate (MIT licence); their licences stand in the source of this page."));
}
