/** Mode shapes in motion: the test over the model, pair by pair. */

import { css, onStage, parseHex, type Rgb } from "../color";
import { floats, motion } from "../decode";
import { badge, choice, h, isDark, num, toggle } from "../dom";
import { fixed, hertz, percent } from "../format";
import { colorBar, swatches } from "../legend";
import { difference, peak, peakOfNodes, scaleFactor, times, type Shape } from "../shape";
import { makeViewer, type Viewer } from "../viewer";
import type { Comparison, Modes, Pair, Structure, TestMode } from "../types";

interface Entry { id: string; title: string; test: number | null; model: number | null; pair: Pair | null; index: number }

/** Pairs first, then what has no partner. */
export function entries(modes: Modes, comparison: Comparison | undefined): Entry[] {
  const list: Entry[] = [];
  const usedTest = new Set<number>(), usedModel = new Set<number>();
  comparison?.pairs.forEach((pair, index) => {
    const test = pair.test_mode != null && modes.test[pair.test_mode] ? pair.test_mode : null;
    const model = pair.model_mode != null && modes.model[pair.model_mode] ? pair.model_mode : null;
    if (test == null && model == null) return;
    if (test != null) usedTest.add(test);
    if (model != null) usedModel.add(model);
    list.push({ id: `pair-${index}`, title: pair.label, test, model, pair, index });
  });
  modes.test.forEach((m, i) => {
    if (!usedTest.has(i)) list.push({ id: `test-${i}`, title: m.label, test: i, model: null, pair: null, index: i });
  });
  modes.model.forEach((m, i) => {
    if (!usedModel.has(i)) list.push({ id: `model-${i}`, title: m.label, test: null, model: i, pair: null, index: i });
  });
  return list;
}

function shapeOf(re: string | undefined, im: string | undefined): Shape | null {
  return re ? { re: floats(re), im: im ? floats(im) : undefined } : null;
}

const isExpanded = (m: TestMode): boolean => m.expanded != null || m.expanded_levels != null;

type Coloring = "difference" | "motion" | "plain";
type Layout = "overlaid" | "beside" | "expanded";

