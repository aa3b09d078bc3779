"""`labbook stats`: values are read, one function of `stats` is called for each comparison, and what it found is shown.

Where days are known the contrast by shared days answers, as in a report; `--route` asks for a test of all values.

Values come from a table that is named, or from the book, whose groups are called as the report calls them, a gain by
its physical value.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, cast

import sqlalchemy as sa

from data_schema.errors import InputRefused, UsageError, unknown_name
from data_schema.grouping import grouped
from data_schema.outcomes import Outcome
from data_schema.rounding import error_of, interval_text, number_text, p_text, statistic_text
from data_schema.vocabulary import Rule, Undefined
from data_schema.where import DATE, ColumnKind, WhereColumn, compile_where, names_in, parse
from ingest.channels.names import parse_header
from ingest.tables.sheet import (
    Sheet,
    SheetFile,
    decimal_sign,
    is_blank,
    is_number_text,
    number_in,
    numbers_of,
    read_sheet,
)
from ingest.text import CellFault
from labbook.actions.files.named_files import own_name, read_bytes
from labbook.actions.stats.asked import Values
from labbook.analysis.comparison import pairing
from labbook.analysis.comparison.deciding import p_of
from labbook.analysis.comparison.pairing import study_factor, with_control
from labbook.analysis.observations import Observation, ObservationRequest, Observations, observations_of_book
from labbook.book.opening import opened
from labbook.config.model import Bounds
from reports.display import NO_BREAK, in_sentence, list_text
from reports.figures.estimation import Estimation, EstimationGroup
from reports.figures.kind import check_form
from reports.naming import level_name, swept_words, title_of
from reports.numbers import Number
from reports.results import Factor, Level
from stats.checks import MISSING, Missing, as_values
from stats.compare.two_sample import ROUTES, compare_two
from stats.days.decision import Bounded, Contrast, Estimate, contrast_by_day
from stats.groups.anova import one_way_anova, welch_anova
from stats.groups.multiple import HolmFamily, holm
from stats.groups.tukey import VARIANCES, compare_all_pairs
from stats.groups.variances import brown_forsythe
from stats.results import as_dict, with_unit

ALPHA = 0.05
DAYS_LEFT_OUT = "Days are left out of this test; `labbook stats compare` compares within days."
MOST_GROUPS_IN_PAIRS = 50
"""Of more groups only F is shown: their pairs are thousands."""


@dataclass(frozen=True, slots=True)
class Question:
    """The values that a test is asked about, and its level; they are `scale` times what was read."""

    observed: Observations
    missing: Missing
    alpha: float
    scale: float = 1.0

    @property
    def level(self) -> float:
        """The level of intervals, 1 - alpha."""
        return 1.0 - self.alpha

    def name(self, label: str) -> str:
        """Return a group's name."""
        return self.observed.name(label)

    @property
    def control(self) -> str:
        """The control's name."""
        return self.name(self.observed.control)


@dataclass(frozen=True, slots=True)
class Answer:
    """Sentences and notes for people, data for programs, and the function that makes the estimation plot."""

    sentences: list[str]
    data: dict[str, Any]
    drawn: Callable[[], Estimation]
    notes: Sequence[str] = ()


