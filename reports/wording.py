"""Small words: counts with their noun, lists, the capital that starts a sentence."""

from __future__ import annotations

from reports.display import NO_BREAK


def count_text(count: int, noun: str, plural: str = "") -> str:
    """Write a count with its noun: "1 run", "12 runs"."""
    return f"{count}{NO_BREAK}{noun if count == 1 else plural or noun + 's'}"


def sentence_start(text: str) -> str:
    """Write the first letter as a capital and leave the others as they are, and a symbol ("d = 186 kg/s") too."""
    symbol = text[1:].lstrip(f" {NO_BREAK}").startswith("=")
    return text if symbol else text[:1].upper() + text[1:]


def in_sentence(title: str) -> str:
    """Return a title as it stands within a sentence: "Foot size" as "foot size", but "PWM duty" and "K" as they are."""
    first = title.split(" ", 1)[0]
    return title if len(first) < 2 or first[1:] != first[1:].lower() else f"{title[:1].lower()}{title[1:]}"


def list_text(words: tuple[str, ...] | list[str]) -> str:
    """Join words as a sentence does: "a, b and c"."""
    if len(words) < 2:
        return "".join(words)
    return f"{', '.join(words[:-1])} and {words[-1]}"
