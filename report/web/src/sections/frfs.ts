/** Frequency responses: measured against model, any channel. */

import { Chart, logTicks, type Figure, type Palette } from "../charts";
import { css, ink, sample } from "../color";
import { floats, polar, type Polar } from "../decode";
import { card, choice, h, num, toggle } from "../dom";
import { fixed, plain, significant } from "../format";
import { heat } from "../heat";
import { colorBar } from "../legend";
import type { Channel, Frfs } from "../types";

type Curve = "measured" | "model" | "before";
const STYLES: Record<Curve, { name: string; dash: string; width: number }> = {
  measured: { name: "measured", dash: "solid", width: 2.2 },
  model: { name: "model", dash: "dash", width: 2 },
  before: { name: "model before", dash: "dot", width: 1.6 },
};

export function frfsSection(f: Frfs): HTMLElement {
  const STYLE = f.origin === "synthetic" ? { ...STYLES, measured: { ...STYLES.measured, name: "test (synthetic)" } } : STYLES;
  const frequency = Array.from(floats(f.frequency_hz));
  const cache = new Map<string, Polar>();
  const curve = (index: number, which: Curve): Polar | null => {
    const spectrum = f.channels[index]?.[which];
    if (!spectrum) return null;
    const key = `${index}-${which}`;
    if (!cache.has(key)) cache.set(key, polar(spectrum));
    return cache.get(key)!;
  };
  let current = 0, scale: "log" | "linear" = "log", phase = true;
  const references = new Set(f.channels.map((c) => c.reference)).size;
  const name = (c: Channel): string => c.reference ? `${c.response} / ${c.reference}` : c.response;

  const draw = (p: Palette): Figure => {
    const channel = f.channels[current]!;
    const colors: Record<Curve, string> = { measured: p.test, model: p.model, before: p.before };
    const data: Record<string, unknown>[] = [];
    const coherence = channel.coherence ? Array.from(floats(channel.coherence)) : null;
    for (const which of ["before", "measured", "model"] as Curve[]) {
      const h = curve(current, which);
      if (!h) continue;
      const line = { color: colors[which], dash: STYLE[which].dash, width: STYLE[which].width };
      const common = { type: "scatter", mode: "lines", x: frequency, line, legendgroup: which, name: STYLE[which].name };
      data.push({ ...common, y: Array.from(h.amplitude), hovertemplate: "%{x:.3f} Hz: %{y:.4g}<extra>" + STYLE[which].name + "</extra>" });
      if (phase) data.push({ ...common, y: unbroken(h.phase), yaxis: "y2", showlegend: false, hovertemplate: "%{x:.3f} Hz: %{y:.1f}°<extra>" + STYLE[which].name + "</extra>" });
    }
    if (coherence) data.push({ type: "scatter", mode: "lines", x: frequency, y: coherence, yaxis: "y3", name: "coherence", showlegend: false,
      line: { color: p.soft, width: 1.2 }, hovertemplate: "%{x:.3f} Hz: %{y:.3f}<extra>coherence</extra>" });
    const low = phase ? 0.36 : 0, third = coherence ? 0.14 : 0;
    const unit = f.unit ? ` ${f.unit}` : "";
    return {
      data,
      layout: {
        margin: { l: 72 },
        xaxis: { title: { text: "frequency, Hz" }, anchor: coherence ? "y3" : phase ? "y2" : "y" },
        yaxis: { title: { text: plain(`|${f.quantity}|,${unit}`) }, type: scale, ...(scale === "log" ? logTicks(data.filter((t) => !t["yaxis"]).flatMap((t) => extremes(t["y"] as ArrayLike<number>))) : {}), domain: [Math.max(low, third) + (phase || coherence ? 0.05 : 0), 1] },
        ...(phase ? { yaxis2: { title: { text: "phase, °" }, domain: [third ? third + 0.04 : 0, 0.36], range: [-190, 190], tickvals: [-180, -90, 0, 90, 180] } } : {}),
        ...(coherence ? { yaxis3: { title: { text: "coh." }, domain: [0, phase ? third : 0.16], range: [0, 1.05], tickvals: [0, 1] } } : {}),
        hovermode: "x unified",
        shapes: f.bands.slice(0, 40).map((b) => ({ type: "line", x0: b.from_hz, x1: b.from_hz, y0: 0, y1: 1, yref: "paper", line: { color: p.grid, width: 1, dash: "dot" } })),
      },
    };
  };
  const chart = new Chart("Amplitude and phase of the chosen channel", draw, 560, "frf");
  chart.root.id = "frf-chart";

  const bandTable = h("div", { id: "frf-bands" });
  const title = h("h4", { id: "frf-title", "aria-live": "polite" });
  const bands = (): void => {
    const c = f.channels[current]!;
    const old = (c.frac_before?.length ?? 0) > 0;
    title.textContent = name(c);
    bandTable.replaceChildren(f.bands.length ? h("table", {},
      h("thead", {}, h("tr", {}, h("th", { scope: "col" }, "Band"), h("th", { scope: "col", class: "right" }, "Hz"),
        h("th", { scope: "col", class: "right" }, "FRAC"), old ? h("th", { scope: "col", class: "right" }, "before") : null,
        h("th", { scope: "col", class: "right", title: "over all channels" }, "CSAC"), h("th", { scope: "col", class: "right", title: "over all channels" }, "CSF"))),
      h("tbody", {}, f.bands.map((b, k) => h("tr", {}, h("td", {}, b.name),
        h("td", { class: "right nowrap" }, `${significant(b.from_hz, 3)}–${significant(b.to_hz, 3)}`),
        h("td", { class: "right" }, num(fixed(c.frac[k], 3), `frfs.channels.${current}.frac.${k}`)),
        old ? h("td", { class: "right" }, num(fixed(c.frac_before?.[k], 3), `frfs.channels.${current}.frac_before.${k}`)) : null,
        h("td", { class: "right" }, num(fixed(b.csac, 3), `frfs.bands.${k}.csac`)),
        h("td", { class: "right" }, num(fixed(b.csf, 3), `frfs.bands.${k}.csf`)))))) : "");
  };
  const choose = (index: number): void => {
    current = (index + f.channels.length) % f.channels.length;
    select.value = String(current);
    for (const row of overview.querySelectorAll<HTMLElement>("[data-channel]")) {
      row.setAttribute("aria-current", String(row.dataset["channel"] === String(current)));
    }
    bands();
    chart.refresh();
  };
  const select = h("select", { id: "frf-channel", onchange: () => choose(Number(select.value)) },
    f.channels.map((c, i) => h("option", { value: i }, name(c))));

  // The worst channels first: where a reader should look.
  const worst = f.channels.map((c, i) => ({ i, mean: mean(c.frac) })).sort((a, b) => (a.mean ?? 2) - (b.mean ?? 2));
  const overview = h("div", { class: "channel-list", role: "region", tabindex: 0, "aria-label": "Channels by FRAC, lowest first" },
    worst.map(({ i, mean: m }) => {
      const c = f.channels[i]!;
      return h("button", { type: "button", class: f.bands.length > 4 ? "channel many" : "channel", "data-channel": i, onclick: () => choose(i) },
        h("span", { class: "channel-name" }, references > 1 ? name(c) : c.response),
        h("span", { class: "channel-cells" }, c.frac.map((v, k) => {
          const rgb = sample("viridis", v ?? NaN);
          return h("span", { class: "cell", style: `background:${css(rgb)};color:${ink(rgb)}`, title: `${f.bands[k]?.name ?? ""} FRAC` }, fixed(v, 2));
        })), m == null ? null : h("span", { class: "visually-hidden" }, `mean FRAC ${fixed(m, 2)}`));
    }));
  const section = h("div", { class: "split reverse" },
    h("aside", { class: "card side" },
      h("h4", { class: "list-title" }, f.bands.length ? "Channels, lowest FRAC first" : "Channels"), overview,
      f.bands.length ? colorBar("viridis", "0", "1", "FRAC by band") : null),
    h("div", { class: "stack" },
      card(f.origin === "synthetic" ? "Test against model" : "Measured against model", `${f.quantity} of ${f.channels.length} ${f.channels.length === 1 ? "channel" : "channels"} on ${frequency.length} lines${f.origin ? `, ${f.origin}` : ""}; drag in the picture to zoom, double-click to return`,
        h("div", { class: "toolbar" },
          h("label", { class: "field" }, "Channel ", select),
          h("button", { type: "button", "aria-label": "Previous channel", onclick: () => choose(current - 1) }, "‹"),
          h("button", { type: "button", "aria-label": "Next channel", onclick: () => choose(current + 1) }, "›"),
          choice("Amplitude axis", [{ value: "log", text: "log" }, { value: "linear", text: "linear" }], "log", (v) => { scale = v; chart.refresh(); }),
          toggle("Phase", true, (on) => { phase = on; chart.refresh(); })),
        title, chart.root, f.note ? h("p", { class: "note" }, f.note) : null),
      f.bands.length ? card("Agreement per band", "FRAC of this channel; CSAC (shape) and CSF (size) over all channels; 1 is perfect", h("div", { class: "scroll" }, bandTable)) : null,
      f.fdac.length ? fdacCard(f) : null));
  choose(worst[0]?.i ?? 0);
  return section;
}

