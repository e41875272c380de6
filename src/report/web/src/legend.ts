/** Keys to colours. */

import { gradient, stagePart, type MapName } from "./color";
import { h } from "./dom";

/** A colour bar with its ends; `stage` for the colours of a 3-D picture in the dark or light theme. */
export function colorBar(map: MapName, low: string, high: string, title: string, stage?: { dark: boolean }): HTMLElement {
  return h("div", { class: "colorbar" },
    h("span", { class: "legend-title" }, title),
    h("div", { class: "bar", style: `background:${gradient(map, stage ? stagePart(map, stage.dark) : [0, 1])}` }),
    h("div", { class: "ends" }, h("span", {}, low), h("span", {}, high)));
}

/** Names with their colours. */
export function swatches(title: string, entries: { name: string; color: string }[]): HTMLElement {
  return h("div", { class: "swatches" },
    h("span", { class: "legend-title" }, title),
    h("ul", {}, entries.map(({ name, color }) =>
      h("li", {}, h("span", { class: "swatch", style: `background:${color}`, "aria-hidden": "true" }), name))));
}