def answer(
    values: Values, ask: Callable[[Question], Answer], pooled: bool, step: Callable[[str], None]
) -> tuple[dict[str, Any], list[str]]:
    """Observe the values, ask, and draw what is wanted; returns data for programs, and lines for people.

    Data have the values' unit and the groups' own names, as programs ask for them; what people read has lengths below
    1 m in mm, and groups of a book named as in its report.
    """
    check_form("--plot", values.plot)
    observed = observe(values, step)
    if pooled:
        observed = observed.pooled()
    alpha = values.alpha
    if alpha is not None and not 0.0 < alpha < 1.0:
        raise UsageError(f"--alpha is {alpha!r}: give a number between 0 and 1, for example 0.05 for 5 %.")
    alpha = alpha or (ALPHA if observed.settings is None else observed.settings.alpha)
    question = Question(observed, cast(Missing, values.missing), alpha)
    observed.others()
    found = ask(question)
    if values.plot is not None:
        from reports.figures.estimation import draw_estimation
        from reports.figures.kind import write_figure
        from reports.figures.style import ONE_COLUMN_IN, TWO_COLUMNS_IN

        step("figure")
        width_in = ONE_COLUMN_IN if len(observed.labels) <= 2 else TWO_COLUMNS_IN
        write_figure(draw_estimation(found.drawn(), width_in), values.plot)
    shown = as_shown_to_people(observed.in_small_units())
    scale = 1.0 if shown.unit == observed.unit else 1000.0
    as_shown = found if shown is observed else ask(replace(question, observed=shown, scale=scale))
    known = observed.known()
    data = {
        "source": observed.source,
        "quantity": observed.quantity,
        "unit": observed.unit,
        "by": observed.by,
        "control": question.control,
        "groups": {observed.name(label): len(known.values(label)) for label in observed.labels},
        "notes": [*observed.notes, *found.notes],
        **found.data,
        "files": {} if values.plot is None else {"plot": str(values.plot)},
    }
    notes = [*shown.notes, *as_shown.notes]
    lines = [*as_shown.sentences, *([""] if notes else []), *(f"note: {note}" for note in notes)]
    return data, lines


def compare(question: Question, route: str | None) -> Answer:
    """Compare every group with the control, by shared days where these are known, else by the t-test of the route."""
    if route is not None and route not in ROUTES:
        raise unknown_name("route", route, ROUTES)
    observed = question.observed
    if route is None and days_decide(observed):
        return _by_days(question)
    control = observed.values(observed.control)
    sentences, comparisons, numbers = [], [], {}
    p_values: dict[str, float | Undefined] = {}
    for label in observed.others():
        name = question.name(label)
        found = compare_two(
            observed.values(label),
            control,
            route=route or "welch",
            alpha=question.alpha,
            missing=question.missing,
            names=(name, question.control),
        )
        sentences.append(found.sentence(unit=observed.unit))
        comparisons.append({"a": name, "b": question.control, **as_dict(found)})
        p_values[name] = found.p
        numbers[label] = difference_number(found.difference, found.difference_ci, question.level, observed.unit)
    data: dict[str, Any] = {"comparisons": comparisons}
    if len(p_values) > 1:
        family = _adjusted(question, p_values)
        sentences.append(family.sentence())
        data["holm"] = as_dict(family)
    tests = " or ".join(f"{test}'s t" for test in sorted({one["test"] for one in comparisons}))
    return Answer(sentences, data, lambda: estimation_of(observed, numbers, interval=tests), _days_left_out(observed))


def _adjusted(question: Question, p_values: Mapping[str, float | Undefined]) -> HolmFamily:
    return holm(p_values, f"against {question.control}", alpha=question.alpha)


def _by_days(question: Question, *, savings: bool = False) -> Answer:
    """Compare every group with the control by the days that both share; several are a family, adjusted by Holm.

    At the alpha decided on, a saving of the book's outcome is tested against the side that was decided on.
    """
    observed, alpha, settings = question.observed, question.alpha, question.observed.settings
    of_plan = observed.plan is not None and observed.measured.has_savings
    one_sided = of_plan and settings is not None and settings.one_sided and math.isclose(alpha, settings.alpha)
    level, unit = 1.0 - (2.0 * alpha if one_sided else alpha), "%" if savings else observed.unit
    contrasts = _contrasts(question)
    tested = {
        label: one.savings(level) if savings or of_plan else one.difference(level) for label, one in contrasts.items()
    }
    p_values = {question.name(label): p_of(one, one_sided) for label, one in tested.items()}
    adjusted = _adjusted(question, p_values).adjusted_p if len(contrasts) > 1 else None
    answers, sentences, numbers = [], [], {}
    for at, (label, one) in enumerate(tested.items()):
        contrast, p = contrasts[label], p_values[question.name(label)]
        difference = contrast.difference(level)
        of_savings = {"savings_percent": one.value, "savings_percent_ci": one.ci}
        answers.append(
            {
                **_described(question, label, contrast),
                "difference": difference.value,
                "difference_ci": difference.ci,
                **(of_savings if savings or of_plan else {}),
                "t": one.t,
                "df": one.df,
                "p": p,
                "one_sided": one_sided,
                "rejected": None if isinstance(p, Undefined) else p <= alpha,
                **({} if adjusted is None else {"adjusted_p": adjusted[at]}),
            }
        )
        shown = replace(one if savings else difference, p=p)
        numbers[label] = difference_number(shown.value, shown.ci, level, unit)
        head = f"{_head(question, label, contrast)} is"
        if savings:
            head = f"{_rule_text(contrast)}: the savings of {question.name(label)} against {question.control} are"
        sentences.append(
            _sentence(head, unit, contrast, shown, alpha, None if adjusted is None else adjusted[at], one_sided)
        )
    return Answer(
        sentences,
        {"decisions": answers},
        lambda: estimation_of(
            observed,
            numbers,
            difference="Savings against" if savings else "",
            interval=f"{'Fieller' if savings else 't'}, by shared days",
        ),
    )


