"""What tests look at in the reading of a file: findings by rule, channels by name."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from data_schema.vocabulary import FileRole
from ingest.model import ChannelData, Declarations, Finding, ReadFile, SignalPart
from ingest.read import read_file


def read(data: bytes, declared: Declarations | None = None, **settings: Any) -> ReadFile:
    """Read bytes as declared, or with these settings."""
    return read_file(data, declared or Declarations(**settings))


def rules(result: ReadFile) -> set[str]:
    return {finding.rule for finding in result.findings}


def counts(result: ReadFile) -> Counter[str]:
    """How often each rule was found."""
    return Counter({finding.rule: finding.count for finding in result.findings})


def finding(result: ReadFile, rule: str) -> Finding:
    """The one finding of this rule."""
    (found,) = [finding for finding in result.findings if finding.rule == rule]
    return found


def refusal(result: ReadFile) -> Finding:
    """The one finding that refuses the file, which comes first."""
    (found,) = [finding for finding in result.findings if finding.severity == "file"]
    assert found is result.findings[0]
    return found


def only_part(result: ReadFile) -> SignalPart:
    """The one part of a file that is not refused."""
    assert not result.refused, result.findings
    (part,) = result.parts
    return part


def values(found: ReadFile | SignalPart) -> dict[str, np.ndarray]:
    """The channels of a part, or of the first part of a file, by name."""
    part = found if isinstance(found, SignalPart) else found.parts[0]
    return {channel.name: channel.values for channel in part.channels}


def channel(result: ReadFile, name: str) -> ChannelData:
    """The channel of this name in the only part."""
    (part,) = result.parts
    (found,) = [channel for channel in part.channels if channel.name == name]
    return found


def check_invariants(result: ReadFile) -> None:
    assert result.rows_read == result.rows_kept + result.rows_rejected
    assert min(result.rows_kept, result.rows_rejected) >= 0
    if not result.refused:
        assert result.rows_kept > 0
        assert result.parts or result.charges or result.role == FileRole.SHEET
    names = [part.part for part in result.parts]
    assert len(names) == len(set(names))
    for part in result.parts:
        assert (np.diff(part.time_s) > 0).all()
        assert len({channel.name for channel in part.channels}) == len(part.channels)
        for channel in part.channels:
            assert channel.values.shape == part.time_s.shape
            assert channel.values.dtype == np.float64
            assert not np.isinf(channel.values).any()
        for gap in part.gaps:
            assert gap.length_s > 0
            assert gap.samples_expected >= gap.samples_missing >= 1
    assert all(charge.charge_mah >= 0 for charge in result.charges)
    for finding in result.findings:
        assert finding.count >= 1 + len(finding.more_lines)
        assert finding.message.strip()
        assert "\n" not in finding.message
        assert len(finding.more_lines) <= 20
