"""What a page may do in a browser: show what is in it, and run its own script; it asks nothing of any network.

So that a text of a log or a note, which a page shows, could do nothing even where it were taken for more than text.
"""

from __future__ import annotations

import hashlib
from base64 import b64encode

_NOTHING = "'none'"


def content_policy(*scripts: str) -> str:
    """Return the Content-Security-Policy of a page that has these scripts, each the whole text of its element."""
    hashes = [f"'sha256-{b64encode(hashlib.sha256(script.encode()).digest()).decode()}'" for script in scripts]
    return (
        "default-src 'none'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; "
        f"script-src {' '.join(hashes or [_NOTHING])}"
    )
