/** Pointer, wheel and keys over a picture, as what they mean. */

export interface Gestures {
  turn(dx: number, dy: number): void;
  pan(dx: number, dy: number): void;
  /** Closer with a factor below 1. */
  zoom(factor: number): void;
  reset(): void;
  pick(event: PointerEvent): void;
  hover(event: PointerEvent): void;
  leave(): void;
}

const STEP = 24;
const TURNS: Record<string, [number, number]> = {
  ArrowLeft: [-STEP, 0], ArrowRight: [STEP, 0], ArrowUp: [0, -STEP], ArrowDown: [0, STEP],
};

export function listen(canvas: HTMLCanvasElement, to: Gestures): void {
  const down = new Map<number, { x: number; y: number }>();
  let moved = 0;
  canvas.addEventListener("pointerdown", (e) => {
    if (down.size === 0) moved = 0;
    down.set(e.pointerId, { x: e.clientX, y: e.clientY });
    canvas.setPointerCapture(e.pointerId);
    to.leave();
  });
  canvas.addEventListener("pointermove", (e) => {
    const last = down.get(e.pointerId);
    if (!last) return to.hover(e);
    const dx = e.clientX - last.x, dy = e.clientY - last.y;
    moved += Math.abs(dx) + Math.abs(dy);
    if (down.size === 2) {
      const other = [...down].find(([id]) => id !== e.pointerId)![1];
      const before = Math.hypot(last.x - other.x, last.y - other.y), after = Math.hypot(e.clientX - other.x, e.clientY - other.y);
      if (after > 0) to.zoom(before / after);
    } else if (e.shiftKey || e.buttons === 2 || e.buttons === 4) to.pan(dx, dy);
    else to.turn(dx, dy);
    down.set(e.pointerId, { x: e.clientX, y: e.clientY });
  });
  canvas.addEventListener("pointerup", (e) => {
    down.delete(e.pointerId);
    if (moved < 6) to.pick(e);
  });
  canvas.addEventListener("pointercancel", (e) => down.delete(e.pointerId));
  canvas.addEventListener("pointerleave", () => to.leave());
  canvas.addEventListener("contextmenu", (e) => e.preventDefault());
  canvas.addEventListener("wheel", (e) => {
    // The page scrolls over a picture that was not chosen; a chosen one zooms.
    if (document.activeElement !== canvas && !e.ctrlKey) return;
    e.preventDefault();
    to.zoom(Math.exp(e.deltaY * 0.0012));
  }, { passive: false });
  canvas.addEventListener("keydown", (e) => {
    const by = TURNS[e.key];
    if (by && e.shiftKey) to.pan(...by);
    else if (by) to.turn(...by);
    else if (e.key === "+" || e.key === "=") to.zoom(0.85);
    else if (e.key === "-") to.zoom(1 / 0.85);
    else if (e.key === "0") to.reset();
    else return;
    e.preventDefault();
  });
}
