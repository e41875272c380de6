/** Which test the model is held against, and the model in the reader's hands. */

import { h, soft } from "../dom";
import { significant } from "../format";
import { Client } from "../live/client";
import { livePanel, type LiveHandle, type Panel } from "../live/panel";
import { carried, initial, point, read, type State } from "../live/state";
import type { Live, ReportData, Structure } from "../types";

declare global {
  var retuneLive: LiveHandle | undefined;
}

/** χ² of a test that is not in sight, as reported and now, told by its row of the chooser. */
class Row {
  readonly root: HTMLElement;
  private readonly button: HTMLElement;
  private readonly chi: HTMLElement;
  private readonly client: Client;
  private reported: number | null = null;
  now: number | null = null;

  constructor(readonly live: Live, index: number, more: string[], choose: () => void, changed: () => void) {
    const name = live.test_name || `test ${index + 1}`;
    this.chi = h("td", { class: "right" });
    this.button = h("button", { type: "button", class: "link", "data-test-of": index, onclick: choose }, soft(name));
    this.root = h("tr", {}, h("td", {}, this.button), more.map((text) => h("td", {}, text)), this.chi);
    this.client = new Client(live, ({ prediction }) => {
      this.now = "unstable" in prediction ? null : prediction.chiSquared;
      this.reported ??= this.now;
      this.chi.replaceChildren(this.now == null ? "no modes" : h("span", { "data-chi-of": String(this.now) }, significant(this.now, 4)),
        h("span", { class: "note as-reported" }, ` reported ${this.reported == null ? "–" : significant(this.reported, 4)}, noise about ${live.n_data}`));
      changed();
    });
    this.ask(initial(live));
  }

  ask(state: State): void {
    this.client.ask(point(this.live, state), []);
  }

  choose(on: boolean): void {
    this.root.setAttribute("aria-current", String(on));
    this.button.setAttribute("aria-pressed", String(on));
  }
}

export function liveSection(data: ReportData): HTMLElement {
  const all = data.live!, structures = all.map((l) => l.structure ?? data.structure);
  const names = structures.map((s: Structure | undefined) => s?.nodes.map((n) => n.name) ?? []);
  const files = (role: string): string[] => data.meta.files.filter((f) => f.role === role).map((f) => f.path);
  const panels: (Panel | undefined)[] = [];
  const place = h("div", {}), sum = h("p", { class: "note", id: "live-sum", "aria-live": "polite" });
  let current = -1;

  const write = (part: string): void => {
    const whole = [...(current > 0 ? [`of:${current + 1}`] : []), ...(part ? [part] : [])].join(";");
    if (location.hash.slice(1).split("/")[0] === "live") history.replaceState(null, "", `#live${whole ? `/${whole}` : ""}`);
  };
  const panel = (k: number): Panel => (panels[k] ??= livePanel({
    live: all[k]!, structure: structures[k], frfs: k ? undefined : data.frfs, model: files("model")[0] ?? "MODEL.yaml", test: files("test")[k] ?? "TEST.yaml",
    changed: (state, part) => {
      if (k !== current) return;
      write(part);
      rows.forEach((row, i) => row.ask(i === k ? state : carried(all[k]!, state, names[k]!, all[i]!, names[i]!)));
    },
  }));
  const open = (k: number, state?: State): void => {
    const from = panels[current], left = current;
    current = k;
    const next = panel(k);
    const now = state ?? (from && left !== k ? carried(all[left]!, from.handle.state(), names[left]!, all[k]!, names[k]!) : undefined);
    place.replaceChildren(next.root);
    globalThis.retuneLive = next.handle;
    rows.forEach((row, i) => row.choose(i === k));
    if (now) next.take(now);
    write(next.address());
  };
  // A column that says something of one of the tests at least.
  const dates = all.map((l) => data.meta.tests?.find((t) => t.name === l.test_name)?.date);
  const columns = [{ head: "configuration", of: all.map((l) => l.configuration) }, { head: "date", of: dates }].filter((c) => c.of.some((v) => v != null));
  const rows = all.length < 2 ? [] : all.map((live, k) => new Row(live, k, columns.map((c) => c.of[k] ?? "–"), () => open(k), () => {
    const known = rows.map((r) => r.now);
    sum.textContent = known.some((v) => v == null) ? "" : `All tests together: χ² ${significant(known.reduce<number>((s, v) => s + v!, 0), 4)}, noise about ${all.reduce((s, l) => s + l.n_data, 0)}. Parameters, hypotheses and what stands at nodes are common to them.`;
  }));
  const fromAddress = (): void => {
    const [tab, ...rest] = location.hash.slice(1).split("/");
    if (tab !== "live") return current < 0 ? open(0) : undefined;
    const text = rest.join("/"), asked = Number(/^of:(\d+)/.exec(text)?.[1] ?? 1) - 1, k = all[asked] ? asked : 0;
    open(k, read(all[k]!, text, names[k]!));
  };
  addEventListener("hashchange", fromAddress);
  fromAddress();
  return rows.length === 0 ? place : h("div", { class: "stack" }, h("section", { class: "card", id: "live-tests" },
    h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Tests" }, h("table", {},
      h("caption", { class: "visually-hidden" }, "Tests that the model can be held against"),
      h("thead", {}, h("tr", {}, ["Held against", ...columns.map((c) => c.head)].map((t) => h("th", { scope: "col" }, t)), h("th", { scope: "col", class: "right" }, "χ² now"))),
      h("tbody", {}, rows.map((r) => r.root)))), sum), place);
}