def _described(question: Question, label: str, contrast: Contrast) -> dict[str, Any]:
    counts = contrast.counts
    every = counts.control + counts.treated + counts.other_control + counts.other_treated
    return {
        "a": question.name(label),
        "b": question.control,
        "alpha": question.alpha,
        "rule": str(contrast.rule),
        "days": [day for day in contrast.days if day],
        "n_a": contrast.n[1],
        "n_b": contrast.n[0],
        "other_days": every - sum(contrast.n),
    }


def _sentence(
    head: str,
    unit: str,
    contrast: Contrast,
    shown: Estimate,
    alpha: float,
    adjusted: float | Undefined | None,
    one_sided: bool,
) -> str:
    """Say by which rule a group is compared with the control: estimate, interval, t, p, n and what is left out."""
    if isinstance(shown.value, Undefined):
        return f"{head.rpartition(' ')[0]} cannot be told: {shown.value.reason}."
    value = f"{number_text(shown.value, error=error_of(shown.ci))}{with_unit(unit)}"
    if isinstance(shown.p, Undefined) or isinstance(shown.df, Undefined):
        why = shown.p.reason if isinstance(shown.p, Undefined) else "there are no degrees of freedom"
        return f"{head} {value}; no test, because {why}."
    test = f"{statistic_text('t', shown.t, (shown.df,))}, {p_text(shown.p, alpha)}{' one-sided' if one_sided else ''}"
    evidence = [interval_text(shown.ci, shown.level, unit), test]
    if adjusted is not None:
        evidence.append(f"after Holm {p_text(adjusted, alpha)}")
    return f"{head} {value} ({'; '.join([*evidence, _counted(contrast)])})."


def _head(question: Question, label: str, contrast: Contrast) -> str:
    return f"{_rule_text(contrast)}: {question.name(label)} minus {question.control}"


def _rule_text(contrast: Contrast) -> str:
    if not any(contrast.days):
        return "All values" if contrast.days else f"By shared days ({contrast.rule})"
    days = len(contrast.days)
    only = "; holds for the days measured" if contrast.rule is Rule.WITHIN else ""
    return f"By shared days ({contrast.rule}, {days} day{'' if days == 1 else 's'}{only})"


def _counted(contrast: Contrast) -> str:
    other = contrast.counts.other_control + contrast.counts.other_treated
    left_out = f", {other} on other days left out" if other else ""
    return f"n = {contrast.n[1]} against {contrast.n[0]}{left_out}"


def days_decide(observed: Observations) -> bool:
    """Tell whether every value has a day, and days are not the groups."""
    rows = observed.known().rows
    return observed.by != "day" and all(row.day for row in rows) and any(row.day != row.label for row in rows)


def _days_left_out(observed: Observations) -> list[str]:
    return [DAYS_LEFT_OUT] if days_decide(observed) else []


