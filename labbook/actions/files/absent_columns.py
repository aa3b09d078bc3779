"""Columns that the command line names and a file lacks: what was said of them would otherwise have no effect."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from data_schema.vocabulary import Severity
from ingest.declared import ABSENT
from ingest.model import ReadFile


def refused_without_columns(read: ReadFile, options: Mapping[str, Any]) -> ReadFile:
    """Refuse a file without a column that `options` name; one that only a profile names stays a note."""
    named = options.get("columns", {})
    findings = [
        replace(finding, severity=Severity.FILE) if finding.rule == ABSENT and finding.column in named else finding
        for finding in read.findings
    ]
    return replace(read, findings=tuple(sorted(findings, key=lambda finding: finding.severity is not Severity.FILE)))