/** FDAC: a line of likeness beside the diagonal means that the model's frequencies are off by that much. */
function fdacCard(f: Frfs): HTMLElement {
  const before = f.fdac_before.length > 0;
  const picture = (k: number, which: "fdac" | "fdac_before", title: string): HTMLElement => h("figure", { class: "mac" }, h("figcaption", {}, title),
    heat(f[which][k]!, { map: "viridis", low: 0, high: 1, path: (i, j) => `frfs.${which}.${k}.values.${i}.${j}`, decimals: 3 }));
  const pictures = f.fdac.map((m, k) => [before && f.fdac_before[k] ? picture(k, "fdac_before", `${m.title}, before`) : null, picture(k, "fdac", before ? `${m.title}, after` : m.title)]);
  return card("FDAC", "likeness of the responses at one frequency of the model (down) and one of the test (across): a ridge beside the diagonal is a shift of frequency",
    h("div", { class: "columns fdac" }, pictures), colorBar("viridis", "0", "1", "FDAC"));
}

/** The least and the largest positive value of a curve. */
function extremes(values: ArrayLike<number>): number[] {
  let low = Infinity, high = 0;
  for (let i = 0; i < values.length; i++) {
    const v = values[i]!;
    if (v > 0 && v < low) low = v;
    if (v > high) high = v;
  }
  return high > 0 ? [low, high] : [];
}

/** The phase with a gap where it passes ±180°: that jump is the edge of the picture, not of the curve. */
export function unbroken(phase: ArrayLike<number>): (number | null)[] {
  return Array.from(phase, (v, i) => (i > 0 && Math.abs(v - phase[i - 1]!) > 180 ? null : v));
}

function mean(values: (number | null)[]): number | null {
  const numbers = values.filter((v): v is number => v != null && Number.isFinite(v));
  return numbers.length ? numbers.reduce((a, b) => a + b, 0) / numbers.length : null;
}