def _contrasts(question: Question) -> dict[str, Contrast]:
    """Return the contrast of every group with the control by label, by the days that both share where these are known.

    Without days all values are as of one day.
    """
    observed, known = question.observed, question.observed.known()
    by_days = days_decide(observed)
    if not by_days and question.missing == "refuse":
        for label in observed.labels:
            as_values(observed.name(label), observed.values(label))
    by_label = grouped(known.rows, [row.label for row in known.rows])

    def of(label: str, side: str) -> dict[str, Any]:
        rows = by_label.get(label, [])
        return {
            f"days_{side}": [row.day for row in rows] if by_days else None,
            f"shared_{side}": [row.shared for row in rows],
            f"strata_{side}": [", ".join(row.pooled) or "all" for row in rows],
        }

    def numbers(label: str) -> list[float]:
        return [float(value) for value in known.values(label)]

    control = numbers(known.control), of(known.control, "control")
    return {
        label: contrast_by_day(numbers(label), control[0], **of(label, "treated"), **control[1])
        for label in observed.others()
    }


def save(question: Question) -> Answer:
    """Return the savings of every group, by shared days where these are known."""
    observed, notes = question.observed, []
    if observed.plan is not None and not observed.measured.has_savings:
        notes.append(
            f"Savings are of what is consumed, and {observed.measured} is not: these are percent of the control's that "
            "are lost."
        )
    return replace(_by_days(question, savings=True), notes=notes)


Limits = tuple[float | None, float | None, bool]
"""Both bounds, None for one that is not there, and whether they are in percent."""


def equal(question: Question, given: Limits) -> Answer:
    """Test every group against the bounds, by shared days where these are known; in the values' unit or in percent."""
    observed = question.observed
    low, high, percent = _bounds(given, question)
    if not percent:
        low, high = (None if end is None else question.scale * end for end in (low, high))
    unit, level = "%" if percent else observed.unit, 1.0 - 2.0 * question.alpha
    sentences, answers, numbers = [], [], {}
    for label, contrast in _contrasts(question).items():
        found = contrast.equivalence(low, high, question.alpha, percent=percent)
        sentences.append(_bounded_sentence(_head(question, label, contrast), contrast, found, unit))
        answers.append(
            {
                **_described(question, label, contrast),
                "low": low,
                "high": high,
                "estimate": found.value,
                "estimate_ci": found.ci,
                **{name: getattr(found, name) for name in ("t_low", "t_high", "df", "p", "equivalent")},
            }
        )
        numbers[label] = difference_number(found.value, found.ci, level, unit)
    return Answer(
        sentences,
        {"decisions": answers},
        lambda: estimation_of(
            observed,
            numbers,
            [bound for bound in (low, high) if bound is not None],
            interval="one-sided tests by shared days" if days_decide(observed) else "one-sided tests",
        ),
    )


def _bounded_sentence(head: str, contrast: Contrast, found: Bounded, unit: str) -> str:
    ends = [f"{number_text(end)}{with_unit(unit)}" for end in (found.low, found.high) if math.isfinite(end)]
    bounds = f"{number_text(found.low)} to {ends[-1]}"
    if len(ends) == 1:
        bounds = f"{'above' if math.isfinite(found.low) else 'below'} {ends[0]}"
    within = "within " if len(ends) == 2 else ""
    if isinstance(found.p, Undefined) or isinstance(found.value, Undefined) or isinstance(found.df, Undefined):
        why = next(each for each in (found.value, found.p, found.df) if isinstance(each, Undefined))
        return f"{head}: whether it lies {within}{bounds} cannot be told: {why.reason}."
    value = f"{number_text(found.value, error=error_of(found.ci))}{with_unit(unit)}"
    verdict = f"is {'shown' if found.equivalent is True else 'not shown'} to lie {within}{bounds}"
    known = [t for t in (found.t_low, found.t_high) if isinstance(t, float)]
    tests = " and ".join(statistic_text("t", t, (found.df,)) for t in known)
    interval = interval_text(found.ci, 1.0 - 2.0 * found.alpha, unit)
    return f"{head}: {value} {verdict} ({interval}; {tests}, {p_text(found.p, found.alpha)}; {_counted(contrast)})."


