"""The tables of a book as others read them: one row a thing, the unit in the name of the column.

Numbers are those of a report of the same runs. Columns that stand in a view of the database are the view's.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import sqlalchemy as sa

from data_schema.columns import Column, ValueKind
from data_schema.outcomes import Outcome
from data_schema.queries.history import void_reasons
from data_schema.queries.runs import refuse_empty_selection
from data_schema.queries.study import planned_runs
from data_schema.views import VIEWS, words
from data_schema.vocabulary import FactorKind, ReasonCode, RunState, Undefined
from ingest.store import Store
from labbook.analysis.comparison import pairing
from labbook.analysis.measured import Measured, measure_study
from labbook.analysis.outcomes.conditions import number_of
from labbook.analysis.outcomes.detection import Detections, jumps_found
from labbook.analysis.results import Results
from labbook.analysis.study_data import StudyData, gather
from labbook.config.parsing import Configuration
from reports.display import unit_slug
from reports.numbers import Value

if TYPE_CHECKING:
    import pandas as pd


Step = Callable[[str], None]
"""Called with what is being done."""


@dataclass
class Selection:
    """The selected runs of an open book, all of them without `where`; `step` is called with what is being done.

    `known` is what was measured of them, if it was: now, or before in a book that has not changed since.
    """

    connection: sa.Connection
    store: Store
    configuration: Configuration
    where: str | None = None
    step: Step = field(default=lambda _what: None)
    known: Measured | None = None

    @cached_property
    def data(self) -> StudyData:
        """The facts of the runs; raises `InputRefused` where no run fulfils `where`."""
        if self.known is not None:
            return self.known.evidence
        refuse_empty_selection(self.connection, self.where)
        return gather(self.connection, self.configuration, self.where)

    @property
    def measured(self) -> Measured:
        """What a report of these runs measures."""
        if self.known is None:
            detections = Detections(self.connection, self.store, self.step)
            self.known = measure_study(Results(), detections, self.data, self.step)
        return self.known

    @cached_property
    def places(self) -> dict[str, int]:
        """Where each selected run stands in the order of lists, by its name."""
        return {run.name: place for place, run in enumerate(self.data.selected)}


NUMBER, COUNT, FLAG = ValueKind.NUMBER, ValueKind.COUNT, ValueKind.FLAG
_COMPUTED = "computed"
_NO_LOG = "no log of it can be used"
_JUDGED = "the protocol in labbook.toml, and verdicts of persons"


@dataclass(frozen=True, slots=True)
class ExportTable:
    """A table: of what a row is, its columns by name, and its rows; the first `keys` columns say which thing it is."""

    name: str
    row: str
    columns: Mapping[str, Column]
    rows: Sequence[Sequence[Any]]
    keys: int = 1

    def frame(self) -> pd.DataFrame:
        """Return a frame with the key as its index; what columns and missing values mean is in its `attrs`."""
        import pandas as pd

        values = zip(*self.rows, strict=True) if self.rows else ([] for _name in self.columns)
        series = {
            name: _series(column.kind, list(of_column))
            for (name, column), of_column in zip(self.columns.items(), values, strict=True)
        }
        frame = pd.DataFrame(series).set_index(list(self.columns)[: self.keys])
        frame.attrs = {
            "row": self.row,
            "columns": {name: column.text for name, column in self.columns.items()},
            "missing": {name: column.missing for name, column in self.columns.items() if column.missing},
        }
        return frame


def _series(kind: ValueKind, values: list[Any]) -> pd.Series[Any]:
    """Return the values of a column with the type of its kind; None is missing."""
    import pandas as pd

    if kind is ValueKind.TIME:
        return pd.Series(pd.to_datetime(pd.Series(values, dtype="str"), utc=True, format="ISO8601")).dt.as_unit("us")
    if kind is ValueKind.DATE:
        return pd.Series(pd.to_datetime(pd.Series(values, dtype="str"), format="ISO8601")).dt.as_unit("ms")
    if kind is ValueKind.FLAG:
        return pd.Series([None if value is None else bool(value) for value in values], dtype="boolean")
    return pd.Series(values, dtype=_DTYPES[kind])


_DTYPES = {ValueKind.TEXT: "str", ValueKind.NUMBER: "float64", ValueKind.COUNT: "Int64"}


def of_view(selection: Selection, view: str, name: str) -> ExportTable:
    """Return a view of the database, the selected runs' rows alone; what is of no run is left out of a selection."""
    described = VIEWS[view]
    found = selection.connection.execute(sa.text(f"SELECT * FROM {view}")).all()  # noqa: S608 - a name of our own
    run = list(described.columns).index("run")
    beyond = len(selection.places)
    rows = [row for row in found if row[run] in selection.places or (row[run] is None and not selection.where)]
    rows.sort(key=lambda row: selection.places.get(row[run], beyond))
    return ExportTable(name, described.row, described.columns, rows)


