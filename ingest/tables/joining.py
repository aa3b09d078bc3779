"""Joins the blocks of one table: in memory, or for a large file column by column in temporary files."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from ingest.model import IntArray
from ingest.spool.columns import ColumnFile
from ingest.tables.table import Block, Column


class Joiner(Protocol):
    """Takes blocks in the order of the rows and gives one."""

    @property
    def filled(self) -> bool:
        """Whether a block was added."""

    def add(self, block: Block) -> None:
        """Add the block that follows."""

    def joined(self) -> Block:
        """Return all rows as one block."""


def joiner(folder: Path | None) -> Joiner:
    """Return what joins blocks in memory, or in temporary files of `folder`."""
    return _InMemory() if folder is None else _InFiles(folder)


class _InMemory:
    def __init__(self) -> None:
        self._blocks: list[Block] = []

    @property
    def filled(self) -> bool:
        return bool(self._blocks)

    def add(self, block: Block) -> None:
        self._blocks.append(block)

    def joined(self) -> Block:
        blocks = self._blocks
        if len(blocks) == 1:
            return blocks[0]
        numbers = {at: np.concatenate([block.numbers[at] for block in blocks]) for at in blocks[0].numbers}
        lines, ordinals = None, None
        if not _follow_on(blocks):
            lines = np.concatenate([_lines(block) for block in blocks])
            ordinals = np.concatenate([block.ordinal() for block in blocks])
        return _whole(blocks, numbers, lines, ordinals)


class _InFiles:
    """Writes the columns of each block, and the numbers of its lines and rows where these have holes."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._blocks: list[Block] = []
        self._columns: dict[int, ColumnFile[Any]] = {}
        self._numbers: tuple[ColumnFile[np.int64], ColumnFile[np.int64]] | None = None

    @property
    def filled(self) -> bool:
        return bool(self._blocks)

    def add(self, block: Block) -> None:
        for position, values in block.numbers.items():
            if position not in self._columns:
                self._columns[position] = ColumnFile(self._folder, values.dtype)
            self._columns[position].append(values)
        before = len(self._blocks)
        self._blocks.append(dataclasses.replace(block, numbers={}, lines=None, ordinals=None))
        if self._numbers is None and (block.lines is not None or not _follow_on(self._blocks[-2:])):
            whole = np.dtype(np.int64)
            self._numbers = (ColumnFile(self._folder, whole), ColumnFile(self._folder, whole))
            for earlier in self._blocks[:before]:
                self._number(earlier)
        self._number(block)

    def _number(self, block: Block) -> None:
        if self._numbers is not None:
            self._numbers[0].append(_lines(block))
            self._numbers[1].append(block.ordinal())

    def joined(self) -> Block:
        numbers: dict[int, Column] = {position: column.finish() for position, column in self._columns.items()}
        lines, ordinals = (None, None) if self._numbers is None else (file.finish() for file in self._numbers)
        return _whole(self._blocks, numbers, lines, ordinals)


def _whole(
    blocks: Sequence[Block],
    numbers: Mapping[int, Column],
    lines: IntArray | None,
    ordinals: IntArray | None,
) -> Block:
    first = blocks[0]
    clocks = {position: [cell for block in blocks for cell in block.clocks[position]] for position in first.clocks}
    return Block(
        numbers,
        clocks,
        sum(block.n_rows for block in blocks),
        first.first_line,
        lines,
        first.first_ordinal,
        ordinals,
        sum(block.rows_rejected for block in blocks),
    )


def _follow_on(blocks: Sequence[Block]) -> bool:
    """Whether row follows row and line follows line through all blocks."""
    line, ordinal = blocks[0].first_line, blocks[0].first_ordinal
    for block in blocks:
        numbered = block.lines is not None or block.ordinals is not None
        if numbered or (block.first_line, block.first_ordinal) != (line, ordinal):
            return False
        line, ordinal = line + block.n_rows, ordinal + block.n_rows
    return True


def _lines(block: Block) -> IntArray:
    if block.lines is None:
        return np.arange(block.first_line, block.first_line + block.n_rows, dtype=np.int64)
    return block.lines
