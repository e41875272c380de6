/** The structure: turn it, colour it, ask what is under the pointer. */

import { categories, css, onStage, parseHex, type MapName, type Rgb } from "../color";
import { floats } from "../decode";
import { nameOf, placeOf, rowsOf, titleOf } from "../describe";
import { h, isDark, num, toggle, type Child } from "../dom";
import { powers, significant, unit } from "../format";
import { colorBar, swatches } from "../legend";
import type { Hit, Kind } from "../pick";
import { makeViewer, type Painter, type Viewer } from "../viewer";
import type { Field, Floats, Localization, Place, Structure, Suspect } from "../types";

/** How values become colours: ends, what lies in the middle, and where between 0 and 1 a value stands. */
export interface Scaling { low: number; high: number; map: MapName; middle?: number; at: (value: number) => number }

export function range(field: Pick<Field, "scale" | "anchor">, values: Float32Array): Scaling {
  let low = Infinity, high = -Infinity, least = Infinity;
  for (const v of values) {
    if (!Number.isFinite(v)) continue;
    low = Math.min(low, v);
    high = Math.max(high, v);
    if (v > 0) least = Math.min(least, v);
  }
  if (low > high) [low, high] = [0, 1];
  const linear = (a: number, b: number, map: MapName): Scaling => ({ low: a, high: b, map, at: (v) => (v - a) / (b - a) });
  if (field.scale === "unit") return linear(0, 1, "viridis");
  const anchor = field.anchor;
  if (anchor != null && anchor > 0 && low >= 0) {
    // A ratio: as many times above the anchor as below it is as far from the middle; ten times at least, so that noise is pale.
    const reach = Math.max(10, high / anchor, Math.min(100, anchor / least));
    return { low: anchor / reach, high: anchor * reach, map: "diverging", middle: anchor,
      at: (v) => (Number.isFinite(v) ? 0.5 + 0.5 * Math.log(Math.max(v / anchor, 1 / reach)) / Math.log(reach) : NaN) };
  }
  if (field.scale === "diverging") {
    const middle = anchor ?? 0, size = Math.max(Math.abs(low - middle), Math.abs(high - middle)) || 1;
    return { ...linear(middle - size, middle + size, "diverging"), middle };
  }
  return linear(low, high > low ? high : low + 1, "cividis");
}

export function painter(values: Float32Array, scaling: Scaling): Painter {
  const dark = isDark();
  return (i) => onStage(scaling.map, scaling.at(values[i]!), dark);
}

interface Coloring { id: string; name: string; apply: (viewer: Viewer, legend: HTMLElement) => void }

function byName(name: string, names: (string | null)[]): Coloring {
  const distinct = [...new Set(names.filter((n): n is string => !!n))];
  return {
    id: name, name: `by ${name}`,
    apply: (viewer, legend) => {
      const colors = categories(isDark());
      const of = new Map(distinct.map((n, i) => [n, colors[i % colors.length]!]));
      const plain: Rgb = [140, 148, 158];
      viewer.paint({ elements: (i) => (names[i] ? parseHex(of.get(names[i]!)!) : plain) });
      const shown = distinct.slice(0, 14).map((n) => ({ name: n, color: of.get(n)! }));
      if (names.some((n) => !n)) shown.push({ name: "none", color: css(plain) });
      if (distinct.length > 14) shown.push({ name: `and ${distinct.length - 14} more (colours repeat)`, color: "transparent" });
      legend.replaceChildren(swatches(name, shown));
    },
  };
}

function byField(field: Field, index: number): Coloring {
  return {
    id: `field-${index}`, name: field.name,
    apply: (viewer, legend) => {
      const values = floats(field.values as Floats);
      const r = range(field, values);
      viewer.paint({ [field.on]: painter(values, r) });
      if (field.on === "sensors") viewer.show("sensors", true);
      const of = field.unit ? ` ${unit(field.unit)}` : "";
      legend.replaceChildren(
        colorBar(r.map, significant(r.low, 3) + of, significant(r.high, 3) + of, field.name, { dark: isDark() }, r.middle == null ? undefined : significant(r.middle, 3) + of),
        field.about ? h("p", { class: "note" }, field.about) : "");
    },
  };
}

/** As many are shown that stand out, and as many where none does. */
const SUSPECTS = 6, UNSUSPICIOUS = 3;

/** Where model and test disagree, the worst first; a click shows the place. */
function suspects(l: Localization, show: (place: Place) => void): HTMLElement {
  const over = (x: Suspect): number => x.above_noise ?? 0;
  const chosen = (all: { x: Suspect; i: number }[]): { x: Suspect; i: number }[] => {
    const sorted = all.sort((a, b) => over(b.x) - over(a.x)), out = sorted.filter(({ x }) => over(x) > 1).slice(0, SUSPECTS);
    return out.length ? out : sorted.slice(0, UNSUSPICIOUS);
  };
  // A group of one element is that element, which has been named.
  const named = new Set(l.elements.map((x) => x.place.text));
  const list = (title: string, all: Suspect[], path: string): Child => all.every((x) => path.endsWith("groups") && named.has(x.place.text)) ? null : [h("h5", {}, title),
    h("ol", { class: "suspects" }, chosen(all.map((x, i) => ({ x, i })).filter(({ x }) => !path.endsWith("groups") || !named.has(x.place.text))).map(({ x, i }) => h("li", {},
      h("button", { type: "button", class: "link", onclick: () => show(x.place) }, x.place.text),
      h("span", { title: `probability by noise alone: ${significant(x.p_value, 2)}` }, num(significant(x.above_noise, 3), `${path}.${i}.above_noise`)))))];
  return h("div", { class: "details", id: "localization" }, h("h4", {}, "Where model and test disagree"),
    h("p", { class: "note" }, powers(l.sentence)),
    list("Elements: energy over noise", l.elements, "localization.elements"), list("Groups", l.groups, "localization.groups"));
}

