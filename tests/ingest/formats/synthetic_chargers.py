"""Synthetic charger logs for tests, written in code after public descriptions: no charger recorded these bytes."""

from __future__ import annotations

from labbook.demo.writers import checksum

CELLS = 4


def with_checksum(body: str) -> str:
    """A record with the exclusive or of its bytes, the last `;` included."""
    return body + str(checksum(body.encode()))


def lines(rows: list[str], end: str = "\r\n") -> bytes:
    """Rows as a text file."""
    return (end.join(rows) + end).encode()


def serial_rows(n: int = 300, mode: int = 1, current_a: float = 1.8, sign: int = 1, cells: int = 6) -> list[str]:
    """An older iCharger: a line every two seconds, 1 mAh each at 1.8 A; `sign` of current and counter."""
    rows = []
    for row in range(n):
        direction = 1 if mode == 1 else -1
        millivolts = [3900 + direction * row // 4] * CELLS + [0] * (cells - CELLS)
        values = [14000, sum(millivolts), sign * round(current_a * 100), *millivolts, 328, 251, sign * row]
        rows.append(with_checksum(f"$1;{mode};;" + ";".join(map(str, values)) + ";"))
    return rows


def cheali_rows(
    n: int = 600, rising: int = 1, current_a: float = 3.6, cells: int = 6, percent: bool = True
) -> list[str]:
    """A charger with cheali-charger: every half second, 0.5 mAh each at 3.6 A; `rising` -1 for a discharge."""
    rows = []
    for row in range(n):
        millivolts = [3900 + rising * row // 4] * CELLS + [0] * (cells - CELLS)
        charge = int(current_a * row * 0.5 / 3.6)
        values = [sum(millivolts), round(current_a * 1000), charge, 5616, 200, 2510, 3080, 14000, *millivolts]
        values += [5] * cells + [20, 30] + ([50, 12] if percent else [])
        rows.append(with_checksum(f"$1;1;{row // 2}.{5 * (row % 2)};" + ";".join(map(str, values)) + ";"))
    return rows


def bare_rows(n: int = 100, channel: int = 1, clock: bool = True, checksum: bool = True) -> list[str]:
    """A device on LogView's OpenFormat: millivolts and milliamperes without names or units."""
    rows = []
    for row in range(n):
        body = f"${channel};1;{row * 1000 if clock else ''};{15600 + row};{-200 - row % 7};"
        rows.append(with_checksum(body) if checksum else body + "0")
    return rows
