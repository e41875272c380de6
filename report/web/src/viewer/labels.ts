/** Names and axes, written over the picture. */

import type { Flat } from "../pick";

export interface Paper { context: CanvasRenderingContext2D; width: number; height: number; ink: string; halo: string }

function write({ context, ink, halo }: Paper, text: string, x: number, y: number): void {
  context.lineWidth = 3;
  context.strokeStyle = halo;
  context.strokeText(text, x, y);
  context.fillStyle = ink;
  context.fillText(text, x, y);
}

/** An empty sheet over the picture; `ratio` of its pixels to those of the page. */
export function clear({ context, width, height }: Paper, ratio: number): void {
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = "12px system-ui, sans-serif";
  context.lineJoin = "round";
}

/** Names at their places; one that would cover an earlier one is left out. */
export function names(paper: Paper, all: Iterable<{ text: string; at: Flat }>): void {
  const taken: [number, number, number, number][] = [];
  for (const { text, at } of all) {
    const w = paper.context.measureText(text).width;
    const box: [number, number, number, number] = [at.x + 7, at.y - 14, at.x + 9 + w, at.y + 1];
    if (Math.abs(at.depth) > 1 || taken.some((t) => t[0] < box[2] && box[0] < t[2] && t[1] < box[3] && box[1] < t[3])) continue;
    taken.push(box);
    write(paper, text, at.x + 8, at.y - 4);
  }
}

/** The axes, bottom left; `ends` are where short axes from `origin` end on the screen. */
export function axes(paper: Paper, origin: Flat, ends: [Flat, Flat, Flat]): void {
  const { context, height } = paper;
  const scale = 30 / (height * 0.085);
  for (const [k, name] of ["x", "y", "z"].entries()) {
    const p = ends[k]!;
    const x = 44 + (p.x - origin.x) * scale * 0.9, y = height - 44 + (p.y - origin.y) * scale * 0.9;
    context.strokeStyle = paper.ink;
    context.globalAlpha = 0.65;
    context.lineWidth = 1.5;
    context.beginPath();
    context.moveTo(44, height - 44);
    context.lineTo(x, y);
    context.stroke();
    if (Math.hypot(x - 44, y - height + 44) > 8) write(paper, name, x + (x - 44) * 0.22 - 3, y + (y - height + 44) * 0.22 + 4);
    context.globalAlpha = 1;
  }
}
