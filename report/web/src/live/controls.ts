/** Sliders of parameters, switches of hypotheses. */

import { badge, h, num, soft } from "../dom";
import { probability, significant, unit } from "../format";
import type { Live } from "../types";
import { owner, type State } from "./state";

const STEPS = 1000;
/** Hypotheses below this probability are folded away, but for the first few: the sliders stand under them. */
const IMPROBABLE = 0.005, FIRST = 3;

export interface Controls {
  parameters: HTMLElement;
  hypotheses: HTMLElement | null;
  /** Shows a state that was not set by the controls. */
  show(state: State): void;
}

interface Hands { value(k: number, si: number, isLast: boolean): void; on(hypothesis: number, on: boolean): void }

/** A slider with the number beside it; marks stand where the first version and the report have the value. */
function slider(live: Live, k: number, hands: Hands): { root: HTMLElement; show: (si: number) => void } {
  const p = live.parameters[k]!, [low, high] = p.range, span = high - low, isSize = owner(live, k) >= 0;
  // A size stands under its hypothesis, whose name it repeats.
  const called = isSize ? p.name.split(".").at(-1)! : p.name;
  const per = p.unit_factor, words = p.unit && p.unit !== "1" ? unit(p.unit) : "";
  const fraction = (si: number): number => (span > 0 ? (si - low) / span : 0);
  const range = h("input", { type: "range", min: 0, max: STEPS, step: 1, class: "live-range", "data-parameter": p.name, "aria-label": p.name,
    oninput: () => hands.value(k, low + (span * Number(range.value)) / STEPS, false),
    onchange: () => hands.value(k, low + (span * Number(range.value)) / STEPS, true) });
  const field = h("input", { type: "text", inputmode: "decimal", class: "live-number", "aria-label": `${p.name}${words ? `, ${words}` : ""}`,
    onchange: () => {
      const typed = Number(field.value.replace(",", ".").replace("−", "-"));
      if (field.value.trim() && Number.isFinite(typed)) hands.value(k, Math.min(high, Math.max(low, typed * per)), true);
      else show(now);
    } });
  let now = p.value;
  const show = (si: number): void => {
    now = si;
    range.value = String(Math.round(STEPS * fraction(si)));
    range.setAttribute("aria-valuetext", `${significant(si / per, 4)} ${words}`.trim());
    field.value = significant(si / per, 4).replace("−", "-");
    root.classList.toggle("changed", !isSize && si !== p.value);
  };
  const mark = (si: number, kind: string, text: string): HTMLElement =>
    h("button", { type: "button", class: `mark ${kind}`, style: `left:calc(8px + (100% - 16px) * ${fraction(si).toFixed(4)})`, title: text, "aria-label": `${p.name}: ${text}`,
      onclick: () => hands.value(k, si, true) });
  const marks = [mark(p.value, "report", `${isSize ? "without it" : "as reported"}: ${significant(p.value / per, 4)} ${words}`)];
  if (p.initial != null && p.initial >= low && p.initial <= high) marks.unshift(mark(p.initial, "first", `first version: ${significant(p.initial / per, 4)} ${words}`));
  const root = h("div", { class: "live-slider", title: p.description || null },
    h("div", { class: "live-name" }, h("span", {}, soft(called)), h("span", { class: "live-value" }, field, h("span", { class: "live-unit" }, words))),
    h("div", { class: "live-track" }, range, marks),
    h("div", { class: "live-ends" }, h("span", {}, significant(low / per, 3)), h("span", {}, significant(high / per, 3))));
  show(p.value);
  return { root, show };
}

export function controls(live: Live, hands: Hands): Controls {
  const shows = new Map<number, (si: number) => void>();
  const make = (k: number): HTMLElement => {
    const { root, show } = slider(live, k, hands);
    shows.set(k, show);
    return root;
  };
  const own = live.parameters.flatMap((p, k) => (owner(live, k) < 0 && p.range[0] < p.range[1] ? [k] : []));
  const parameters = h("div", { class: "live-list" }, own.map(make));
  const boxes = live.hypotheses.map((x, i) => {
    const box = h("input", { type: "checkbox", role: "switch", "data-hypothesis": x.id, onchange: () => hands.on(i, box.checked) });
    const sizes = h("div", { class: "live-sizes", hidden: true }, x.sizes.map(make));
    return { box, sizes, root: h("div", { class: "live-switch" },
      h("label", {}, box, h("span", { class: "live-hypothesis" }, soft(x.id), x.test ? h("span", { class: "note" }, " fault of the test") : null), h("span", { class: "note nowrap" }, num(probability(x.probability), `live.hypotheses.${i}.probability`))), sizes) };
  });
  const isShown = (_: unknown, i: number): boolean => i < FIRST || live.hypotheses[i]!.probability >= IMPROBABLE;
  const shown = boxes.filter(isShown), folded = boxes.filter((b, i) => !isShown(b, i));
  const rest = folded.length ? h("details", { class: "live-rest" }, h("summary", {}, `${folded.length} more, each below 0.01`), h("div", { class: "live-list" }, folded.map((b) => b.root))) : null;
  const left = live.left_out ?? [];
  const hypotheses = boxes.length + left.length === 0 ? null : h("div", { class: "live-list" }, shown.map((b) => b.root), rest,
    left.map((l) => h("p", { class: "note live-left-out" }, badge("neutral", "not here"), " ", soft(l.name), `: ${l.text}`)));
  return {
    parameters, hypotheses,
    show: (state) => {
      shows.forEach((show, k) => show(state.values[k]!));
      boxes.forEach((b, i) => {
        b.box.checked = state.on[i]!;
        b.sizes.hidden = !state.on[i];
      });
      if (rest && folded.some((b) => b.box.checked)) rest.open = true;
    },
  };
}
