/** Keys to colours. */

import { gradient, stagePart, themed, type MapName } from "./color";
import { h, isDark } from "./dom";

/** A colour bar with its ends, and what stands in the middle; `stage` for the colours of a 3-D picture in the dark or light theme. */
export function colorBar(map: MapName, low: string, high: string, title: string, stage?: { dark: boolean }, middle?: string): HTMLElement {
  const bar = h("div", { class: "bar" });
  const paint = (): void => {
    bar.style.background = gradient(stage ? map : themed(map, isDark()), stage ? stagePart(map, stage.dark) : [0, 1]);
  };
  paint();
  if (!stage && map === "diverging") document.addEventListener("retheme", paint);
  return h("div", { class: "colorbar" }, h("span", { class: "legend-title" }, title), bar,
    h("div", { class: "ends" }, h("span", {}, low), middle == null ? null : h("span", {}, middle), h("span", {}, high)));
}

/** Names with their colours. */
export function swatches(title: string, entries: { name: string; color: string }[]): HTMLElement {
  return h("div", { class: "swatches" },
    h("span", { class: "legend-title" }, title),
    h("ul", {}, entries.map(({ name, color }) =>
      h("li", {}, h("span", { class: "swatch", style: `background:${color}`, "aria-hidden": "true" }), name))));
}
