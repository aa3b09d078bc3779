"""LabVIEW measurement files, synthetic, as its VI `Write To Measurement File` lays them out."""

from __future__ import annotations


def labview(n: int = 50, *, tab: str = "\t", decimal: str = ".", columns: str = "One", comment: bool = True) -> bytes:
    """A body height in mm and a battery in V at 250 Hz, one segment of `n` rows."""
    head = [
        "LabVIEW Measurement",
        "Writer_Version|2",
        f"Separator|{'Tab' if tab == chr(9) else 'Comma'}",
        f"Decimal_Separator|{decimal}",
        "Multi_Headings|No",
        f"X_Columns|{columns}",
        "Date|2023/05/09",
        "Time|14:02:11.5",
        "***End_of_Header***",
        "",
        "Channels|2",
        f"Samples|{n}|{n}",
        "Date|2023/05/09|2023/05/09",
        "Time|14:02:11.5|14:02:11.5",
        "Y_Unit_Label|mm|V",
        "X_Dimension|Time|Time",
        "X0|0.0E+0|0.0E+0",
        "Delta_X|0.004|0.004",
        "***End_of_Header***",
        "X_Value|body height|battery voltage|Comment",
    ]
    blank = "|" if comment else ""
    rows = [f"{0.004 * k:.6f}|{300.5 + k % 7:.6f}|15.400000{blank}".replace(".", decimal) for k in range(n)]
    return "\r\n".join([*head, *rows, ""]).replace("|", tab).encode()
