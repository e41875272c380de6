/** The model in the reader's hands: drag a parameter, switch a hypothesis on, and see what the test says to it. */

import { badge, card, h, soft, toggle } from "../dom";
import { shorten, significant } from "../format";
import { Client } from "./client";
import type { FitStep } from "./fit";
import { controls } from "./controls";
import { LiveModel, type Prediction } from "./model";
import { Picture } from "./picture";
import type { Answer } from "./questions";
import type { Line } from "./response";
import { Responses } from "./responses";
import { PROMISED, promised, table, Waterfall } from "./results";
import { between, changes, commands, copied, equal, initial, owner, point, steps, way, written, yaml, type State } from "./state";
import { Track } from "./track";
import { reach, whatIf } from "./whatif";
import type { Frfs, Live, Structure } from "../types";

/** What tests and the console ask of the panel in sight. */
export interface LiveHandle {
  live: Live; state: () => State; milliseconds: number[]; set: (state: State) => Promise<Answer>;
  /** The present state with a frequency response. */
  ask: (line: Line) => Promise<Prediction>;
}
const copy = (say: HTMLElement, text: string): void => {
  navigator.clipboard.writeText(text).then(() => { say.textContent = "Copied."; }, () => { say.textContent = "Select the text to copy it."; });
};

/** Two hypotheses that alter one element: their changes are added here, which in the file they need not be. */
function overlap(live: Live, s: State): string[] {
  const on = live.hypotheses.filter((_, i) => s.on[i]);
  return on.flatMap((a, i) => on.slice(i + 1).filter((b) => a.alters.some((e) => b.alters.includes(e))).map((b) => `${a.id} and ${b.id}`));
}

/** How right the page's model is, in words. */
function trust(live: Live, s: State): HTMLElement[] {
  const used = live.test.length ? Array.from({ length: live.n_elastic }, (_, i) => promised(live, s.on, i)) : [];
  const good = used.findIndex((e) => e > PROMISED), count = good < 0 ? used.length : good;
  const worst = Math.max(0, ...used.slice(0, count));
  const mac = Math.max(0, ...[live.accuracy, ...live.hypotheses.filter((_, i) => s.on[i]).map((x) => x.accuracy)].flatMap((a) => a.mac.slice(0, count).map((v) => v ?? 0)));
  const points = live.accuracy.points + live.hypotheses.filter((_, i) => s.on[i]).reduce((n, x) => n + x.accuracy.points, 0);
  const out = [h("p", { class: "note" }, `This page computes the model on ${live.n} coordinates. Held against the whole model at ${points} random places of these sliders, `,
    `the frequencies of its lowest ${count} elastic modes differ by at most ${significant(100 * worst, 2)} %, and MAC by ${significant(mac, 2)}.`,
    count < live.n_elastic ? " Higher modes are grey." : "")];
  if (s.extras.length && !live.is_complete) {
    out.push(h("p", { class: "note" }, badge("warning", "not exact"), " The coordinates do not hold what a mass or a spring at a node bends locally: its effect is a little underestimated."));
  }
  // What rounding leaves is nothing to tell.
  if (live.not_computed > 1e-6) {
    out.push(h("p", { class: "note" }, `Static readings and frequency responses do not count here; in the report they add ${significant(live.not_computed, 3)} to χ².`));
  }
  const faults = live.hypotheses.filter((x, i) => s.on[i] && x.test);
  if (faults.length) {
    out.push(h("p", { class: "note" }, badge("neutral", "the test is changed"), ` ${faults.map((x) => x.id).join(", ")} ${faults.length > 1 ? "are" : "is"} taken out of the test; the model stays as it is.${faults.length > 1 ? " Of what two of them change, the last counts." : ""}`));
  }
  for (const both of overlap(live, s)) {
    out.push(h("p", { class: "note" }, badge("warning", "not exact"), ` ${both} alter the same element: here their changes are added. \`retune add\` both for the exact answer.`));
  }
  return out;
}

/** What a panel is about: a test, the structure in its configuration, what was measured on it, and the names of the files. */
export interface About {
  live: Live; structure: Structure | undefined; frfs: Frfs | undefined; model: string; test: string;
  /** What has been set, once it stands still, as a state and as a part of an address. */
  changed: (state: State, part: string) => void;
}
export interface Panel { root: HTMLElement; handle: LiveHandle; take(state: State): void; address(): string }

