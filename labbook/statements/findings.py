"""Findings as the rows they leave."""

from __future__ import annotations

from typing import Any

from data_schema.journal import canonical
from ingest.model import Finding


def finding_values(finding: Finding) -> dict[str, Any]:
    """Return the columns of a finding's row."""
    return {
        "severity": str(finding.severity),
        "rule": finding.rule,
        "line": finding.line,
        "column_name": finding.column,
        "value": finding.value,
        "n": finding.count,
        "more_lines_json": canonical(list(finding.more_lines)),
        "message": finding.message,
    }
