"""Why a jump is ill-conditioned: a decision that nearly fell otherwise, or errors that grow; it may be both."""

from __future__ import annotations

from simulator.jump import ILL_CONDITIONED_BELOW, ROUNDING
from simulator.result import JumpResult


def close_decision(jump: JumpResult) -> bool:
    """Whether the outcome hangs on a decision that lies under ten local errors from falling otherwise."""
    return jump.decision_margin is not None and jump.decision_margin < ILL_CONDITIONED_BELOW


def grown_rounding(jump: JumpResult, accuracy: float) -> float:
    """Return the relative error that rounding alone has grown to, at most 1; 0 where `accuracy` has room for it."""
    error = jump.error_growth * ROUNDING
    return min(error, 1.0) if error > 0.5 * accuracy else 0.0