def runs(selection: Selection) -> ExportTable:
    """Return the selected runs with their levels, and every outcome that was measured."""
    facts = of_view(selection, "v_run", "runs")
    factors = factor_columns(selection)
    measured = selection.measured
    columns = {
        **facts.columns,
        **{factor.name: factor.column for factor in factors},
        "jumps_found": Column("jumps with an apex that the detector found", COUNT, missing=_NO_LOG, source=_COMPUTED),
        "jumps_counted": Column("those that count", COUNT, missing=_NO_LOG, source=_JUDGED),
        "why_void": Column("why the run is void", missing="it is not", source="journal"),
        **_outcome_columns(measured.results),
    }
    void = void_reasons(
        selection.connection, [run.uid for run in selection.data.selected if run.state is RunState.VOID]
    )
    by_name = {run.name: run for run in selection.data.selected}
    numbers = {run.uid for run in selection.data.runs}
    rows = []
    for fact in facts.rows:
        run = by_name[fact[0]]
        judged = measured.judgements.get(run.uid)
        found: list[Any] = [None, None, void.get(run.uid)]
        if judged is not None:
            found[:2] = jumps_found([one.jump for one in judged.jumps]), len(judged.counted)
        outcomes: list[Any] = []
        for outcome, results in measured.results.items():
            if (result := results.results.get(run.uid)) is not None:
                number = number_of(result, outcome)
                why_not = number.value.reason if isinstance(number.value, Undefined) else None
                outcomes += [*map(_plain, (number.value, number.se, number.shared_se)), why_not]
                continue
            why = results.missing[run.uid].reason if run.uid in results.missing else outcome.undefined_because
            if run.uid not in numbers:
                why = "the run is void" if run.state is RunState.VOID else f"a run of kind {run.kind} has none"
            outcomes += [None, None, None, why]
        rows.append([*fact, *(factor.value(run.levels) for factor in factors), *found, *outcomes])
    return replace(facts, columns=columns, rows=rows)


@dataclass(frozen=True, slots=True)
class FactorColumn:
    """A column of a factor's levels: what stands for each label, the label itself without `values`."""

    name: str
    column: Column
    factor: str
    values: Mapping[str, float | None] | None = None

    def value(self, levels: Mapping[str, str]) -> Any:
        """Return what stands for the level of a run or a condition, None where it has none."""
        label = levels.get(self.factor)
        return label if self.values is None or label is None else self.values.get(label)


def factor_columns(selection: Selection) -> list[FactorColumn]:
    """Return the columns of the study's factors: the level that labbook.toml has and, of gains, what it stands for."""
    found: list[FactorColumn] = []
    for row in selection.data.factors:
        settings = selection.configuration.factors.get(row.name)
        name = f"factor_{row.name}" if row.name in VIEWS["v_run"].columns else row.name
        values = {level.label: level.value for level in row.levels}
        is_number = settings is not None and settings.kind is FactorKind.NUMBER and None not in values.values()
        level = Column(
            f"level of the {(settings and settings.title) or row.name.replace('_', ' ')}",
            NUMBER if is_number else ValueKind.TEXT,
            (settings.unit or "") if settings is not None and is_number else "",
            "the run has none",
            ", ".join(values),
            "run sheet",
        )
        found.append(FactorColumn(name, level, row.name, values if is_number else None))
        gain = selection.configuration.gains.get(row.name)
        if gain is not None and is_number:
            physical = {label: gain.physical(value) for label, value in values.items() if value is not None}
            stands_for = replace(level, meaning=f"what the {level.meaning} stands for", unit=gain.unit, allowed="")
            found.append(FactorColumn(f"{name}_{unit_slug(gain.unit)}", stands_for, row.name, physical))
    return found


