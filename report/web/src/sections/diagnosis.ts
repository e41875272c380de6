/** What is missing, where it sits, how sure that is, and what else it could be. */

import { badge, card, choice, h, num, soft, table, type Child } from "../dom";
import { fixed, probability, quoted, shorten, significant } from "../format";
import { makeViewer } from "../viewer";
import type { Damping, Diagnosis, Estimate, Hypothesis, Place, Structure } from "../types";

const OUTCOMES = {
  "adequate": ["good", "the model explains the test"], "missing-effect": ["warning", "a missing effect is found"],
  "measurement-fault": ["warning", "a fault of the measurement is found"], "several-effects": ["bad", "several things are wrong"], "tied": ["warning", "several hypotheses explain it equally well"],
  "unexplained": ["bad", "not explained"], "noise-or-model": ["bad", "the stated noise or the model is wrong"],
} as const;

/** What a diagnosis says of the model, in a few words. */
export const outcomeWords = (d: Diagnosis): string => OUTCOMES[d.outcome][1];

/** What to measure where no measurement has been found that separates hypotheses. */
const INSTEAD: Partial<Record<Diagnosis["outcome"], string>> = {
  "adequate": "Nothing more is needed to tell whether this model is right for this test.",
  "noise-or-model": "The same modes several times: their scatter is the standard deviation of the test, and it decides between noise and model.",
  "unexplained": "None of the hypotheses that were tried explains the test, so that no measurement separates them. Where model and test disagree stands under Structure: look there.",
};

const CATEGORIES: Record<Hypothesis["category"], string> = {
  effect: "physical effect", measurement: "measurement fault", none: "the model as it is", other: "outside the catalogue",
};
const categoryOf = (x: Hypothesis): string => (x.id === "together" ? "two or more at once" : CATEGORIES[x.category]);