def _bounds(given: Limits, question: Question) -> Limits:
    """Return the bounds given or, for the outcome that the book's [analysis] has bounds of, those.

    Raises `UsageError` for bounds of heights that no height lies beyond: they are metres, whatever is printed.
    """
    observed, (low, high, percent) = question.observed, given
    if (low, high) == (None, None):
        planned: Bounds | None = None
        if observed.settings is not None and observed.measured.has_equivalence:
            planned = observed.settings.apex_bounds
        if planned is None:
            raise UsageError(
                "there are no bounds: add --low and --high, or one of them for non-inferiority, in the values' unit "
                "or, with --percent, in percent of the control's mean."
            )
        return planned.low, planned.high, planned.percent
    heights = [abs(float(row.value)) / question.scale for row in observed.rows if row.value is not None]
    in_metres = observed.plan is not None and observed.measured.unit == "m" and not percent
    for option, bound in (("--low", low), ("--high", high)) if in_metres and heights else ():
        if bound is not None and abs(bound) > max(heights):
            raise UsageError(
                f"{option} {bound:g} is in metres, and no {observed.measured} is above {number_text(max(heights))} m: "
                f"for {bound:g} mm write {option} {bound / 1000:g}."
            )
    return given


def analyse(question: Question, variances: str) -> Answer:
    """Analyse the variance of all groups and compare all pairs, with one variance for all or each group's own."""
    if variances not in VARIANCES:
        raise unknown_name("assumption on variances", variances, VARIANCES)
    observed, level, missing = question.observed, question.level, question.missing
    groups, equal_variances = observed.groups(), variances == "equal"
    analysed = (one_way_anova if equal_variances else welch_anova)(groups, level=level, missing=missing)
    scatter = brown_forsythe(groups, missing=missing)
    sentences, notes = [analysed.sentence(observed.shown_by or observed.by), scatter.sentence()], []
    data = {"one_way" if equal_variances else "welch": as_dict(analysed), "variances": as_dict(scatter)}
    differences = {}
    if len(groups) <= MOST_GROUPS_IN_PAIRS:
        pairs = compare_all_pairs(groups, variances=variances, level=level, missing=missing)
        sentences.append(pairs.sentence(observed.unit))
        data["pairs"] = as_dict(pairs)
        of_control = {pair.b: pair for pair in pairs.pairs if pair.a == question.control}
        for label in observed.others():
            pair = of_control.get(question.name(label))
            if pair is not None and not isinstance(pair.difference, Undefined):
                ci = pair.difference_ci
                reversed_ci = ci if isinstance(ci, Undefined) else (-ci[1], -ci[0])
                differences[label] = difference_number(-pair.difference, reversed_ci, level, observed.unit)
    else:
        notes.append(f"Pairs of {len(groups)} groups are too many to compare: choose with --where.")
    method = "Tukey" if equal_variances else "Games and Howell"
    notes += _days_left_out(observed)
    return Answer(sentences, data, lambda: estimation_of(observed, differences, interval=method), notes)


def rows_where(text: str, sheet: Sheet) -> list[bool]:
    """Tell which rows of a sheet fulfil a condition, decided as that on runs, by a database.

    Raises `UsageError` for a text that cannot be read and for commas that could be decimals or thousands, `UnknownName`
    for a column that is not there.
    """
    asked = {name: _column(sheet, name) for name in sorted(names_in(parse(text)) & sheet.columns.keys())}
    types = {name: sa.Double if kind is ColumnKind.NUMBER else sa.Text for name, (kind, _cells) in asked.items()}
    rows = sa.Table("rows", sa.MetaData(), *(sa.Column(f"c{at}", kind) for at, kind in enumerate(types.values())))
    known = {name: WhereColumn(asked[name][0], column) for name, column in zip(asked, rows.c, strict=True)}
    unasked = WhereColumn(ColumnKind.TEXT, sa.null())
    fulfilled = compile_where(text, {name: known.get(name, unasked) for name in sheet.columns})
    cells = zip(*(cells for _kind, cells in asked.values()), strict=True)
    with sa.create_engine("sqlite://").begin() as connection:
        rows.create(connection)
        connection.execute(rows.insert(), [dict(zip(rows.c.keys(), row, strict=True)) for row in cells])
        in_order = sa.select(fulfilled).select_from(rows).order_by(sa.literal_column("rowid"))
        return [known_to_be is True for known_to_be in connection.scalars(in_order)]


