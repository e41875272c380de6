/** Keys to colours. */

import { gradient, type MapName } from "./color";
import { h } from "./dom";

/** A colour bar with its ends. */
export function colorBar(map: MapName, low: string, high: string, title: string): HTMLElement {
  return h("div", { class: "colorbar" },
    h("span", { class: "legend-title" }, title),
    h("div", { class: "bar", style: `background:${gradient(map)}` }),
    h("div", { class: "ends" }, h("span", {}, low), h("span", {}, high)));
}

/** Names with their colours. */
export function swatches(title: string, entries: { name: string; color: string }[]): HTMLElement {
  return h("div", { class: "swatches" },
    h("span", { class: "legend-title" }, title),
    h("ul", {}, entries.map(({ name, color }) =>
      h("li", {}, h("span", { class: "swatch", style: `background:${color}`, "aria-hidden": "true" }), name))));
}