function arrow(before: number | null, after: number | null, path: string, names: [string, string]): Child {
  if (before == null && after == null) return null;
  return h("span", { class: "nowrap" }, before == null ? "–" : num(significant(before, 3), `${path}.${names[0]}`),
    after == null ? null : [" → ", num(significant(after, 3), `${path}.${names[1]}`)]);
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

/** What measured damping ratios say of a model that has no damping. */
function damping(d: Damping, path: string): HTMLElement {
  const size = (e: Estimate): string =>
    `${e.quantity} ${significant(e.value, 3)}${e.unit ? ` ${e.unit}` : ""}${e.interval ? ` (${e.interval.map((v) => significant(v, 3)).join(" … ")})` : ""}`;
  const percent = (v: number): string => `${significant(100 * v, 3)} %`;
  return card("Damping", "the model has none; the ratios are read at the fitted model, and what they say changes nothing above", h("p", {}, d.sentence),
    table("Laws of damping", [{ head: "P", numeric: true }, { head: "ln B", numeric: true }, { head: "Misfit", numeric: true }, { head: "Law" }],
      d.laws.map((l, i) => [l.probability == null ? "" : num(probability(l.probability), `${path}.laws.${i}.probability`),
        l.log_bayes_factor == null ? "" : num(fixed(l.log_bayes_factor, 1), `${path}.laws.${i}.log_bayes_factor`),
        l.misfit_after == null ? "" : num(significant(l.misfit_after, 3), `${path}.laws.${i}.misfit_after`), l.estimates.map(size).join("; ")])),
    table("Damping ratios", [{ head: "#", numeric: true }, { head: "Hz", numeric: true }, { head: "Test", numeric: true }, { head: "± sd", numeric: true }, { head: "By the law", numeric: true }, { head: "" }],
      d.modes.map((m, i) => [String(m.mode), num(significant(m.frequency_hz, 4), `${path}.modes.${i}.frequency_hz`), num(percent(m.ratio), `${path}.modes.${i}.ratio`),
        num(percent(m.sd), `${path}.modes.${i}.sd`), num(percent(m.by_law), `${path}.modes.${i}.by_law`), ""])));
}

/** The diagnoses of all steps, the last one open; what the head of the page has said is not said again. */
export function diagnosesSection(earlier: Diagnosis[], last: Diagnosis, s: Structure | undefined, said: string): HTMLElement {
  if (!earlier.length) return diagnosisSection(last, s, "diagnosis", said);
  const all = [...earlier.map((d, i) => ({ d, path: `earlier_diagnoses.${i}` })), { d: last, path: "diagnosis" }];
  const built = new Map<number, HTMLElement>();
  const place = h("div", {});
  const show = (i: number): void => {
    const { d, path } = all[i]!;
    if (!built.has(i)) {
      built.set(i, diagnosisSection(d, s, path, said));
      place.append(built.get(i)!);
    }
    for (const [k, element] of built) element.hidden = k !== i;
  };
  const open = all.length - 1;
  show(open);
  return h("div", {}, h("div", { class: "toolbar diagnosis-choice" }, h("span", { class: "note" }, "Diagnosis of the model"),
    choice("Diagnosis of which step", all.map(({ d }, i) => ({ value: String(i), text: d.title || `step ${i}` })), String(open), (v) => show(Number(v)))), place);
}

function diagnosisSection(d: Diagnosis, s: Structure | undefined, root: string, said: string): HTMLElement {
  const viewer = s ? makeViewer(s, { label: "Where the hypothesis sits" }) : null;
  if (viewer) {
    if (root === "diagnosis") viewer.root.id = "diagnosis-viewer";
    viewer.show("nodes", false);
    viewer.show("sensors", false);
  }
  const where = h("p", { class: "where", id: root === "diagnosis" ? "diagnosis-where" : null, "aria-live": "polite" });
  const nameOf = (x: Hypothesis): string => x.kind + (x.place.text ? ` @ ${x.place.text}` : "");
  const wordOf = (id: string): string => { const x = d.hypotheses.find((o) => o.id === id); return x ? nameOf(x) : id; };
  const has = (p: Place): boolean => p.nodes.length + p.elements.length + p.sensors.length > 0;
  const showPlace = (place: Place, text: string): void => {
    viewer?.highlight(place);
    viewer?.show("sensors", place.sensors.length > 0);
    where.textContent = viewer ? (has(place) ? text : `${text}: no single place`) : text;
  };

  const detail = h("div", { id: root === "diagnosis" ? "hypothesis-detail" : null });
  const select = (i: number): void => {
    const x = d.hypotheses[i];
    if (!x) return;
    for (const b of list.querySelectorAll("button")) b.setAttribute("aria-current", String(b.dataset["index"] === String(i)));
    showPlace(x.place, nameOf(x));
    const path = `${root}.hypotheses.${i}`;
    const row = (name: string, value: Child): Child => (value == null ? null : [h("dt", {}, name), h("dd", {}, value)]);
    const ties = x.tied_with.map((id) => ({ id, k: d.hypotheses.findIndex((o) => o.id === id) }));
    detail.replaceChildren(card(nameOf(x), categoryOf(x),
      x.summary ? h("p", {}, x.summary) : null,
      h("dl", { class: "facts wide" },
        row("on the mesh", x.place.on_mesh || null),
        row("probability", num(probability(x.probability), `${path}.probability`)),
        row("log Bayes factor", x.log_bayes_factor == null ? null : num(fixed(x.log_bayes_factor, 1), `${path}.log_bayes_factor`)),
        row("misfit", arrow(x.misfit_before, x.misfit_after, path, ["misfit_before", "misfit_after"])),
        row("held-out data", arrow(x.held_out_before, x.held_out_after, path, ["held_out_before", "held_out_after"])),
        x.estimates.map((e, k) => row(e.quantity || "estimate", h("span", {}, num(significant(e.value, 4), `${path}.estimates.${k}.value`), e.unit ? ` ${e.unit}` : "",
          e.interval ? [e.interval_label ? ` (${e.interval_label}: ` : " (", num(significant(e.interval[0], 4), `${path}.estimates.${k}.interval.0`), " … ", num(significant(e.interval[1], 4), `${path}.estimates.${k}.interval.1`), ")"] : ""))),
        row("cannot be told from", ties.length ? h("ul", { class: "plain-list" }, ties.map(({ id, k }) => h("li", {},
          k >= 0 ? h("button", { type: "button", class: "link", onclick: () => select(k) }, soft(nameOf(d.hypotheses[k]!))) : soft(id)))) : null)),
      h("div", { class: "columns" }, evidence("Speaks for it", x.evidence_for, "+"), evidence("Speaks against it", x.evidence_against, "−")),
      x.patch ? h("div", { class: "patch" }, h("div", { class: "patch-head" }, x.category === "effect" ? h("h5", {}, "The edit that ", h("code", {}, `retune add MODEL ${x.id}`), " makes") : h("h5", {}, "What to do"), copyButton(x.patch)), h("pre", { id: root === "diagnosis" ? "patch" : null, class: "patch-text", tabindex: 0 }, x.patch)) : null));
  };

  const item = (x: Hypothesis, i: number): HTMLElement => h("li", {}, h("button", { type: "button", class: "hypothesis", "data-index": i, onclick: () => select(i) },
      h("span", { class: "p-bar", "aria-hidden": "true" }, h("span", { style: `width:${Math.round(100 * Math.min(1, Math.max(0, x.probability ?? 0)))}%` })),
      h("span", { class: "hypothesis-name" }, soft(nameOf(x))),
      h("span", { class: "hypothesis-p" }, num(probability(x.probability), `${root}.hypotheses.${i}.probability`)),
      h("span", { class: "hypothesis-sub" }, categoryOf(x),
        x.misfit_after == null ? "" : [" · misfit ", arrow(x.misfit_before, x.misfit_after, `${root}.hypotheses.${i}`, ["misfit_before", "misfit_after"])],
        x.tied_with.length ? h("span", { class: "tie" }, "tied") : "")));
  // The unlikely ones are there for who asks.
  const isShown = (x: Hypothesis, i: number): boolean => i < 6 || (x.probability ?? 0) >= 0.005 || x.category === "none" || x.category === "other";
  const items = d.hypotheses.map((x, i) => ({ x, item: item(x, i), shown: isShown(x, i) }));
  const rest = items.filter((o) => !o.shown);
  const first = h("ol", { class: "hypotheses" }), others = h("ol", { class: "hypotheses" }), nothing = h("p", { class: "note", hidden: true }, "None of these.");
  const more = h("details", { class: "more-hypotheses" }, h("summary", {}, `${rest.length} more, each below 0.01`), others);
  let kind = "", word = "";
  // A filter looks at all of them, and shows what it finds in one list.
  const arrange = (): void => {
    const on = kind !== "" || word !== "";
    const found = items.filter(({ x }) => (!kind || x.kind === kind || x.category === kind) && (!word || nameOf(x).toLowerCase().includes(word)));
    first.replaceChildren(...(on ? found : items.filter((o) => o.shown)).map((o) => o.item));
    others.replaceChildren(...(on ? [] : rest).map((o) => o.item));
    more.hidden = on || rest.length === 0;
    nothing.hidden = !on || found.length > 0;
  };
  const kinds = [...new Set(d.hypotheses.filter((x) => x.category === "effect" || x.category === "measurement").map((x) => x.kind))].sort();
  const categories = [...new Set(d.hypotheses.map((x) => x.category))].filter((c) => c === "effect" || c === "measurement");
  const filter = d.hypotheses.length > 8 ? h("div", { class: "hypothesis-filter" },
    h("select", { "aria-label": "Kind of hypothesis", class: "kind", onchange: (e: Event) => { kind = (e.target as HTMLSelectElement).value; arrange(); } },
      h("option", { value: "" }, "every kind"), categories.map((c) => h("option", { value: c }, `every ${CATEGORIES[c]}`)), kinds.map((k) => h("option", { value: k }, shorten(k, 40)))),
    h("input", { type: "search", "aria-label": "Place or name", placeholder: "place or name", class: "word", oninput: (e: Event) => { word = (e.target as HTMLInputElement).value.trim().toLowerCase(); arrange(); } })) : null;
  arrange();
  const list = h("div", {}, filter, first, nothing, more);

  // What all of them separate is said once.
  const separated = (ids: string[]): string => `${ids.map(wordOf).join(", ")}`;
  const [common] = d.next_measurements.map((m) => m.separates);
  const isCommon = !!common?.length && d.next_measurements.every((m) => m.separates.join(" ") === common.join(" "));
  const next = d.next_measurements.length ? card("What to measure next", "the measurement that separates best comes first; a log Bayes factor of 1 is a hint, of 3 strong evidence, of 5 very strong",
    isCommon ? h("p", {}, soft(`to tell from each other: ${separated(common)}`)) : null,
    h("ol", { class: "next" }, d.next_measurements.slice(0, 5).map((m, i) => h("li", {},
      h("strong", {}, m.what), m.why ? h("p", {}, m.why) : null,
      h("p", { class: "note" }, !isCommon && m.separates.length ? `tells from each other: ${separated(m.separates)}; ` : "",
        m.expected_log_bayes_factor == null ? "" : ["expected log Bayes factor ", num(fixed(m.expected_log_bayes_factor, 1), `${root}.next_measurements.${i}.expected_log_bayes_factor`)],
        m.place && viewer && has(m.place) ? [" ", h("button", { type: "button", class: "link", onclick: () => showPlace(m.place!, `measure here: ${m.place!.text}`) }, "show the place")] : "")))))
    : INSTEAD[d.outcome] ? card("What to measure next", null, h("p", {}, INSTEAD[d.outcome]!)) : null;
  const [level, words] = OUTCOMES[d.outcome];
  const section = h("div", { class: "stack" },
    h("section", { class: "card diagnosis-head" }, badge(level, words), said.toLowerCase().includes(d.sentence.replace(/\.$/, "").toLowerCase()) ? null : h("p", { class: "lead" }, soft(quoted(d.sentence))),
      h("p", { class: "note" },
        d.misfit == null ? "" : ["misfit of the fitted model ", num(significant(d.misfit, 4), `${root}.misfit`),
          d.degrees_of_freedom == null ? "; " : [", noise alone leaves about ", num(significant(d.degrees_of_freedom, 4), `${root}.degrees_of_freedom`), "; "]],
        d.p_value == null ? "" : ["as good by chance with p = ", num(significant(d.p_value, 2), `${root}.p_value`)],
        d.alarm_level == null ? "" : ["; alarm below ", num(significant(d.alarm_level, 2), `${root}.alarm_level`)],
        d.tried ? `; tried ${d.tried}` : d.screened == null ? "" : ["; ", num(String(d.screened), `${root}.screened`), " candidates screened"]),
      d.warnings.length ? h("ul", { class: "warnings note" }, d.warnings.map((w) => h("li", {}, quoted(w)))) : null),
    h("div", { class: "split even" },
      h("section", { class: "card" }, h("header", { class: "card-head" }, h("h3", {}, "Hypotheses")), list),
      viewer ? h("section", { class: "card stage-card" }, viewer.root, where) : null),
    detail,
    d.remainder ? card("What remains", null, h("p", {}, d.remainder),
      d.remainder_place && viewer ? h("button", { type: "button", class: "link", onclick: () => showPlace(d.remainder_place!, `the remainder: ${d.remainder_place!.text}`) }, "show the place") : null) : null,
    d.damping ? damping(d.damping, `${root}.damping`) : null,
    next);
  select(0);
  return section;
}