def _computed(meaning: str, unit: str, missing: str = "it has none") -> Column:
    return Column(meaning, NUMBER, unit, missing, source=_COMPUTED)


def _outcome_columns(outcomes: Mapping[Outcome, object]) -> dict[str, Column]:
    found: dict[str, Column] = {}
    for one in outcomes:
        key, unit, what = one.key, one.unit, one.heading.lower()
        found |= {
            f"{key}_{unit}": _computed(what, unit, f"see why_no_{key}"),
            f"{key}_se_{unit}": _computed(f"standard error of the {what}, without what runs have in common", unit),
            f"{key}_shared_se_{unit}": _computed(
                "standard error that it has in common with other runs (drain line, calibration)", unit
            ),
            f"why_no_{key}": Column(f"why it has no {what}", missing="it has one", source=_COMPUTED),
        }
    return found


def _plain(value: Value | None) -> float | None:
    return value if isinstance(value, float | int) else None


def jumps(selection: Selection) -> ExportTable:
    """Return every jump found in the logs of the selected runs, with the verdict on it and whether it counts."""
    of_view = VIEWS["v_jump"].columns
    columns = {
        **{name: of_view[name] for name in ("run", "jump", *_OF_JUMP)},
        "counted": Column("whether a report counts it", FLAG, source=_JUDGED),
        "why_not_counted": Column("why it does not count", missing="it counts", source=_JUDGED),
        "verdict": of_view["verdict"],
        "reason": replace(of_view["reason"], allowed=words(ReasonCode)),
        "person": Column("who gave the verdict", missing="none stands", source="journal"),
        "blind": replace(VIEWS["v_verdict"].columns["blind"], missing="no verdict stands"),
    }
    names = {run.uid: run.name for run in selection.data.selected}
    rows = []
    for uid, judgement in selection.measured.judgements.items():
        for item in judgement.jumps:
            jump, said = item.jump, item.decision
            verdict = [None] * 4 if said is None else [said.verdict, said.reason_code, said.person, said.blind]
            found = (jump.touchdown_s, jump.liftoff_s, jump.apex_s, jump.apex_height_m, jump.apex_height_se_m)
            why = None if jump.undefined_reason is None else str(jump.undefined_reason)
            rows.append(
                [
                    names[uid],
                    jump.number,
                    *found,
                    jump.flight_time_s,
                    why,
                    item.excluded is None,
                    item.excluded,
                    *verdict,
                ]
            )
    rows.sort(key=lambda row: selection.places[row[0]])
    return ExportTable("jumps", "a stance in a log, and the jump out of it", columns, rows, keys=2)


_OF_JUMP = (
    "touchdown_s", "lift_off_s", "apex_s", "apex_height_m", "apex_height_se_m", "flight_time_s", "why_no_apex"
)  # fmt: skip


