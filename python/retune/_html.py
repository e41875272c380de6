"""Tables, matrices and pages in a notebook."""

from __future__ import annotations

import html
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

_TABLE = "border-collapse:collapse;font-variant-numeric:tabular-nums"
_CELL = "padding:2px 8px;border-bottom:1px solid rgba(128,128,128,.3)"


def number(value: float | None) -> str:
    """Four digits that count."""
    if value is None or not np.isfinite(value):
        return "–"
    size = abs(value)
    if size == 0.0:
        return "0"
    if not 1e-3 <= size < 1e6:
        return f"{value:.3e}"
    return f"{value:.{max(0, 3 - int(np.floor(np.log10(size))))}f}"


def _is_number(value: object) -> bool:
    text = str(value).strip().removesuffix("%").strip().replace("−", "-")
    if text in ("", "–"):
        return True
    try:
        float(text)
    except ValueError:
        return False
    return True


def table(caption: str, heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table. Every text is escaped: names in files may be hostile. Columns of numbers are aligned at their ends, and one without content is left out.

    >>> table("", ["mode", "Hz", "name"], [[1, "2.5", "1st Bending"], [2, "–", ""]]).count("text-align:left")
    3
    """
    columns = [j for j in range(len(heads)) if not rows or any(str(row[j]) != "" for row in rows)]
    ends = {j for j in columns if rows and all(_is_number(row[j]) for row in rows)}

    def line(tag: str, values: Sequence[object]) -> str:
        align = {j: "right" if j in ends else "left" for j in columns}
        cells = (f'<{tag} style="{_CELL};text-align:{align[j]}">{html.escape(str(values[j]))}</{tag}>' for j in columns)
        return f"<tr>{''.join(cells)}</tr>"

    head = line("th", heads)
    body = "".join(line("td", row) for row in rows)
    title = f'<caption style="text-align:left;font-weight:600">{html.escape(caption)}</caption>' if caption else ""
    return f'<table style="{_TABLE}">{title}<thead>{head}</thead><tbody>{body}</tbody></table>'


def heat(values: npt.ArrayLike, rows: Sequence[str], columns: Sequence[str], caption: str) -> str:
    """A matrix of numbers from 0 to 1 as a picture: SVG, one square an entry, the number in it."""
    a = np.asarray(values, dtype=np.float64)
    size, left, top = 34, 72, 26
    width, height = left + size * len(columns), top + size * len(rows)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="11" '
        f'role="img" aria-label="{html.escape(caption, quote=True)}">'
    ]
    for j, name in enumerate(columns):
        parts.append(f'<text x="{left + size * j + size / 2}" y="{top - 8}" text-anchor="middle" fill="currentColor">{html.escape(name)}</text>')
    for i, name in enumerate(rows):
        y = top + size * i
        parts.append(f'<text x="{left - 6}" y="{y + size / 2 + 4}" text-anchor="end" fill="currentColor">{html.escape(name)}</text>')
        for j in range(len(columns)):
            v = float(a[i, j])
            shade = round(255 * (1.0 - min(max(v, 0.0), 1.0))) if np.isfinite(v) else 230
            ink = "#fff" if shade < 128 else "#000"
            x = left + size * j
            parts.append(f'<rect x="{x}" y="{y}" width="{size}" height="{size}" fill="rgb({shade},{shade},255)" stroke="#888" stroke-width=".3"/>')
            parts.append(f'<text x="{x + size / 2}" y="{y + size / 2 + 4}" text-anchor="middle" fill="{ink}">{v:.2f}</text>')
    parts.append("</svg>")
    return f'<div style="font-weight:600">{html.escape(caption)}</div>' + "".join(parts)


def _round(low: float, high: float) -> list[float]:
    """Round numbers on an axis, about five of them.

    >>> _round(5.0, 400.0)
    [100.0, 200.0, 300.0, 400.0]
    """
    raw = (high - low) / 5
    size = 10.0 ** np.floor(np.log10(raw))
    step = next(float(size * k) for k in (1, 2, 5, 10) if size * k >= raw)
    return [k * step for k in range(int(np.ceil(low / step - 1e-9)), int(np.floor(high / step + 1e-9)) + 1)]


def curves(x: npt.ArrayLike, columns: Sequence[npt.ArrayLike], names: Sequence[str], caption: str, most: int = 12) -> str:
    """Curves over frequency, their sizes on a logarithmic axis, as a picture: SVG, at most so many of them.

    >>> "<path" in curves([1.0, 2.0, 3.0], [[1.0, 10.0, 2.0]], ["a"], "an example")
    True
    """
    f = np.asarray(x, dtype=np.float64)
    shown = [np.asarray(c, dtype=np.float64) for c in columns[:most]]
    known = np.concatenate([c[np.isfinite(c) & (c > 0)] for c in shown]) if shown else np.zeros(0)
    title = f'<div style="font-weight:600">{html.escape(caption)}</div>'
    if known.size == 0 or f.size < 2:
        return title
    low, high = float(np.log10(known.min())), float(np.log10(known.max()))
    # What is far below the rest is a zero between two peaks.
    low, high = np.floor(max(low, high - 8.0)), np.ceil(high) + (1.0 if np.ceil(high) == low else 0.0)
    width, height, left, top, bottom = 640.0, 244.0, 54.0, 8.0, 34.0
    across, up = width - left - 20.0, height - top - bottom
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:g} {height:g}" width="{width:g}" font-family="sans-serif" font-size="11" '
        f'role="img" aria-label="{html.escape(caption, quote=True)}">'
    ]
    for decade in range(int(low), int(high) + 1):
        y = top + up * (high - decade) / (high - low)
        parts.append(f'<path d="M{left:g} {y:.1f}H{left + across:g}" stroke="#888" stroke-width=".3"/>')
        parts.append(f'<text x="{left - 6:g}" y="{y + 4:.1f}" text-anchor="end" fill="currentColor">1e{decade}</text>')
    for at in _round(float(f[0]), float(f[-1])):
        x_at = left + across * (at - f[0]) / (f[-1] - f[0])
        parts.append(f'<path d="M{x_at:.1f} {top:g}V{top + up:g}" stroke="#888" stroke-width=".2"/>')
        parts.append(f'<text x="{x_at:.1f}" y="{height - 14:g}" text-anchor="middle" fill="currentColor">{at:g}</text>')
    parts.append(f'<text x="{left + across / 2:g}" y="{height - 1:g}" text-anchor="middle" fill="currentColor">Hz</text>')
    for k, (column, name) in enumerate(zip(shown, names)):
        # At most a thousand points: of each run of lines the largest, so that no peak is lost.
        step = max(1, -(-f.size // 1000))
        path, pen_is_down = [], False
        for i in range(0, f.size, step):
            run = column[i : i + step]
            if not np.any(np.isfinite(run)):
                pen_is_down = False
                continue
            v = float(np.nanmax(run))
            y = top + up * (high - np.clip(np.log10(v) if v > 0 else low, low, high)) / (high - low)
            j = i + int(np.nanargmax(run))
            px = left + across * (f[j] - f[0]) / (f[-1] - f[0])
            path.append(f"{'L' if pen_is_down else 'M'}{px:.1f} {y:.1f}")
            pen_is_down = True
        hue = 137.5 * k % 360
        parts.append(
            f'<path d="{"".join(path)}" fill="none" stroke="hsl({hue:.0f},65%,45%)"><title>{html.escape(name)}</title></path>'
        )
    parts.append("</svg>")
    if len(columns) > most:
        parts.append(f"<div>the first {most} of {len(columns)}</div>")
    return title + "".join(parts)


def framed(page: str, height: int) -> str:
    """A page in a cell: its scripts run in a frame without access to the notebook."""
    return (
        f'<iframe srcdoc="{html.escape(page, quote=True)}" sandbox="allow-scripts" '
        f'style="width:100%;height:{height}px;border:0" loading="lazy"></iframe>'
    )
