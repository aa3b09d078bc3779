"""`labbook analysis`: what was decided before anything was measured."""

from labbook.cli.common import BookOption, JsonOption, emit


def analysis(book: BookOption = None, as_json: JsonOption = False) -> None:
    """Show what was decided about the analysis, when and by whom, and what departs from it.

    [analysis] of labbook.toml is in the journal before the first file is ingested or the first charge stated. What it
    said then rules; the report calls exploratory what departs from it. A later change is never refused, it is listed.
    So are corrections of runs and charges made since, runs moved to another condition, logs taken off runs, charges
    and logs that came to runs which had theirs, and other rules in [protocol] which jumps count; a report, and
    `labbook stats`, list the runs and conditions that their selection leaves out. The last line says what is not
    watched.

    Example: labbook analysis
    """
    from labbook.analysis.preregistration.planned import planned_analysis
    from labbook.book.opening import opened
    from labbook.presenting.report.preregistration import NOT_WATCHED, planned_sentences

    with opened(book) as opened_book, opened_book.reading() as connection:
        found = planned_analysis(connection, opened_book.configuration)
    watched = found.stated and found.first_measured_utc is not None
    emit(found, (*planned_sentences(found), *((NOT_WATCHED,) if watched else ())), as_json)
