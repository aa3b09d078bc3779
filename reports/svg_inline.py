"""An SVG file made ready to stand inside a page: no prolog, no addresses, ids that cannot clash."""

from __future__ import annotations

import re
from html import escape

_PROLOG = re.compile(r"^.*?(?=<svg\b)", re.DOTALL)
_METADATA = re.compile(r"<metadata>.*?</metadata>|<!--.*?-->", re.DOTALL)
_OPENING = re.compile(r"<svg\b[^>]*>")
_VIEW_BOX = re.compile(r'viewBox="([^"]*)"')


def inline_svg(svg: bytes, name: str, title: str, alternative: str) -> str:
    """Return the drawing as an `<svg>` element for HTML, described to those who cannot see it.

    `name` goes in front of every id, so that two figures on one page do not take each other's shapes.
    """
    text = _METADATA.sub("", _PROLOG.sub("", svg.decode("utf-8")))
    text = re.sub(r'\bid="', f'id="{name}-', text)
    text = re.sub(r'href="#', f'href="#{name}-', text)
    text = text.replace("url(#", f"url(#{name}-")
    opening = _OPENING.search(text)
    box = _VIEW_BOX.search(text)
    if opening is None or box is None:
        raise ValueError(f"figure {name!r} is no SVG with a viewBox")
    width_pt = float(box.group(1).split()[2])
    head = (
        f'<svg viewBox="{box.group(1)}" style="width:{width_pt / 72:.3f}in" role="img" '
        f'aria-labelledby="{name}-title {name}-desc">'
        f'<title id="{name}-title">{escape(title)}</title><desc id="{name}-desc">{escape(alternative)}</desc>'
    )
    return head + text[opening.end() :].strip()
