/** Colour maps that colour-blind readers can follow, and the palette of the page. */

export type Rgb = [number, number, number];

/** Anchors at equal distances, from the maps of matplotlib (cividis: Nuñez, Anderton, Renslow, PLoS ONE, 2018). */
const MAPS = {
  cividis: "00224e 002e6a 1a386f 32436d 434e6c 535a6d 61656f 6f7073 7d7c78 8c8878 9b9476 aba072 bcae6c cdbb63 dec958 f0d846 fee838",
  viridis: "440154 48186a 472d7b 424086 3b528b 33638d 2c728e 26828e 21918c 1fa088 28ae80 3fbc73 5ec962 84d44b addc30 d8e219 fde725",
  diverging: "053061 175290 2a71b2 3f8ec0 6bacd1 9bc9e0 c2ddec e0ecf3 f7f6f6 fbe5d8 fbccb4 f5aa89 e48066 d05548 ba2832 930e26 67001f",
  /** The same ends with a dark middle, for a dark page. */
  divergingDark: "8fd0ff 78bdf0 62a9dd 4e93c8 3d7db0 316796 29527a 24405e 242f3c 4a3a38 6d443c 8f4f42 b05c49 cd6c55 e37f66 f3957d ffad98",
};
export type MapName = keyof typeof MAPS;

/** The map as it looks in the theme. */
export function themed(map: MapName, dark: boolean): MapName {
  return map === "diverging" && dark ? "divergingDark" : map;
}

export function parseHex(hex: string): Rgb {
  const n = parseInt(hex.replace("#", ""), 16);
  return [(n >> 16) & 255, (n >> 8) & 255, n & 255];
}

const ANCHORS = Object.fromEntries(
  Object.entries(MAPS).map(([name, list]) => [name, list.split(" ").map(parseHex)]),
) as Record<MapName, Rgb[]>;

/** The colour at `t` in 0..1 (clamped); middle grey where there is no number. */
export function sample(map: MapName, t: number): Rgb {
  if (!Number.isFinite(t)) return [150, 150, 150];
  const anchors = ANCHORS[map];
  const place = Math.min(Math.max(t, 0), 1) * (anchors.length - 1);
  const i = Math.min(Math.floor(place), anchors.length - 2);
  const f = place - i;
  const a = anchors[i]!, b = anchors[i + 1]!;
  return [0, 1, 2].map((k) => Math.round(a[k]! + (b[k]! - a[k]!) * f)) as Rgb;
}

export function css([r, g, b]: Rgb): string {
  return `rgb(${r} ${g} ${b})`;
}

/**
 * The part of a sequential map that stands out from the stage of a 3-D picture: the dark end is lost on a dark stage,
 * the bright end on a light one.
 */
export function stagePart(map: MapName, dark: boolean): [number, number] {
  return map === "diverging" || map === "divergingDark" ? [0, 1] : dark ? [0.28, 1] : [0, 0.92];
}

/** The colour at `t` on a 3-D stage. */
export function onStage(map: MapName, t: number, dark: boolean): Rgb {
  const [low, high] = stagePart(map, dark);
  return sample(map, Number.isFinite(t) ? low + (high - low) * Math.min(1, Math.max(0, t)) : NaN);
}

/** A CSS gradient of a part of the map, left to right. */
export function gradient(map: MapName, [low, high]: [number, number] = [0, 1]): string {
  const stops = Array.from({ length: 17 }, (_, i) => css(sample(map, low + ((high - low) * i) / 16)));
  return `linear-gradient(to right, ${stops.join(", ")})`;
}

/** Relative luminance, WCAG 2.2. */
export function luminance(rgb: Rgb): number {
  const [r, g, b] = rgb.map((c) => {
    const v = c / 255;
    return v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
  }) as Rgb;
  return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

/** Contrast ratio of two colours, 1 to 21, WCAG 2.2. */
export function contrast(a: Rgb, b: Rgb): number {
  const [low, high] = [luminance(a), luminance(b)].sort((x, y) => x - y) as [number, number];
  return (high + 0.05) / (low + 0.05);
}

/** Black or white, whichever reads better on `rgb`. */
export function ink(rgb: Rgb): "#ffffff" | "#10151c" {
  return contrast(rgb, [255, 255, 255]) >= contrast(rgb, [16, 21, 28]) ? "#ffffff" : "#10151c";
}

/** Colours for categories, after Okabe and Ito, Color universal design, 2008, lightened or darkened for the theme. */
export function categories(dark: boolean): string[] {
  return dark
    ? ["#5aaef0", "#f0a13c", "#35c29a", "#e88fbd", "#f0e05a", "#8fd0f5", "#f07f4a", "#b9a5f5", "#a8b3c0", "#9fd36b"]
    : ["#0072b2", "#d98a00", "#00846a", "#b8568c", "#8a7d00", "#3a8fc4", "#c24e00", "#6a51c4", "#5f6b78", "#4f8a1f"];
}
