/** What is missing, where it sits, how sure that is, and what else it could be. */

import { badge, card, h, num, type Child } from "../dom";
import { fixed, probability, significant } from "../format";
import { makeViewer } from "../viewer";
import type { Diagnosis, Hypothesis, Place, Structure } from "../types";

const OUTCOMES = {
  "adequate": ["good", "the model explains the test"], "missing-effect": ["warning", "a missing effect is found"],
  "measurement-fault": ["warning", "a fault of the measurement is found"], "tied": ["warning", "several hypotheses explain it equally well"],
  "unexplained": ["bad", "not explained"],
} as const;

const CATEGORIES: Record<Hypothesis["category"], string> = {
  effect: "physical effect", measurement: "measurement fault", none: "nothing is missing", other: "outside the catalogue",
};

function arrow(before: number | null, after: number | null, path: string, names: [string, string]): Child {
  if (before == null && after == null) return null;
  return h("span", { class: "nowrap" }, before == null ? "–" : num(significant(before, 3), `${path}.${names[0]}`), " → ",
    after == null ? "–" : num(significant(after, 3), `${path}.${names[1]}`));
}

function copyButton(text: string): HTMLElement {
  const button = h("button", { type: "button", class: "copy", onclick: () => {
    navigator.clipboard.writeText(text).then(() => (button.textContent = "Copied"), () => (button.textContent = "Select the text to copy it"));
  } }, "Copy");
  return button;
}

function evidence(title: string, list: string[], sign: string): HTMLElement | null {
  return list.length ? h("div", { class: "evidence" }, h("h5", {}, title), h("ul", {}, list.map((e) => h("li", {}, h("span", { class: "sign", "aria-hidden": "true" }, sign), e)))) : null;
}