export function livePanel({ live, structure, frfs, model, test, changed }: About): Panel {
  const nodes = structure?.nodes.map((n) => n.name) ?? [];
  const picture = structure && live.displacement ? new Picture(live, structure, (node) => extra.offer(node)) : null;
  const fall = new Waterfall(live.n_data);
  const tableBox = h("div", {}), trustBox = h("div", { class: "live-trust", id: "live-trust" });
  const total = h("p", { class: "live-total", id: "live-total", "aria-live": "polite" });
  const said = h("span", { class: "note", role: "status" });
  const text = h("pre", { class: "patch-text", tabindex: 0, hidden: true, id: "live-text" });
  let state = initial(live), chosen = Math.max(0, live.test.findIndex((t) => t.plan !== "aside"));
  let last: Answer | null = null, before: Prediction | null = null, asked = state, undone: State[] = [], redone: State[] = [];
  const milliseconds: number[] = [];
  let number = 0, heard: ((a: Answer) => void) | null = null;

  const draw = (): void => {
    if (!last || !before) return;
    const p = last.prediction;
    if ("unstable" in p) {
      total.replaceChildren(badge("bad", "no modes"), " With these values the structure has no stable modes: a stiffness or a mass would be negative.");
      return;
    }
    total.replaceChildren("χ² ", h("strong", { "data-total": String(p.chiSquared) }, significant(p.chiSquared, 4)),
      h("span", { class: "note", title: "noise alone gives about as much as there are data; a fit takes away from that about one for each parameter that the data determine" },
        `reported ${significant(before.chiSquared, 4)}; ${live.n_data} data, so much by noise before a fit`));
    tableBox.replaceChildren(table(live, before, p, asked.on, chosen, (j) => { chosen = j; draw(); }));
    picture?.show(p, p.partner[chosen] ?? -1, chosen);
    const list = steps(live, asked, (node) => nodes[node] ?? String(node));
    responses.show(p.curve, last.base);
    if (last.track) track.show(last.track);
    fall.show(["as reported", ...list.map((x) => x.name)], [before.chiSquared, ...last.way, ...(list.length ? [p.chiSquared] : [])]);
  };
  const client = new Client(live, (a) => {
    last = a;
    milliseconds.push(a.milliseconds);
    if (!before && !("unstable" in a.prediction)) before = a.prediction;
    draw();
    if (a.id !== number) return;
    if (a.fit) return stepped(a.fit);
    heard?.(a);
    heard = null;
    root.dataset["settled"] = String(a.id);
  });
  const hasFirst = live.parameters.some((p) => p.initial != null);
  const from = point(live, initial(live));
  live.parameters.forEach((p, k) => { if (p.initial != null) from.theta[k] = p.initial; });
  const track = new Track(live, hasFirst ? "first version" : "as reported");
  const ask = (isLast = true): void => {
    asked = { ...copied(state), order: changes(live, state) };
    number = client.ask(point(live, state), way(live, state),
      { ...responses.question(), ...(isLast ? { track: between(from, point(live, state)) } : {}) });
  };
  const responses = new Responses(live, structure?.sensors ?? [], frfs, () => ask());
  /** One step of a fit after the other, each shown; anything else that is done ends it. */
  let fitting = false;
  const free = (): number[] => live.parameters.flatMap((p, k) => {
    const h = owner(live, k);
    return p.range[0] < p.range[1] && (h < 0 || state.on[h]) ? [k] : [];
  });
  const stepFit = (damping: number): void => {
    asked = { ...copied(state), order: changes(live, state) };
    number = client.ask(point(live, state), way(live, state), { fit: { free: free(), ranges: live.parameters.map((p) => p.range), damping } });
  };
  const stepped = (step: FitStep): void => {
    if (!fitting) return;
    for (const k of free()) {
      state.values[k] = step.theta[k]!;
      if (owner(live, k) < 0 && !state.order.includes(k)) state.order.push(k);
    }
    panel.show(state);
    if (step.isDone) end();
    else stepFit(step.damping);
  };
  const end = (): void => {
    if (!fitting) return;
    fitting = false;
    fit.textContent = "Fit";
    said.textContent = "Fitted.";
    tell();
    ask();
  };
  const fit = h("button", { type: "button", id: "live-fit", title: "fits all parameters, and the sizes of what is switched on, to frequencies and shapes; `retune update` knows priors and targets too",
    onclick: () => {
      if (fitting) return end();
      keep(null);
      undo.disabled = false;
      fitting = true;
      fit.textContent = "Stop";
      said.textContent = "Fitting …";
      stepFit(1e-2);
    } }, "Fit");
  const address = (): string => written(live, state, nodes);
  let told = 0;
  const tell = (): void => {
    clearTimeout(told);
    told = window.setTimeout(() => {
      changed(copied(state), address());
    }, 200);
  };
  const show = (): void => {
    fitting = false;
    fit.textContent = "Fit";
    panel.show(state);
    extra.show(state.extras);
    trustBox.replaceChildren(...trust(live, state));
    undo.disabled = undone.length === 0;
    redo.disabled = redone.length === 0;
    if (!text.hidden) text.hidden = true;
    said.textContent = "";
    tell();
    ask(held == null);
  };
  /** One drag is one step back. */
  let held: string | null = null;
  const keep = (what: string | null): void => {
    if (what == null || held !== what) undone.push(copied(state));
    if (undone.length > 200) undone.shift();
    redone = [];
    held = what;
  };
  const to = (s: State): void => {
    state = copied(s);
    held = null;
    show();
  };
  const panel = controls(live, {
    value: (k, si, isLast) => {
      keep(`value ${k}`);
      state.values[k] = si;
      if (!state.order.includes(k)) state.order.push(k);
      if (isLast) held = null;
      show();
    },
    on: (i, on) => {
      keep(null);
      state.on[i] = on;
      state.order = state.order.filter((c) => c !== -1 - i);
      if (on) state.order.push(-1 - i);
      show();
    },
  });
  // How much a node may carry is asked of the model as it is reported, once.
  let local: LiveModel | null = null;
  const extra = whatIf(nodes, (node) => before && reach(local ??= new LiveModel(live), before, node, live.test.length + 2), {
    set: (e, isLast) => {
      keep(`node ${e.node}`);
      state.extras = state.extras.some((x) => x.node === e.node) ? state.extras.map((x) => (x.node === e.node ? e : x)) : [...state.extras, e];
      if (isLast) held = null;
      show();
    },
    remove: (node) => {
      keep(null);
      state.extras = state.extras.filter((x) => x.node !== node);
      show();
    },
  });
  const step = (from: State[], onto: State[]): void => {
    const s = from.pop();
    if (!s) return;
    onto.push(state);
    to(s);
  };
  const undo = h("button", { type: "button", id: "live-undo", onclick: () => step(undone, redone) }, "↶ Undo");
  const redo = h("button", { type: "button", id: "live-redo", onclick: () => step(redone, undone) }, "↷ Redo");
  const reset = (values: [number, number][]): void => {
    keep(null);
    const s = initial(live);
    for (const [k, v] of values) { s.values[k] = v; s.order.push(k); }
    to(s);
  };
  const tellAs = (content: string): void => {
    text.hidden = false;
    text.textContent = content;
    copy(said, content);
  };
  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  picture?.play(!calm);
  const handle: LiveHandle = { live, state: () => state, milliseconds, set: (s) => new Promise((done) => { heard = done; to(s); }),
    ask: (line) => new Promise((done) => { heard = (a) => done(a.prediction as Prediction); number = client.ask(point(live, state), [], { line }); }) };
  const root = h("div", { class: "split live" },
    h("div", { class: "stack" },
      h("section", { class: "card stage-card" }, picture?.viewer.root ?? null,
        h("div", { class: "toolbar" }, picture ? toggle("Move", !calm, (on) => picture.play(on), "live-move") : null,
          picture ? toggle("Test", true, (on) => picture.viewer.show("test", on)) : null, h("span", { class: "live-keys note" }, h("span", { class: "key model" }), "model now ", h("span", { class: "key test" }), "test"))),
      h("section", { class: "card" }, tableBox, fall.chart.root),
      track.root, responses.root,
      card("How right this is", null, trustBox)),
    h("aside", { class: "card side live-side" }, total,
      h("div", { class: "toolbar live-actions" }, fit, undo, redo,
        h("button", { type: "button", id: "live-reset", onclick: () => reset([]) }, "As reported"),
        (live.versions ?? []).filter((v) => v.values.length > 0).map((v, i) => h("button", { type: "button", class: "version", id: i ? null : "live-first", title: `values of ${v.name}`, onclick: () => reset(v.values) }, shorten(v.name, 24)))),
      panel.hypotheses ? h("details", { open: true }, h("summary", {}, "Hypotheses"), panel.hypotheses) : null,
      h("details", { open: true }, h("summary", {}, "Parameters"), panel.parameters),
      nodes.length && live.displacement ? h("details", { open: true }, h("summary", {}, "What if"), extra.root) : null,
      h("div", { class: "toolbar live-actions" },
        h("button", { type: "button", id: "live-command", onclick: () => tellAs(commands(live, state, nodes, model, test)) }, "Copy as commands"),
        h("button", { type: "button", id: "live-yaml", onclick: () => tellAs(yaml(live, state, nodes)) }, "Copy as YAML"),
        h("button", { type: "button", id: "live-link", onclick: () => {
          changed(copied(state), address());
          copy(said, location.href);
        } }, "Copy link"), said),
      text, h("p", { class: "note" }, soft("Sliders keep to the bounds of the parameters; a mark on a slider brings its value back."))));
  // The report's own state comes first, so that all later ones are told beside it.
  show();
  return { root, handle, take: (s) => { if (!equal(s, state)) { keep(null); to(s); } }, address };
}
