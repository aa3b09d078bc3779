"""What a changed labbook.toml may do to a book that has conditions, and what of it the journal keeps."""

from __future__ import annotations

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.errors import InputRefused
from data_schema.queries.facts import find_uid
from data_schema.queries.study import config_in_force
from labbook.actions.report_command import state_report
from labbook.book.naming import ensure_condition, study_of
from labbook.book.opening import propose
from labbook.config.parsing import parse_configuration
from tests.helpers.books import ADA, SmallBook, small_book, small_toml
from tests.helpers.statements import said_alike
from tests.helpers.wording import says

EXTRA = '[factors.surface]\nkind = "label"\nlevels = ["dry", "wet"]\n\n[protocol]'
"""A further factor, before the protocol."""


@pytest.fixture
def made(tmp_path: Path) -> SmallBook:
    return small_book(tmp_path)


def refusal(book: SmallBook) -> list[str]:
    """The sentences with which any command is refused; nothing is said in the journal."""
    with book.open() as standing:
        before = said_alike(standing)
        with pytest.raises(InputRefused) as caught, standing.session(ADA):
            pytest.fail("a session opened on a contradiction")
        with pytest.raises(InputRefused), standing.session(ADA, correcting=True):
            pytest.fail("no correction can settle it")
        assert said_alike(standing) == before
    return str(caught.value).splitlines()


FOOT = re.compile(r"\[factors\.foot\].*?(?=\n\[)", re.DOTALL)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("", "", ("put [factors.foot] back",)),  # its table is taken out
        ("[protocol]", EXTRA, ("take [factors.surface] out",)),
        ("levels = [0, 100]", "levels = [0, 110]", ("b_ad_gain=100",)),
        ("control = 0\n", "control = 100\n", ("b_ad_gain", "100", "conditions under control", "0")),
        ("control = 0\n", "", ("b_ad_gain", "nothing", "conditions under control", "0")),
    ],
)
def test_factors_levels_and_controls_that_conditions_have_cannot_be_changed(
    made: SmallBook, old: str, new: str, said: tuple[str, ...]
) -> None:
    made.rewrite(old or FOOT.findall(made.toml.read_text())[0], new)
    (sentence,) = refusal(made)
    says(sentence, *said)


def test_a_factor_mistyped_at_first_is_as_if_it_never_was(tmp_path: Path) -> None:
    made = small_book(tmp_path, runs=False, ingested=False)
    plain = made.toml.read_text()
    made.rewrite("[protocol]", EXTRA)
    with made.open() as standing, standing.session(ADA):
        pass
    made.toml.write_text(plain)
    with made.open() as standing:
        with standing.session(ADA) as session:
            assert find_uid(session.connection, "factor", name="surface") is not None
            levels = {"foot": "small", "k_gain": "400", "b_ad_gain": "0"}
            ensure_condition(session, standing.configuration, study_of(session.connection).uid, levels)
        content = state_report(standing, None, ADA, lambda _step: None).results
        assert [factor.name for factor in content.factors] == list(levels)


@pytest.mark.parametrize(
    ("url", "kept"),
    [
        ("postgresql+psycopg://ada:s3cr3t:x/y@host/labbook", "postgresql+psycopg://ada:***@host/labbook"),
        ("postgresql+psycopg://host/labbook?user=ada&password=s3cr3t", None),
        ("postgresql+psycopg://ada@host:5432/labbook", "postgresql+psycopg://ada@host:5432/labbook"),
    ],
)
def test_the_password_of_the_database_stays_out_of_the_journal(made: SmallBook, url: str, kept: str | None) -> None:
    text = small_toml(database_url=url)
    configuration = parse_configuration(text, "labbook.toml")
    with made.open() as standing:
        with replace(standing, configuration=configuration).session(ADA) as session:
            propose(session, configuration)
        said = said_alike(standing)[-1]
        assert said.entity_kind == "config"
        assert "s3cr3t" not in str(said.new)
        with standing.reading() as connection:
            in_force = config_in_force(connection)
        assert in_force is not None
        assert in_force.sha256 == hashlib.sha256(text.encode()).hexdigest()
        masked = kept or url.replace("s3cr3t", "***")
        assert parse_configuration(in_force.text, "the book's configuration").database.url == masked


def test_a_password_that_cannot_be_found_in_the_text_is_refused(made: SmallBook) -> None:
    text = small_toml(database_url=r"postgresql+psycopg://ada:s3cr\u0065t@host/labbook")
    configuration = parse_configuration(text, "labbook.toml")
    with (
        made.open() as standing,
        pytest.raises(InputRefused, match="without them"),
        replace(standing, configuration=configuration).session(ADA),
    ):
        pytest.fail("a session opened")
