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


def table(caption: str, heads: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    """A table. Every text is escaped: names in files may be hostile."""

    def cell(tag: str, value: object) -> str:
        is_word = isinstance(value, str) and not value[:1].isdigit() and value[:1] not in "+-–"
        return f'<{tag} style="{_CELL};text-align:{"left" if is_word else "right"}">{html.escape(str(value))}</{tag}>'

    head = "".join(cell("th", h) for h in heads)
    body = "".join(f"<tr>{''.join(cell('td', v) for v in row)}</tr>" for row in rows)
    title = f'<caption style="text-align:left;font-weight:600">{html.escape(caption)}</caption>' if caption else ""
    return f'<table style="{_TABLE}">{title}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>'


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


def framed(page: str, height: int) -> str:
    """A page in a cell: its scripts run in a frame without access to the notebook."""
    return (
        f'<iframe srcdoc="{html.escape(page, quote=True)}" sandbox="allow-scripts" '
        f'style="width:100%;height:{height}px;border:0" loading="lazy"></iframe>'
    )