export function modesSection(s: Structure, modes: Modes, comparison: Comparison | undefined): HTMLElement {
  const list = entries(modes, comparison);
  const viewer = makeViewer(s, { label: "Mode shapes of test and model", fill: 0.74 });
  viewer.root.id = "modes-viewer";
  for (const layer of ["nodes", "sensors"] as const) viewer.show(layer, false);
  viewer.show("masses", false);
  viewer.show("ghost", true);
  const hasTest = modes.test.some((m) => m.at_sensors), hasExpanded = modes.test.some(isExpanded);
  viewer.show("test", hasTest);

  const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
  let playing = !calm, phase = 0, amplitude = 0.18, speed = 0.7, coloring: Coloring = "difference", last = 0;
  let current = list[0]!;
  let modelOn = true, testOn = true, layout: Layout = "overlaid";
  // The picture of the test alone, once somebody asks for it.
  let beside: Viewer | null = null;
  const pictures = h("div", { class: "pictures" }, viewer.root);
  const legend = h("div", { class: "legend" });
  const facts = h("div", { class: "mode-facts", id: "mode-facts", "aria-live": "polite" });

  const load = (): void => {
    const model = current.model == null ? null : modes.model[current.model]!;
    const test = current.test == null ? null : modes.test[current.test]!;
    let displacement: Shape | null = model ? { re: motion(model.displacement, model.displacement_levels), im: model.displacement_imag ? floats(model.displacement_imag) : undefined } : null;
    let rotation = model?.rotation ? { re: floats(model.rotation) } as Shape : null;
    let atSensors = model ? shapeOf(model.at_sensors, model.at_sensors_imag) : null;
    let measured = test ? shapeOf(test.at_sensors, test.at_sensors_imag) : null;
    if (displacement && displacement.re.length < 3 * s.nodes.length) displacement = null;
    if (rotation && rotation.re.length < 3 * s.nodes.length) rotation = null;
    // The largest motion of nodes and sensors alike: a spar that only twists moves little, its edges move much.
    const unit = displacement ? 1 / (Math.max(peakOfNodes(displacement), atSensors ? peak(atSensors) : 0) || 1) : 1;
    if (displacement) displacement = times(displacement, [unit, 0]);
    if (rotation) rotation = times(rotation, [unit, 0]);
    if (atSensors) atSensors = times(atSensors, [unit, 0]);
    const raw = measured;
    if (measured) measured = atSensors ? times(measured, scaleFactor(measured, atSensors)) : times(measured, [1 / (peak(measured) || 1), 0]);
    // Without a model shape the expanded test moves the structure itself.
    const expanded = test && isExpanded(test) ? motion(test.expanded, test.expanded_levels) : null;
    if (!displacement && expanded && raw) displacement = times({ re: expanded }, [1 / (peak(raw) || 1), 0]);
    viewer.setShapes(displacement && { displacement, rotation }, measured);
    let spread: Shape | null = null;
    if (expanded) {
      spread = { re: expanded };
      spread = times(spread, displacement ? scaleFactor(spread, displacement) : [1 / (peakOfNodes(spread) || 1), 0]);
    }
    beside?.setShapes(spread && { displacement: spread, rotation: null }, measured);

    const gap = measured && atSensors ? difference(measured, atSensors) : null;
    const top = gap ? Math.max(0.1, gap.reduce((a, b) => (Number.isFinite(b) ? Math.max(a, b) : a), 0)) : 1;
    // A point is as far off as the worst of its channels.
    const worst = (all: readonly number[]): number => all.reduce((m, i) => (gap![i]! > m || !Number.isFinite(m) ? gap![i]! : m), NaN);
    const size = displacement;
    const dark = isDark();
    const moved = (i: number) => onStage("viridis", Math.hypot(size!.re[3 * i]!, size!.re[3 * i + 1]!, size!.re[3 * i + 2]!), dark);
    const style = getComputedStyle(document.documentElement);
    const [plainModel, testColor, neutral] = ["--model", "--test", "--rest"].map((n) => parseHex(style.getPropertyValue(n).trim())) as [Rgb, Rgb, Rgb];
    const effective = coloring === "difference" && !gap ? "plain" : coloring;
    const modelColor = effective === "difference" ? neutral : plainModel;
    viewer.paint(
      effective === "difference" ? { elements: () => modelColor, nodes: () => modelColor, test: (all) => onStage("viridis", worst(all) / top, dark) }
      : effective === "motion" && size ? { nodes: moved, test: () => testColor }
      : { elements: () => modelColor, nodes: () => modelColor, test: () => testColor });
    beside?.paint({ elements: () => testColor, nodes: () => testColor,
      test: effective === "difference" ? (all) => onStage("viridis", worst(all) / top, dark) : () => testColor });
    const keys = [];
    if (model) keys.push({ name: "model", color: css(modelColor) });
    if (test && effective !== "difference") keys.push({ name: "test", color: css(testColor) });
    legend.replaceChildren(
      effective === "difference" ? colorBar("viridis", "0", `${fixed(100 * top, 0)} %`, "|test − model| of the largest motion, at the sensors", { dark }) : "",
      effective === "motion" && size ? colorBar("viridis", "0", "largest", "motion of the model", { dark }) : "",
      keys.length && !(effective === "motion" && !test) ? swatches("", effective === "motion" ? keys.filter((k) => k.name === "test") : keys) : "");

    const { pair, index } = current;
    const row = (name: string, value: Node | string): Node[] => [h("dt", {}, name), h("dd", {}, value)];
    facts.replaceChildren(
      h("h4", {}, current.title || "mode"),
      pair ? (pair.passes == null ? "" : badge(pair.passes ? "good" : "bad", pair.passes ? "meets the criteria" : "misses the criteria"))
        : badge("warning", current.test != null ? "test mode without a partner" : "model mode without a partner"),
      h("dl", { class: "facts" },
        test ? row("test", num(hertz(test.frequency_hz), `modes.test.${current.test}.frequency_hz`)) : null,
        model ? row("model", num(hertz(model.frequency_hz), `modes.model.${current.model}.frequency_hz`)) : null,
        pair ? row("error", num(percent(pair.error), `comparison.pairs.${index}.error`, 100)) : null,
        pair?.mac != null ? row("MAC", num(fixed(pair.mac, 3), `comparison.pairs.${index}.mac`)) : null,
        test?.damping_ratio != null ? row("damping (test)", num(`${fixed(100 * test.damping_ratio, 2)} %`, `modes.test.${current.test}.damping_ratio`, 100)) : null,
        model?.damping_ratio != null ? row("damping (model)", num(`${fixed(100 * model.damping_ratio, 2)} %`, `modes.model.${current.model}.damping_ratio`, 100)) : null,
        test?.origin ? row("test shape", test.origin) : null,
        layout === "expanded" && test ? row("expanded", expanded ? "the readings by the model's stiffness and mass, weighed against their noise" : "not this one: it has no partner or no shape") : null));
    for (const b of buttons.querySelectorAll("button")) b.setAttribute("aria-current", String(b.dataset["id"] === current.id));
    show();
  };

  const phaseInput = h("input", { type: "range", min: 0, max: 360, step: 1, value: 0, id: "phase", "aria-label": "Phase in degrees",
    oninput: () => { setPlaying(false); phase = (Number(phaseInput.value) * Math.PI) / 180; show(); } });
  const phaseText = h("output", { class: "out" }, "0°");
  const amplitudeInput = h("input", { type: "range", min: 0, max: 50, step: 1, value: 18, id: "amplitude", "aria-label": "Amplitude",
    oninput: () => { amplitude = Number(amplitudeInput.value) / 100; show(); } });
  const play = h("button", { type: "button", id: "play", class: "primary", onclick: () => setPlaying(!playing) });
  const setPlaying = (on: boolean): void => {
    playing = on;
    play.textContent = on ? "❚❚ Pause" : "▶ Play";
    play.setAttribute("aria-pressed", String(on));
    if (on) { last = 0; requestAnimationFrame(tick); }
  };
  const show = (): void => {
    const degrees = Math.round((phase * 180) / Math.PI) % 360;
    phaseInput.value = String(degrees);
    phaseText.textContent = `${degrees}°`;
    viewer.frame(phase, amplitude);
    beside?.frame(phase, amplitude);
  };
  const arrange = (): void => {
    if (layout !== "overlaid" && !beside) {
      beside = makeViewer(s, { label: "Shape of the test", fill: 0.74 });
      beside.root.id = "test-viewer";
      for (const layer of ["nodes", "sensors", "masses", "links"] as const) beside.show(layer, false);
      beside.show("ghost", atRest);
      beside.show("test", true);
      beside.join(viewer);
    }
    pictures.replaceChildren(viewer.root, ...(beside && layout !== "overlaid" ? [beside.root] : []));
    pictures.classList.toggle("two", layout !== "overlaid");
    viewer.show("test", testOn && layout === "overlaid" && hasTest);
    beside?.show("elements", layout === "expanded");
    load();
  };
  let atRest = true;
  const tick = (now: number): void => {
    if (!playing) return;
    if (viewer.root.isConnected && viewer.root.clientWidth > 0) {
      if (last) {
        phase = (phase + (Math.min(now - last, 100) / 1000) * 2 * Math.PI * speed) % (2 * Math.PI);
        show();
      }
      last = now;
      requestAnimationFrame(tick);
    } else {
      last = 0;
      setTimeout(() => requestAnimationFrame(tick), 250);
    }
  };
  const move = (step: number): void => {
    current = list[(list.indexOf(current) + step + list.length) % list.length]!;
    load();
  };

  const entryButton = (e: Entry): HTMLElement => {
    const test = e.test == null ? null : modes.test[e.test]!, model = e.model == null ? null : modes.model[e.model]!;
    return h("li", {}, h("button", { type: "button", class: "mode-button", "data-id": e.id, onclick: () => { current = e; load(); } },
      h("span", { class: "mode-name" }, e.title || "mode"),
      h("span", { class: "mode-hz" }, [test && `${fixed(test.frequency_hz, 2)}`, model && `${fixed(model.frequency_hz, 2)}`].filter(Boolean).join(" / ") + " Hz"),
      e.pair?.mac != null ? h("span", { class: "mode-mac", title: "MAC" }, fixed(e.pair.mac, 2)) : null));
  };
  const group = (title: string, part: Entry[]): HTMLElement | null => part.length
    ? h("div", {}, h("h4", { class: "list-title" }, title), h("ul", { class: "mode-list" }, part.map(entryButton))) : null;
  const buttons = h("nav", { class: "modes-nav", "aria-label": "Modes" },
    group("Pairs: test / model", list.filter((e) => e.pair)),
    group(comparison ? "Test modes without a partner" : "Test modes", list.filter((e) => !e.pair && e.test != null)),
    group(comparison ? "Model modes without a partner" : "Model modes", list.filter((e) => !e.pair && e.model != null)));

  const both = hasTest && modes.model.length > 0;
  const colorings: { value: Coloring; text: string }[] = [
    ...(both ? [{ value: "difference" as const, text: "difference" }] : []), { value: "motion", text: "motion" }, { value: "plain", text: "plain" },
  ];
  coloring = colorings[0]!.value;
  setPlaying(playing);
  load();
  document.addEventListener("retheme", load);
  const modelToggle = toggle("Model", true, (on) => { modelOn = on; viewer.show("elements", modelOn); viewer.show("links", modelOn); }, "show-model");
  return h("div", { class: "split reverse" },
    h("aside", { class: "card side" }, buttons),
    h("section", { class: "card stage-card" }, pictures,
      h("div", { class: "toolbar" },
        h("div", { class: "player" },
          h("button", { type: "button", "aria-label": "Previous mode", onclick: () => move(-1) }, "‹"), play,
          h("button", { type: "button", "aria-label": "Next mode", onclick: () => move(1) }, "›")),
        h("label", { class: "field slider" }, "Amplitude ", amplitudeInput),
        h("label", { class: "field slider" }, "Phase ", phaseInput, phaseText),
        h("label", { class: "field slider" }, "Speed ", h("input", { type: "range", min: 1, max: 20, value: 7, "aria-label": "Speed",
          oninput: (e: Event) => { speed = Number((e.target as HTMLInputElement).value) / 10; } })),
        choice("Colour", colorings, coloring, (c) => { coloring = c; load(); }),
        both ? choice("Test and model", [{ value: "overlaid" as const, text: "overlaid" }, { value: "beside" as const, text: "side by side" },
          ...(hasExpanded ? [{ value: "expanded" as const, text: "test expanded" }] : [])], layout, (v) => { layout = v; arrange(); }) : null,
        modelToggle, both ? toggle("Test", true, (on) => { testOn = on; viewer.show("test", on && layout === "overlaid"); }, "show-test") : null,
        toggle("At rest", true, (on) => { atRest = on; viewer.show("ghost", on); beside?.show("ghost", on); })),
      h("div", { class: "below" }, facts, legend)));
}
