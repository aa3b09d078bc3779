"""What a report cites: its paragraph on methods and its BibTeX name the same software, versions and sources."""

import dataclasses
import re

from reports.page.sections import _entries, references_bib, software_sentence
from reports.results import Source
from tests.helpers.pages import quick_page
from tests.helpers.wording import says

ENTRY = re.compile(r"@(\w+)\{(\w+),\n((?:  \w+ = \{.*\},\n)+)\}")


def citing(content, *sources):
    return dataclasses.replace(content, sources=sources, software=(("numpy", "2.1"), ("scipy", "1.17")))


def test_software_and_sources_are_those_that_were_used(content):
    given = citing(content, Source.THESIS, Source.FIELLER, Source.HOLM)
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


def test_what_is_not_used_is_not_cited_whatever_the_methods_say(content):
    given = dataclasses.replace(
        citing(content), methods=("Nothing is compared after Welch, by Holm or in the thesis.",)
    )
    assert software_sentence(given).endswith("scipy 1.17.")
    assert b"holm1979" not in references_bib(given)


def test_every_source_has_an_entry_that_bibtex_can_read():
    entries = _entries()
    assert set(Source) < set(entries)
    for key, entry in entries.items():
        kind, found, fields = ENTRY.fullmatch(entry).groups()
        assert (found, kind.islower()) == (key, True)
        assert {"author", "title", "year"} <= set(re.findall(r"  (\w+) =", fields))
        assert entry.count("{") == entry.count("}")


def test_the_page_says_it_and_the_file_lies_beside(content, written):
    assert software_sentence(content) in quick_page(content)
    assert (written.parent / "references.bib").read_bytes() == references_bib(content)
