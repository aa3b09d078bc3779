"""Write what docs/schema.md says of the views from the views themselves."""

from __future__ import annotations

from pathlib import Path

from data_schema.views import VIEWS

DOCUMENT = Path(__file__).parents[1] / "docs" / "schema.md"
_BEGIN, _END = "<!-- the views, by scripts/schema_document.py -->\n", "<!-- the end of the views -->\n"


def described(text: str) -> str:
    """Return the document with the views as they are now."""
    before, _begin, rest = text.partition(_BEGIN)
    _old, _end, after = rest.partition(_END)
    views = [
        "\n".join(
            [
                f"### {name}\n\nOne row is {view.row}.\n\n| column | meaning |\n|---|---|",
                *(f"| `{column}` | {meaning.text} |" for column, meaning in view.columns.items()),
                "",
            ]
        )
        for name, view in VIEWS.items()
    ]
    return "".join([before, _BEGIN, "\n", "\n".join(views), "\n", _END, after])


if __name__ == "__main__":
    DOCUMENT.write_text(described(DOCUMENT.read_text(encoding="utf-8")), encoding="utf-8")
