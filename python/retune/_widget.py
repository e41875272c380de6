"""The page of a result as a widget of a notebook. Needs anywidget."""

from __future__ import annotations

from typing import Any

_SCRIPT = """
export default {
  render({ model, el }) {
    const frame = document.createElement("iframe");
    frame.setAttribute("sandbox", "allow-scripts");
    frame.style.cssText = "width:100%;border:0";
    const show = () => { frame.srcdoc = model.get("page"); };
    const fit = () => { frame.style.height = `${model.get("height")}px`; };
    model.on("change:page", show);
    model.on("change:height", fit);
    fit();
    show();
    el.replaceChildren(frame);
    return () => { model.off("change:page", show); model.off("change:height", fit); };
  },
};
"""


def page_widget(page: str, height: int) -> Any:
    """An anywidget around a page; its traits ``page`` and ``height`` may be set later, and every view of it follows.

    Scripts of the page run in a frame without access to the notebook.
    """
    import anywidget
    import traitlets

    base: Any = anywidget.AnyWidget

    class Page(base):  # type: ignore[misc]
        _esm = _SCRIPT
        page = traitlets.Unicode().tag(sync=True)
        height = traitlets.Int().tag(sync=True)

    return Page(page=page, height=height)