def _column(sheet: Sheet, name: str) -> tuple[ColumnKind, Sequence[str | float | None]]:
    """Return a column as it is compared: numbers or dates where all that is filled in are, else words without order."""
    cells = sheet.columns[name]
    filled = [cell for cell in cells if not is_blank(cell)]
    if filled and all(map(is_number_text, filled)):
        sign = decimal_sign(sheet, [name])
        numbers = [number_in(cell, sign) for cell in cells]
        if not any(isinstance(number, CellFault) for number in numbers):
            return ColumnKind.NUMBER, [number for number in numbers if not isinstance(number, CellFault)]
    dates = bool(filled) and all(map(DATE.fullmatch, filled))
    return ColumnKind.DATE if dates else ColumnKind.TEXT, [cell or None for cell in cells]


QUANTITIES = {outcome.key: outcome for outcome in Outcome}


def observe(given: Values, step: Callable[[str], None]) -> Observations:
    """Read the values that are asked for; raises `UsageError` for options that do not belong to their source."""
    if given.missing not in MISSING:
        raise unknown_name("way with missing values", given.missing, MISSING)
    if given.file is not None:
        return _of_table(given, given.file)
    for option, value in (("--value", given.value), ("--decimal", given.decimal), ("--day", given.day)):
        if value is not None:
            raise UsageError(
                f"{option} is about a table: name a CSV file first, or leave it out for the book's values."
            )
    if given.missing != "refuse":
        raise UsageError(
            "--missing is about a table: of a book, runs without a value are left out as in its report, and named."
        )
    quantity = given.quantity or "joules"
    if quantity not in QUANTITIES:
        raise unknown_name("quantity", quantity, QUANTITIES)
    asked = ObservationRequest(QUANTITIES[quantity], given.by, given.control, given.where)
    with opened(given.book) as book, book.reading() as connection:
        return observations_of_book(connection, book.store, book.configuration, asked, step)


def _of_table(given: Values, file: Path) -> Observations:
    for option, value in (("--quantity", given.quantity), ("--book", given.book)):
        if value is not None:
            raise UsageError(f"{option} is about a book and {own_name(file)} is a table: leave one of the two out.")
    table = read_sheet(
        SheetFile(own_name(file), read_bytes(file), decimal=given.decimal),
        "a header such as controller,energy_J and one value a row",
    )
    table.refuse()
    if given.value is None or given.by is None:
        columns = ", ".join(repr(name) for name in table.columns)
        raise UsageError(
            f"a table needs --value and --by, the columns of values and of groups: {own_name(file)} has {columns}."
        )
    value, by = given.value, given.by
    labels, days = (
        ("",) * len(table.lines) if name is None else table.cells(name, option)
        for name, option in ((by, "--by"), (given.day, "--day"))
    )
    selected = [*range(len(table.lines))]
    if given.where is not None:
        selected = [*itertools.compress(selected, rows_where(given.where, table))]
    table.cells(value, "--value")
    sign = decimal_sign(table, [value])
    numbers = dict(zip(selected, numbers_of(table, value, "--value", sign, selected), strict=True))
    named = [cells for cells, name in ((labels, by), (days, given.day)) if name is not None]
    lacking = [place for place in selected if numbers[place] is None or not all(cells[place] for cells in named)]
    if lacking and given.missing == "refuse":
        raise InputRefused(
            f"{len(lacking)} of {len(selected)} rows of {own_name(file)} lack a value or a label, the first in line "
            f"{table.lines[lacking[0]]}: fill them in, or leave them out with --missing drop."
        )
    rows = tuple(
        Observation(numbers[place], labels[place], days[place])
        for place in selected
        if all(cells[place] for cells in named)
    )
    header = parse_header(value)
    control = with_control(given.control, by, list(dict.fromkeys(row.label for row in rows)))
    return Observations(
        source=own_name(file),
        quantity=header.suffix_base or header.base if header.unit or header.suffix_unit else value,
        unit=header.unit or header.suffix_unit or "",
        by=by,
        control=control,
        rows=rows,
        notes=tuple(_about(given, table, control, {row.label for row in rows}, len(lacking), len(selected))),
    )