export function diagnosisSection(d: Diagnosis, s: Structure | undefined): HTMLElement {
  const viewer = s ? makeViewer(s, { label: "Where the hypothesis sits" }) : null;
  if (viewer) {
    viewer.root.id = "diagnosis-viewer";
    viewer.show("nodes", false);
    viewer.show("sensors", false);
  }
  const where = h("p", { class: "where", id: "diagnosis-where", "aria-live": "polite" });
  const nameOf = (x: Hypothesis): string => x.kind + (x.place.text ? ` @ ${x.place.text}` : "");
  const has = (p: Place): boolean => p.nodes.length + p.elements.length + p.sensors.length > 0;
  const showPlace = (place: Place, text: string): void => {
    viewer?.highlight(place);
    viewer?.show("sensors", place.sensors.length > 0);
    where.textContent = viewer ? (has(place) ? text : `${text}: no single place`) : text;
  };

  const detail = h("div", { id: "hypothesis-detail" });
  const select = (i: number): void => {
    const x = d.hypotheses[i];
    if (!x) return;
    for (const b of list.querySelectorAll("button")) b.setAttribute("aria-current", String(b.dataset["index"] === String(i)));
    showPlace(x.place, nameOf(x));
    const path = `diagnosis.hypotheses.${i}`;
    const row = (name: string, value: Child): Child => (value == null ? null : [h("dt", {}, name), h("dd", {}, value)]);
    const ties = x.tied_with.map((id) => ({ id, k: d.hypotheses.findIndex((o) => o.id === id) }));
    detail.replaceChildren(card(nameOf(x), CATEGORIES[x.category],
      x.summary ? h("p", {}, x.summary) : null,
      h("dl", { class: "facts wide" },
        row("probability", num(probability(x.probability), `${path}.probability`)),
        row("log Bayes factor", x.log_bayes_factor == null ? null : num(fixed(x.log_bayes_factor, 1), `${path}.log_bayes_factor`)),
        row("misfit", arrow(x.misfit_before, x.misfit_after, path, ["misfit_before", "misfit_after"])),
        row("held-out data", arrow(x.held_out_before, x.held_out_after, path, ["held_out_before", "held_out_after"])),
        row(x.quantity || "estimate", x.estimate == null ? null : h("span", {}, num(significant(x.estimate, 3), `${path}.estimate`), x.unit ? ` ${x.unit}` : "",
          x.interval ? [" (95 %: ", num(significant(x.interval[0], 3), `${path}.interval.0`), " … ", num(significant(x.interval[1], 3), `${path}.interval.1`), ")"] : "")),
        row("cannot be told from", ties.length ? h("span", {}, ties.map(({ id, k }, n) => [n ? ", " : "",
          k >= 0 ? h("button", { type: "button", class: "link", onclick: () => select(k) }, nameOf(d.hypotheses[k]!)) : id])) : null)),
      h("div", { class: "columns" }, evidence("Speaks for it", x.evidence_for, "+"), evidence("Speaks against it", x.evidence_against, "−")),
      x.patch ? h("div", { class: "patch" }, h("div", { class: "patch-head" }, h("h5", {}, "The edit that ", h("code", {}, "retune add"), " makes"), copyButton(x.patch)), h("pre", { id: "patch", tabindex: 0 }, x.patch)) : null));
  };

  const list = h("ol", { class: "hypotheses" }, d.hypotheses.map((x, i) =>
    h("li", {}, h("button", { type: "button", class: "hypothesis", "data-index": i, onclick: () => select(i) },
      h("span", { class: "p-bar", "aria-hidden": "true" }, h("span", { style: `width:${Math.round(100 * Math.min(1, Math.max(0, x.probability ?? 0)))}%` })),
      h("span", { class: "hypothesis-name" }, nameOf(x)),
      h("span", { class: "hypothesis-p" }, num(probability(x.probability), `diagnosis.hypotheses.${i}.probability`)),
      h("span", { class: "hypothesis-sub" }, CATEGORIES[x.category],
        x.misfit_after == null ? "" : [" · misfit ", arrow(x.misfit_before, x.misfit_after, `diagnosis.hypotheses.${i}`, ["misfit_before", "misfit_after"])],
        x.tied_with.length ? h("span", { class: "tie" }, "tied") : "")))));

  const next = d.next_measurements.length ? card("What to measure next", "the measurement that separates best comes first",
    h("ol", { class: "next" }, d.next_measurements.map((m, i) => h("li", {},
      h("strong", {}, m.what), m.why ? h("p", {}, m.why) : null,
      h("p", { class: "note" }, m.separates.length ? `separates ${m.separates.join(" from ")}` : "",
        m.expected_log_bayes_factor == null ? "" : [m.separates.length ? "; " : "", "expected log Bayes factor ", num(fixed(m.expected_log_bayes_factor, 1), `diagnosis.next_measurements.${i}.expected_log_bayes_factor`)],
        m.place && viewer && has(m.place) ? [" ", h("button", { type: "button", class: "link", onclick: () => showPlace(m.place!, `measure here: ${m.place!.text}`) }, "show the place")] : ""))))) : null;
  const [level, words] = OUTCOMES[d.outcome];
  const section = h("div", { class: "stack" },
    h("section", { class: "card diagnosis-head" }, badge(level, words), h("p", { class: "lead" }, d.sentence),
      h("p", { class: "note" },
        d.p_value == null ? "" : ["chance of a misfit like this if nothing were missing: p = ", num(significant(d.p_value, 2), "diagnosis.p_value")],
        d.alarm_level == null ? "" : ["; alarm below ", num(significant(d.alarm_level, 2), "diagnosis.alarm_level")],
        d.screened == null ? "" : ["; ", num(String(d.screened), "diagnosis.screened"), " candidates screened"])),
    h("div", { class: "split even" },
      h("section", { class: "card" }, h("header", { class: "card-head" }, h("h3", {}, "Hypotheses")), list),
      viewer ? h("section", { class: "card stage-card" }, viewer.root, where) : null),
    detail,
    d.remainder ? card("What remains", null, h("p", {}, d.remainder),
      d.remainder_place && viewer ? h("button", { type: "button", class: "link", onclick: () => showPlace(d.remainder_place!, `the remainder: ${d.remainder_place!.text}`) }, "show the place") : null) : null,
    next);
  select(0);
  return section;
}
