"""What a report cites: its paragraph on methods and its BibTeX name the same software, versions and sources."""

import dataclasses
import re

from reports.references import _SOURCES, _entries, references_bib, software_sentence, sources_named
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

ENTRY = re.compile(r"@(\w+)\{(\w+),\n((?:  \w+ = \{.*\},\n)+)\}")


def with_methods(content, *texts):
    return dataclasses.replace(content, methods=texts, tests_beside="", software=(("numpy", "2.1"), ("scipy", "1.17")))


def test_software_and_sources_are_those_that_the_methods_name(content):
    given = with_methods(content, "Savings have Fieller's interval.", "P is adjusted by Holm's method (thesis 5.2).")
    sentence = software_sentence(given)
    says(sentence, "0.1.0", "2.1", "1.17", "2021", "1954", "1979")
    bib = references_bib(given).decode()
    assert [key for _, key, _ in ENTRY.findall(bib)] == [
        "labbook", "numpy", "scipy", "roberts2021", "fieller1954", "holm1979",
    ]  # fmt: skip
    assert "version = {0.1.0}" in bib
    assert "version 2.1}" in bib
    assert "VERSION" not in bib
    assert "{YEAR}" not in bib


def test_what_is_not_named_is_not_cited(content):
    assert sources_named(with_methods(content, "Nothing is compared.")) == ()
    assert software_sentence(with_methods(content, "Nothing is compared.")).endswith("scipy 1.17.")


def test_every_source_has_an_entry_that_bibtex_can_read():
    entries = _entries()
    assert set(_SOURCES.values()) < set(entries)
    for key, entry in entries.items():
        kind, found, fields = ENTRY.fullmatch(entry).groups()
        assert (found, kind.islower()) == (key, True)
        assert {"author", "title", "year"} <= set(re.findall(r"  (\w+) =", fields))
        assert entry.count("{") == entry.count("}")


def test_the_page_says_it_and_the_file_lies_beside(content, written):
    assert software_sentence(content) in quick_page(content)
    assert (written.page.parent / "references.bib").read_bytes() == references_bib(content)
