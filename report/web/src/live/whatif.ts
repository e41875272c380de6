/** What if a mass or a spring stood at a node: chosen in the picture or by name, two sliders each. */

import { h, soft } from "../dom";
import { significant } from "../format";
import type { LiveModel, Extra, Prediction } from "./model";

export interface WhatIf {
  root: HTMLElement;
  show(extras: Extra[]): void;
  /** Offers a node, as one that has been picked. */
  offer(node: number): void;
}

interface Hands { set(extra: Extra, isLast: boolean): void; remove(node: number): void }

/** A mass that would double the modal mass of the mode in which the node moves most, and the spring of the same weight; null where it stands still. */
export function reach(model: LiveModel, p: Prediction, node: number, modes: number): { mass: number; stiffness: number } | null {
  let most = 0, hz = 0;
  p.shapes.slice(0, modes).forEach((shape, i) => {
    let square = 0;
    for (let axis = 0; axis < 3; axis++) {
      const d = model.motion(node, axis);
      square += d.reduce((s, v, k) => s + v * shape[k]!, 0) ** 2;
    }
    if (square > most) most = square;
    if (i === 0) hz = p.hz[0]!;
  });
  return most > 1e-12 ? { mass: 1 / most, stiffness: (10 * (2 * Math.PI * hz) ** 2) / most } : null;
}

const STEPS = 500;

export function whatIf(names: string[], limits: (node: number) => { mass: number; stiffness: number } | null, hands: Hands): WhatIf {
  const list = h("div", { class: "live-list" }), say = h("p", { class: "note", role: "status" }, "Choose a node in the picture, or by name.");
  const field = h("input", { type: "search", class: "live-node", list: "live-nodes", placeholder: "node", "aria-label": "Node for a mass or a spring",
    onchange: () => { const node = names.indexOf(field.value.trim()); if (node >= 0) { field.value = ""; offer(node); } } });
  // A long list of names would be most of the page.
  const known = names.length <= 500 ? h("datalist", { id: "live-nodes" }, names.map((n) => h("option", { value: n }))) : null;
  const shown = new Map<number, { root: HTMLElement; show: (e: Extra) => void }>();
  const make = (node: number): { root: HTMLElement; show: (e: Extra) => void } | null => {
    const limit = limits(node);
    if (!limit) return null;
    let now: Extra = { node, mass: 0, stiffness: 0 };
    const one = (what: "mass" | "stiffness", word: string, unit: string): { root: HTMLElement; show: () => void } => {
      const most = limit[what], output = h("span", { class: "live-value" });
      const range = h("input", { type: "range", min: 0, max: STEPS, step: 1, class: "live-range", "data-node": names[node]!, "data-what": what, "aria-label": `${word} at ${names[node]}`,
        oninput: () => change(false), onchange: () => change(true) });
      const change = (isLast: boolean): void => hands.set({ ...now, [what]: (most * Number(range.value)) / STEPS }, isLast);
      const show = (): void => {
        range.value = String(Math.round((STEPS * now[what]) / most));
        output.textContent = `${significant(now[what], 3)} ${unit}`;
        range.setAttribute("aria-valuetext", output.textContent);
      };
      show();
      return { root: h("div", { class: "live-slider" }, h("div", { class: "live-name" }, h("span", {}, word), output), h("div", { class: "live-track" }, range)), show };
    };
    const mass = one("mass", "mass", "kg"), spring = one("stiffness", "spring to the ground", "N/m");
    const root = h("div", { class: "live-extra" }, h("div", { class: "live-name" }, h("strong", {}, soft(names[node]!)),
      h("button", { type: "button", class: "link", "aria-label": `Remove what stands at ${names[node]}`, onclick: () => hands.remove(node) }, "remove")), mass.root, spring.root);
    return { root, show: (e) => { now = e; mass.show(); spring.show(); } };
  };
  const offer = (node: number): void => {
    if (shown.has(node)) return;
    if (limits(node)) hands.set({ node, mass: 0, stiffness: 0 }, true);
    else say.textContent = `${names[node]} stands still in these modes.`;
  };
  const show = (extras: Extra[]): void => {
    for (const node of [...shown.keys()]) {
      if (extras.some((e) => e.node === node)) continue;
      shown.get(node)!.root.remove();
      shown.delete(node);
    }
    for (const e of extras) {
      if (!shown.has(e.node)) {
        const made = make(e.node);
        if (!made) continue;
        shown.set(e.node, made);
        list.append(made.root);
      }
      shown.get(e.node)!.show(e);
    }
  };
  return { root: h("div", { class: "live-list" }, h("label", { class: "field block" }, "At node ", field), known, say, list), show, offer };
}
