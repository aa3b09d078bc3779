import pytest

from reports.page.writing import inline_svg

SVG = b"""<?xml version="1.0"?><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/x.dtd">
<svg xmlns:xlink="http://www.w3.org/1999/xlink" width="144pt" viewBox="0 0 144 72" xmlns="http://www.w3.org/2000/svg">
<metadata>http://purl.org</metadata><!-- text --><defs><path id="p1" d="M0 0"/></defs>
<use xlink:href="#p1" clip-path="url(#c1)"/></svg>
"""


def test_ids_get_a_name_in_front_and_addresses_go():
    text = inline_svg(SVG, "packs", "Packs <1>", 'dots & "lines"')
    assert 'id="packs-p1"' in text
    assert 'href="#packs-p1"' in text
    assert "url(#packs-c1)" in text
    assert "http" not in text
    assert '<title id="packs-title">Packs &lt;1&gt;</title>' in text
    assert "dots &amp; &quot;lines&quot;</desc>" in text
    assert "width:2.000in" in text


def test_what_is_no_drawing_is_refused():
    with pytest.raises(ValueError, match="no SVG"):
        inline_svg(b"<svg>", "packs", "", "")