def conditions(selection: Selection) -> ExportTable:
    """Return the conditions of the selected runs with the mean of each outcome over their runs."""
    factors = factor_columns(selection)
    measured = selection.measured.conditions
    known = {row.name: [level.label for level in row.levels] for row in selection.data.factors}
    every = [item for several in measured.values() for item in several]
    every.sort(key=lambda item: pairing.place(known, pairing.swept_factor(selection.configuration), item.levels))
    by_key = {item.key: item for item in every}
    columns = {
        "condition": Column("its levels, as `foot=small k_gain=400`", source="run sheet"),
        "is_control": replace(VIEWS["v_run"].columns["is_control"], missing=""),
        **{factor.name: factor.column for factor in factors},
    }
    for outcome in measured:
        columns |= _mean_columns(outcome)
    values = {outcome: {item.key: item.result for item in several} for outcome, several in measured.items()}
    rows = []
    for key, item in by_key.items():
        row: list[Any] = [key, item.is_control, *(factor.value(item.levels) for factor in factors)]
        for outcome in measured:
            found = values[outcome].get(key)
            if found is None:
                row += [0, *[None] * 7]
                continue
            mean = found.mean
            ends = (mean.se, mean.shared_se, mean.ci_low, mean.ci_high)
            row += [len(found.runs), _plain(mean.value), _plain(found.sd.value), *map(_plain, ends), mean.ci_level]
        rows.append(row)
    return ExportTable("conditions", "a condition of the selected runs", columns, rows)


def _mean_columns(outcome: Outcome) -> dict[str, Column]:
    name, unit, of = outcome.key, outcome.unit, outcome.heading.lower()

    def number(meaning: str, missing: str = "too few runs") -> Column:
        return _computed(meaning, unit, missing)

    return {
        f"{name}_runs": Column(f"runs with a value of the {of}", COUNT, source=_COMPUTED),
        f"{name}_mean_{unit}": number(f"mean {of} of these runs", "no run has one"),
        f"{name}_sd_{unit}": number(f"standard deviation of the {of} of these runs"),
        f"{name}_se_{unit}": number("standard error of the mean, from the scatter of these runs"),
        f"{name}_shared_se_{unit}": number("standard error that these runs have in common", "they have none"),
        f"{name}_ci_low_{unit}": number("lower end of the mean's confidence interval, of both errors"),
        f"{name}_ci_high_{unit}": number("upper end of it"),
        f"{name}_ci_level": replace(number("its level", "no run has one"), unit=""),
    }


def planned(selection: Selection) -> ExportTable:
    """Return the runs of all plans that were not withdrawn, or were made, with the runs that were made of them."""
    rows = [
        (row.position, row.block, row.name, row.condition_key, row.run_name)
        for row in planned_runs(selection.connection)
    ]
    columns = {
        "position": Column("place in the order of its plan", COUNT, source="plan"),
        "block": Column("block of the plan", source="plan"),
        "planned_run": Column("name that the plan gave it", source="plan"),
        "condition": Column("its levels, as `foot=small k_gain=400`", missing="it has none", source="plan"),
        "run": Column("the run that was made of it", missing="none was made", source="run sheet"),
    }
    return ExportTable("planned_runs", "a run of a plan that was not withdrawn, or was made", columns, rows)


TABLES: Mapping[str, Callable[[Selection], ExportTable]] = {
    "runs": runs,
    "jumps": jumps,
    "charges": lambda selection: of_view(selection, "v_charge", "charges"),
    "conditions": conditions,
    "verdicts": lambda selection: of_view(selection, "v_verdict", "verdicts"),
    "findings": lambda selection: of_view(selection, "v_finding", "findings"),
    "signals": lambda selection: of_view(selection, "v_signal", "signals"),
    "notes": lambda selection: of_view(selection, "v_note", "notes"),
    "planned_runs": planned,
}
"""The tables by name, in the order in which they are written."""


def table_of(selection: Selection, name: str) -> ExportTable:
    """Return a table of a selection by its name, its rows in the same order on any engine.

    The rows of each run, or of what else the first column names, go by all that they say.
    """
    table = TABLES[name](selection)
    places = {key: place for place, key in enumerate(dict.fromkeys(row[0] for row in table.rows))}
    rows = sorted(table.rows, key=lambda row: (places[row[0]], [_comparable(cell) for cell in row[1:]]))
    return replace(table, rows=rows)


def every_table(selection: Selection) -> list[ExportTable]:
    """Return all tables of a selection."""
    return [table_of(selection, name) for name in TABLES]


def _comparable(cell: Any) -> tuple[bool, float, str]:
    return (False, 0.0, cell) if isinstance(cell, str) else (cell is None, cell or 0.0, "")
