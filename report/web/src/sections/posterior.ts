/** The posterior: each parameter alone, and each two together. */

import { BINS, density, histogram } from "../bins";
import { css, sample, themed } from "../color";
import { floats } from "../decode";
import { card, h, isDark, num, s, soft, table, type Child } from "../dom";
import { fixed, significant, unit } from "../format";
import type { Posterior, Sampled } from "../types";

/** Parameters in the picture at first: what most data narrow most. */
const FIRST = 6;
const MOST = 10;

/** A value to a hundredth of a span. */
const rounded = (v: number, span: number): string => (span < 1e-3 || Math.abs(v) >= 1e6 ? significant(v, 3) : fixed(v, Math.max(0, 2 - Math.floor(Math.log10(span)) - 1)));

/** How much of its range a parameter has lost. */
const narrowed = (p: Sampled): number => 1 - (p.quantiles[4] - p.quantiles[0]) / (p.upper - p.lower || 1);

export function posteriorSection(x: Posterior): HTMLElement {
  const values = x.parameters.map((p) => floats(p.values));
  const byNarrowness = x.parameters.map((_, i) => i).sort((a, b) => narrowed(x.parameters[b]!) - narrowed(x.parameters[a]!));
  let shown = byNarrowness.slice(0, FIRST).sort((a, b) => a - b);
  // The ends of the samples, not of the bounds: a narrow posterior would be a line.
  const ends = values.map((v) => {
    let low = Infinity, high = -Infinity;
    for (const a of v) { low = Math.min(low, a); high = Math.max(high, a); }
    return low < high ? [low, high] as const : [low - 0.5, low + 0.5] as const;
  });
  const name = (i: number): string => `${x.parameters[i]!.name}${x.parameters[i]!.unit ? `, ${unit(x.parameters[i]!.unit)}` : ""}`;
  const alone = (i: number): Element => {
    const [low, high] = ends[i]!, all = histogram(values[i]!, low, high), top = Math.max(...all, 1e-12), p = x.parameters[i]!;
    const at = (v: number): number => (100 * (v - low)) / (high - low);
    return s("svg", { viewBox: "0 0 100 100", preserveAspectRatio: "none", class: "corner-cell", role: "img", "aria-label": `${p.name}: median ${significant(p.quantiles[2], 4)}, 90 % between ${significant(p.quantiles[0], 4)} and ${significant(p.quantiles[4], 4)}` },
      all.map((share, k) => s("rect", { x: (100 * k) / BINS, width: 100 / BINS + 0.2, y: 100 - (92 * share) / top, height: (92 * share) / top, class: "corner-bar" })),
      [0, 2, 4].map((q) => s("line", { x1: at(p.quantiles[q]!), x2: at(p.quantiles[q]!), y1: 0, y2: 100, class: q === 2 ? "corner-line" : "corner-line end", "vector-effect": "non-scaling-stroke" })));
  };
  const together = (column: number, row: number): HTMLElement => {
    const a = ends[column]!, b = ends[row]!, all = density(values[column]!, values[row]!, [a[0], a[1], b[0], b[1]]), top = Math.max(...all, 1);
    const rho = x.parameters[row]!.correlations[column];
    const canvas = h("canvas", { width: BINS, height: BINS, class: "corner-cell", role: "img",
      "aria-label": `${x.parameters[row]!.name} against ${x.parameters[column]!.name}: correlation ${fixed(rho, 2)}`, title: `${x.parameters[row]!.name} × ${x.parameters[column]!.name}: correlation ${fixed(rho, 2)}` });
    const context = canvas.getContext("2d")!, image = context.createImageData(BINS, BINS), map = themed("viridis", isDark());
    all.forEach((n, k) => {
      const i = k % BINS, j = BINS - 1 - Math.floor(k / BINS);
      const rgb = sample(map, Math.sqrt(n / top));
      image.data.set([...rgb, n > 0 ? 255 : 0], 4 * (BINS * j + i));
    });
    context.putImageData(image, 0, 0);
    return canvas;
  };
  const grid = h("div", { class: "corner", id: "corner" });
  const draw = (): void => {
    const n = shown.length;
    grid.style.setProperty("--n", String(n));
    grid.replaceChildren(...shown.flatMap((row, r) => [
      h("div", { class: "corner-name", style: `grid-row:${r + 1};grid-column:1` }, soft(name(row))),
      ...shown.slice(0, r + 1).map((column, c) => h("div", { class: "corner-box", style: `grid-row:${r + 1};grid-column:${c + 2}` }, r === c ? alone(row) : together(column, row))),
      ...shown.slice(r + 1).map((column, c) => {
        const rho = x.parameters[row]!.correlations[column] ?? null, rgb = rho == null ? null : sample(themed("diverging", isDark()), 0.5 + rho / 2);
        return h("div", { class: "corner-rho", style: `grid-row:${r + 1};grid-column:${r + c + 3};${rgb && Math.abs(rho!) > 0.15 ? `box-shadow:inset 0 0 0 3px ${css(rgb)}` : ""}`, title: `correlation of ${x.parameters[row]!.name} and ${x.parameters[column]!.name}` }, fixed(rho, 2));
      }),
    ]), ...shown.map((i, c) => h("div", { class: "corner-ends", style: `grid-row:${n + 1};grid-column:${c + 2}` }, ends[i]!.map((v) => h("span", {}, rounded(v, ends[i]![1] - ends[i]![0]))))));
  };
  const boxes = h("div", { class: "corner-choice", role: "group", "aria-label": "Parameters in the picture" }, x.parameters.map((p, i) => {
    const box = h("input", { type: "checkbox", "data-parameter": p.name, onchange: () => {
      shown = box.checked ? [...shown, i].sort((a, b) => a - b) : shown.filter((k) => k !== i);
      if (shown.length > MOST) shown = shown.filter((k) => k !== shown.find((o) => o !== i));
      boxes.querySelectorAll("input").forEach((b, k) => (b.checked = shown.includes(k)));
      draw();
    } });
    box.checked = shown.includes(i);
    return h("label", { class: "toggle" }, box, soft(p.name));
  }));
  draw();
  document.addEventListener("retheme", draw);
  return h("div", { class: "stack" },
    card("Each parameter alone, and each two together", "on the diagonal the samples of one parameter, with its median and the 90 % between the thin lines; below, of two, brighter where there are more; above, their correlation",
      x.parameters.length > 2 ? boxes : null, h("div", { class: "scroll" }, grid)),
    card("In numbers", `${x.samples} samples; ${x.note}`,
      table("Posterior", [{ head: "Parameter" }, { head: "Unit" }, { head: "Mean", numeric: true }, { head: "SD", numeric: true }, ...["5 %", "25 %", "50 %", "75 %", "95 %"].map((q) => ({ head: q, numeric: true })), { head: "Lower", numeric: true }, { head: "Upper", numeric: true }],
        x.parameters.map((p, i): Child[] => {
          const path = `posterior.parameters.${i}`;
          return [h("strong", {}, soft(p.name)), unit(p.unit), num(significant(p.mean, 4), `${path}.mean`), num(significant(p.sd, 3), `${path}.sd`),
            ...p.quantiles.map((q, k) => num(significant(q, 4), `${path}.quantiles.${k}`)), num(significant(p.lower, 4), `${path}.lower`), num(significant(p.upper, 4), `${path}.upper`)];
        }), { id: "posterior-table" }),
      h("p", { class: "note" }, "ln of the evidence over the bounds: ", num(fixed(x.log_evidence, 2), "posterior.log_evidence"), " ± ", num(fixed(x.log_evidence_se, 2), "posterior.log_evidence_se"), " (standard error)")));
}