def _about(given: Values, table: Sheet, control: str, labels: Collection[str], lacking: int, of: int) -> Iterator[str]:
    """Say what was done with a table that nobody asked for."""
    in_order = sorted(labels)
    for same in grouped(in_order, map(str.casefold, in_order)).values():
        if len(same) > 1:
            yield f"{list_text([*map(repr, same)])} count as several groups: they differ in capital letters alone."
    if lacking:
        yield f"{lacking} of {of} rows lack a value or a label, and are left out."
    if given.control is None:
        yield f"The control is taken to be {control!r}, the first in order: name another with --control."
    if table.encoding != "utf-8":
        yield f"{table.file.name} is no UTF-8 text and was read as {table.encoding}."


def difference_number(
    value: float | Undefined, interval: tuple[float, float] | Undefined, level: float, unit: str
) -> Number:
    """Return a difference with its interval as figures take it."""
    low, high = (interval, interval) if isinstance(interval, Undefined) else interval
    return Number(value, unit, ci_low=low, ci_high=high, ci_level=level)


def estimation_of(
    observed: Observations,
    differences: Mapping[str, Number],
    bounds: Sequence[float] = (),
    difference: str = "",
    interval: str = "",
) -> Estimation:
    """Return an estimation plot of all groups; `differences` from the control by a group's label.

    `difference` begins what these are called, `interval` says which method their intervals are of.
    """
    known, words = observed.known(), observed.quantity
    named = len(words) == 1 or "_" in words  # x and b_ad_gain stay as they are
    groups = tuple(
        EstimationGroup(
            drawn_name(observed, label),
            tuple(float(row.value) for row in known.rows if row.label == label and row.value is not None),
        )
        for label in observed.labels
    )
    return Estimation(
        quantity=words if named else f"{words[:1].upper()}{words[1:]}",
        unit=observed.unit,
        groups=groups,
        reference=0,
        differences=tuple(differences.get(label) for label in observed.labels),
        bounds=tuple(bounds),
        difference=f"{difference} {drawn_name(observed, observed.control)}" if difference else "",
        interval=interval,
    )


def as_shown_to_people(observed: Observations) -> Observations:
    """Return a book's observations with their groups named as in the report; those of a table as they are.

    Where two levels would be shown alike, all keep the names that the book writes.
    """
    if observed.configuration is None:
        return observed
    shown = {label: drawn_name(observed, label, gain=True).replace(NO_BREAK, " ") for label in observed.labels}
    if len(set(shown.values())) < len(shown):
        return observed
    factor = _factor(observed)
    return replace(observed, shown=shown, shown_by="" if factor is None else in_sentence(title_of(factor)))


def drawn_name(observed: Observations, label: str, *, gain: bool = False) -> str:
    """Name a group: "CE", "d = 186 kg/s", "active damping", "small foot"; groups of a table as the table does.

    With `gain` a level that is one has it behind: "d = 186 kg/s (gain 50)".
    """
    configuration, factor = observed.configuration, _factor(observed)
    if configuration is None or factor is None:
        return observed.name(label)
    of_gain = configuration.gains.get(observed.by)
    if observed.by == pairing.swept_factor(configuration):
        if label == observed.rest:
            return factor.treatment or "the treatment"
        if label == factor.control:
            return swept_words(factor).control_level
    try:
        value = float(label)
    except ValueError:
        return observed.name(label) if label == observed.rest else level_name(factor, Level(observed.by, label))
    if of_gain is None:
        return level_name(factor, Level(observed.by, label, value, factor.unit))
    return level_name(factor, Level(observed.by, label, of_gain.physical(value), of_gain.unit, value), gain=gain)


def _factor(observed: Observations) -> Factor | None:
    """Return the factor that makes the groups as the report knows it, None where no factor of a book does."""
    configuration = observed.configuration
    if configuration is None or observed.by not in configuration.factors:
        return None
    return study_factor(configuration, observed.by)
