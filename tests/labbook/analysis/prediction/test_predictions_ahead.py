"""Which predictions a second process makes while the runs are analysed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from data_schema.cache_folder import CACHE_VARIABLE
from labbook.analysis.prediction import predicting
from labbook.analysis.prediction.predicting import PredictionResult, predictions, predictions_in_background
from labbook.analysis.prediction.simulating import ALWAYS
from labbook.analysis.results import Results
from labbook.analysis.study_data import gather
from tests.labbook.analysis.prediction.test_predicting import predicted_book


def test_only_conditions_with_a_charge_or_a_log_are_simulated_ahead(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of others nothing is shown."""
    monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.setattr(predicting, "has_core", lambda: True)
    with predicted_book(tmp_path).open() as book, book.reading() as connection:
        evidence = gather(connection, book.configuration, None)
        planned = {run.uid for run in evidence.runs if "foot=large" in run.condition_key}
        assert 0 < len(planned) < len(evidence.runs)
        charges = {uid: found for uid, found in evidence.charges.items() if uid not in planned}
        logs = {uid: found for uid, found in evidence.logs.items() if uid not in planned}
        ahead = predictions_in_background(connection, replace(evidence, charges=charges, logs=logs))
        assert {key for key, _robot in ahead.wanted} == {
            run.condition_key for run in evidence.runs if run.uid not in planned
        }
        assert len(ahead.by_name()) == len(ahead.wanted)


def test_they_are_what_this_process_simulates(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def predicted(*, second: bool) -> dict[tuple[str, str], PredictionResult]:
        monkeypatch.setenv(CACHE_VARIABLE, str(tmp_path / f"cache {second}"))
        monkeypatch.setattr(predicting, "has_core", lambda: second)
        ahead = predictions_in_background(connection, evidence)
        assert (ahead.simulating is not None) is second
        return predictions(Results(), connection, evidence, keys, lambda _said: None, ALWAYS, ahead)

    with predicted_book(tmp_path).open() as book, book.reading() as connection:
        evidence = gather(connection, book.configuration, None)
        keys = list(dict.fromkeys(run.condition_key for run in evidence.runs))
        assert predicted(second=True) == predicted(second=False) != {}
