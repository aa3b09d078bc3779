"""Runs that jumped on a force plate: from the plate's export to the report."""

from __future__ import annotations

import csv
import io

import pytest

from data_schema.outcomes import Outcome
from data_schema.vocabulary import RunKind, Undefined
from labbook.actions.files.ingesting import IngestRequest, ingest_file
from labbook.actions.report_command import Analysis, state_report
from labbook.demo.writers import bertec_text
from reports.figures.registry import figures_of
from reports.tables.formats import csv_bytes
from reports.tables.registry import TABLES, tables_of
from stats.compare.summary import describe
from stats.force_plate import Contact, find_contacts, jump_heights
from tests.helpers.books import ADA, SmallBook, small_book, small_runs
from tests.helpers.pages import quick_page
from tests.helpers.stated_campaign import plate_record
from tests.helpers.wording import says
from tests.labbook.conftest import Reports

HOPS = 6
OF_PLATE = [Outcome.PEAK_FORCE, Outcome.CONTACT_TIME, Outcome.IMPULSE_HEIGHT]
NAMES = [run.name for run in small_runs() if run.kind is RunKind.JUMPS]


def contacts_of(name: str) -> tuple[Contact, ...]:
    """The contacts of a run's record, before it was written with four digits."""
    record = plate_record(int(name[1:]), HOPS)
    found = find_contacts(record.time_ms / 1e3, record.force_n[:, 2])
    assert isinstance(found, tuple)
    return found


@pytest.fixture(scope="module")
def on_plate(tmp_path_factory: pytest.TempPathFactory) -> tuple[SmallBook, Analysis]:
    """A book whose runs were on a plate, but for the last one, which has two records; and its report."""
    folder = tmp_path_factory.mktemp("plate")
    made = small_book(folder, ingested=True)

    def ingest(run: str, seed: int) -> None:
        path = folder / f"{run}_plate_{seed}.txt"
        path.write_bytes(bertec_text(plate_record(seed, HOPS)))
        ingest_file(book, path, IngestRequest(person=ADA, run=run))

    with made.open() as book:
        for name in NAMES:
            ingest(name, int(name[1:]))
        ingest(NAMES[-1], 99)
        return made, state_report(book, None, ADA, lambda _step: None)


def expected(outcome: Outcome, name: str) -> float:
    """A run's value, from its record."""
    values = {
        Outcome.PEAK_FORCE: [contact.peak_n for contact in contacts_of(name)],
        Outcome.CONTACT_TIME: [contact.duration_s for contact in contacts_of(name)],
    }
    jumps = jump_heights(contacts_of(name))
    assert not isinstance(jumps, Undefined)
    values[Outcome.IMPULSE_HEIGHT] = list(jumps.heights_m)
    mean = describe(values[outcome]).mean
    assert isinstance(mean, float)
    return mean


@pytest.mark.parametrize("outcome", OF_PLATE)
def test_a_run_s_value_is_the_mean_over_its_contacts(outcome: Outcome, on_plate: tuple[SmallBook, Analysis]) -> None:
    values = {run: value for c in on_plate[1].results.conditions for run, value in c.summaries[outcome].runs}
    assert sorted(values) == sorted(NAMES[:-1])
    for name, value in values.items():
        assert value == pytest.approx(expected(outcome, name), rel=1e-5)


@pytest.mark.parametrize("outcome", OF_PLATE)
def test_the_report_compares_it_as_any_outcome(outcome: Outcome, on_plate: tuple[SmallBook, Analysis]) -> None:
    content = on_plate[1].results
    compared = [item for item in content.comparisons if item.quantity is outcome]
    assert compared
    assert all(item.decision.savings is None for item in compared)
    assert {f"{outcome.key}_by_condition", f"comparisons_{outcome.key}", f"tests_{outcome.key}"} <= {
        kind.name for kind in tables_of(content)
    }
    assert f"{outcome.key}_by_level" in {kind.name for kind in figures_of(content)}
    rows = list(csv.DictReader(io.StringIO(csv_bytes(TABLES["each_run"].make(content)).decode())))
    assert sum(bool(row[f"{outcome.key}_{outcome.unit}"]) for row in rows) == len(NAMES) - 1
    page = quick_page(content)
    assert f"<h3>{outcome.heading}</h3>" in page
    says(page, "2 force")


def test_a_book_without_a_plate_says_nothing_of_it(reports: Reports) -> None:
    content = reports().results
    assert not set(OF_PLATE) & set(content.outcomes)
    assert "Peak force" not in quick_page(content)