/** More nodes than these would hide what they join. */
const MANY = 2000;

export function structureSection(s: Structure, localization?: Localization): HTMLElement {
  const details = h("div", { class: "details", id: "picked", "aria-live": "polite" },
    h("p", { class: "note" }, "Choose a node, element, mass, link or sensor in the picture, or by name."));
  const select = (hit: Hit | null): void => {
    viewer.highlight(hit ? placeOf(s, hit) : null);
    details.replaceChildren(...(hit
      ? [h("h4", {}, titleOf(s, hit)), h("dl", { class: "facts" },
          rowsOf(s, hit).map((row) => [h("dt", {}, row.name), h("dd", {}, unit(row.value))]))]
      : [h("p", { class: "note" }, "Nothing chosen.")]));
  };
  const viewer = makeViewer(s, {
    label: "The structure in three dimensions", pickable: true, onPick: select, describe: (hit) => titleOf(s, hit),
  });
  viewer.root.id = "structure-viewer";
  const legend = h("div", { class: "legend" });

  const colorings: Coloring[] = [
    { id: "plain", name: "plain", apply: (v, l) => { v.paint({}); l.replaceChildren(); } },
  ];
  if (s.elements.some((e) => e.group)) colorings.push(byName("group", s.elements.map((e) => e.group ?? null)));
  if (s.elements.some((e) => e.parameters?.length)) colorings.push(byName("parameter", s.elements.map((e) => e.parameters?.join(" + ") || null)));
  if (new Set(s.elements.map((e) => e.kind)).size > 1) colorings.push(byName("type", s.elements.map((e) => e.kind)));
  const named = colorings.length;
  s.fields.forEach((field, i) => colorings.push(byField(field, i)));
  let current = colorings[0]!;
  const pickColor = h("select", { id: "structure-color", onchange: () => {
    current = colorings.find((c) => c.id === pickColor.value) ?? colorings[0]!;
    current.apply(viewer, legend);
  } },
    h("optgroup", { label: "Model" }, colorings.slice(0, named).map((c) => h("option", { value: c.id }, c.name))),
    s.fields.length ? h("optgroup", { label: "Results" }, colorings.slice(named).map((c) => h("option", { value: c.id }, c.name))) : null);
  const start = colorings.find((c) => c.id === "field-0") ?? colorings.find((c) => c.id === "group") ?? colorings[0]!;
  pickColor.value = start.id;
  current = start;
  start.apply(viewer, legend);
  document.addEventListener("retheme", () => current.apply(viewer, legend));

  const kinds: [Kind, readonly { name: string }[]][] = [
    ["node", s.nodes], ["element", s.elements], ["sensor", s.sensors], ["mass", s.masses], ["link", s.rigid_links], ["exciter", s.exciters],
  ];
  const find = h("input", { type: "search", id: "find", placeholder: "name", autocomplete: "off", "aria-label": "Find by name",
    onkeydown: (event: Event) => { if ((event as KeyboardEvent).key === "Enter") search(); }, onchange: () => search() });
  const search = (): void => {
    const word = find.value.trim().toLowerCase();
    if (!word) return;
    for (const exact of [true, false]) {
      for (const [kind, list] of kinds) {
        const index = list.findIndex((_, i) => {
          const name = nameOf(s, { kind, index: i, distance: 0 }).toLowerCase();
          return exact ? name === word : name.includes(word);
        });
        if (index >= 0) return select({ kind, index, distance: 0 });
      }
    }
    details.replaceChildren(h("p", { class: "note" }, `Nothing here is called “${find.value.trim()}”.`));
  };

  const count = (n: number, one: string, many: string): string | null => (n ? `${n.toLocaleString("en")} ${n === 1 ? one : many}` : null);
  const summary = [
    count(s.nodes.length, "node", "nodes"), count(s.elements.length, "element", "elements"),
    count(s.rigid_links.length, "rigid link", "rigid links"), count(s.masses.length, "point mass", "point masses"),
    count(s.supports.length, "support", "supports"), count(s.sensors.length, "sensor", "sensors"), count(s.exciters.length, "exciter", "exciters"),
  ].filter(Boolean).join(" · ");
  const layer = (name: Parameters<Viewer["show"]>[0], text: string, on: boolean, present = true): HTMLElement | null => {
    if (present) viewer.show(name, on);
    return present ? toggle(text, on, (v) => viewer.show(name, v)) : null;
  };
  return h("div", { class: "split" },
    h("section", { class: "card stage-card" }, viewer.root,
      h("div", { class: "toolbar" },
        h("label", { class: "field" }, "Colour ", pickColor),
        layer("nodes", "Nodes", s.nodes.length <= MANY), layer("links", "Links", true, s.rigid_links.length > 0),
        layer("masses", "Masses", true, s.masses.length > 0),
        layer("supports", "Supports", true, s.supports.length > 0 || s.elements.some((e) => e.nodes.length === 1)),
        layer("sensors", "Sensors", s.sensors.length > 0 && s.sensors.length <= 200, s.sensors.length + s.exciters.length > 0),
        layer("axes", "Section z axes", false, s.elements.some((e) => e.z_axis)), layer("names", "Names", false))),
    h("aside", { class: "card side" },
      h("p", { class: "note", id: "structure-summary" }, summary),
      legend,
      h("label", { class: "field block" }, "Find ", find),
      details,
      localization ? suspects(localization, (place) => viewer.highlight(place)) : null,
      h("p", { class: "note keys" }, "Drag to turn, shift-drag to move, click the picture and use the wheel to zoom; arrow keys, + and − do the same.")));
}
