"""The emulator study of a book (thesis 4.3)."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path

from data_schema.errors import InputRefused, UsageError
from data_schema.outcomes import Outcome
from data_schema.queries.runs import refuse_empty_selection
from data_schema.vocabulary import FactorKind
from labbook.actions.studies.of_book import LEVEL, OfBook, book_sources, damping_factor, first_given
from labbook.analysis.outcomes.conditions import conditions_by_outcome
from labbook.analysis.outcomes.detection import Detections
from labbook.analysis.outcomes.run_energy import joules_per_mah
from labbook.analysis.prediction.simulating import plain_predictions
from labbook.analysis.results.result_cache import ResultCache
from labbook.analysis.studies.emulator import EmulatorStudy, emulator_study
from labbook.analysis.study_data import gather
from labbook.book.opening import opened
from labbook.config.model import StudyProtocol
from labbook.config.parsing import Configuration
from stats.checks import as_level

CONSTANT, RATIO, SAME_PERCENT = 50.0, 6.0, 2.0
"""The active-damping gain that is the same at all extension gains, the extension gain over the one that is scaled with
it (thesis 4.3), and the rise of the apex below which it is not appreciable, in percent."""


def emulator_study_of(
    book_folder: Path | None,
    where: str | None,
    constant: float | None,
    ratio: float | None,
    same_percent: float | None,
    level: float | None,
    progress: Callable[[str], None],
) -> OfBook[EmulatorStudy]:
    """Open the book and compare the controllers at each extension gain; None is `[studies.emulator]`, or the default.

    Raises `UsageError` for a book whose factors are not an extension gain and an active-damping gain with a control,
    and for options that are none; `InputRefused` as `emulator_study` does, and for a book whose `[protocol]` does not
    say which jumps are left out.
    """
    with opened(book_folder) as book, book.reading() as connection:
        protocol = book.configuration.studies.get("emulator", StudyProtocol())
        where = where or protocol.where
        level = as_level("--level", first_given(level, protocol.level, LEVEL))
        ratio = first_given(ratio, protocol.ratio, RATIO)
        same_percent = first_given(same_percent, protocol.same_percent, SAME_PERCENT)
        if ratio <= 0.0 or not 0.0 < same_percent < 100.0:
            raise UsageError("--ratio is above 0 and --same between 0 and 100, in percent: give such numbers.")
        gain, damping = _factors(book.configuration)
        _check_protocol(book.configuration)
        progress("joules and apex heights")
        refuse_empty_selection(connection, where)
        evidence = gather(connection, book.configuration, where)
        conditions = conditions_by_outcome(
            ResultCache(connection),
            Detections(connection, book.store, progress),
            evidence,
            (Outcome.JOULES, Outcome.APEX),
        )
        simulated = plain_predictions(connection, evidence, progress)
        sources = book_sources(connection, book.configuration, where or "all")
    study = book.configuration.study
    steps_mah = [charge.resolution_mah for run in evidence.runs for charge in evidence.charges.get(run.uid, ())]
    resolution_j = max(steps_mah, default=0.0) * joules_per_mah(study.reference_voltage_v, study.jumps_nominal)
    found = emulator_study(
        conditions,
        gain,
        damping,
        constant=first_given(constant, protocol.constant, CONSTANT),
        ratio=ratio,
        same_percent=same_percent,
        resolution_j=resolution_j,
        level=level,
        simulated=simulated,
    )
    return OfBook(found, sources)


_JUMP_RULES = {"exclude_first_jumps": "2", "exclude_gap_jumps": "true"}
"""Keys of `[protocol]` that say which jumps are left out without asking, and what the thesis has for them."""


def _check_protocol(configuration: Configuration) -> None:
    """Refuse a book whose `[protocol]` does not decide which jumps are left out."""
    given = tomllib.loads(configuration.text).get("protocol", {})
    missing = [f"{key} = {usual}" for key, usual in _JUMP_RULES.items() if key not in given]
    if missing:
        raise InputRefused(
            "labbook.toml does not say which jumps the study leaves out: write under [protocol] "
            f"{' and '.join(missing)} (thesis 4.3.3; 0 and false leave none out)."
        )


def _factors(configuration: Configuration) -> tuple[str, str]:
    """Return the names of the factors of the extension gain and of the active-damping gain."""
    damping = damping_factor(configuration, "0, 17, 33, 50, 67, 83")
    others = [name for name, factor in configuration.factors.items() if factor.kind is FactorKind.NUMBER]
    others.remove(damping)
    if len(others) != 1:
        raise UsageError(
            f"labbook.toml has {len(others)} further factors of kind number, and the study needs one, the extension "
            'gain: write [factors.k_gain] with kind = "number" and levels = [100, 200, 300, 400, 500].'
        )
    return others[0], damping
