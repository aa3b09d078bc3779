"""Warnings about a simulated jump: no robot makes it, it hangs on little, or it is less accurate than asked for."""

from __future__ import annotations

from simulator.jump import ILL_CONDITIONED_BELOW, close_decision, grown_rounding
from simulator.result import SceneResult


def warnings(result: SceneResult) -> list[str]:
    """Return what has to be said of a scene's last jump before its numbers are."""
    return [*_under_surface(result), *_ill_conditioned(result), *_repeats(result)]


def times(count: int) -> str:
    """Say how often: "once", "3 times"."""
    return "once" if count == 1 else f"{count} times"


def _under_surface(result: SceneResult) -> list[str]:
    """Say that the body is where the model has no ground for it."""
    jump, scene = result.jump, result.scene
    if not jump.under_surface:
        return []
    reach_m = scene["upper_link"] + scene["lower_link"]
    deeper = f", deeper than the longest leg ({reach_m:.4g} m)" if jump.max_depth_m > reach_m else ""
    return [
        f"warning: no robot jumps like this. The foot sinks {jump.max_depth_m:.4g} m{deeper}, and the body gets "
        f"{-jump.min_body_height_m:.4g} m under the surface of the grains, which act on the foot alone: "
        "give a larger foot or firmer grains."
    ]


def _ill_conditioned(result: SceneResult) -> list[str]:
    """Say why the last jump is ill-conditioned: for itself, or because it follows one that is."""
    jump, said = result.jump, []
    if close_decision(jump):
        where = "" if jump.decision_tick is None else f" at tick {jump.decision_tick}"
        shown = "only the branch taken was simulated" if jump.other_branch is None else "both branches are shown"
        said.append(
            f"warning: this jump hangs on a knife's edge. A decision of the controller{where} is only "
            f"{jump.decision_margin:.2g} local errors away from falling otherwise (under {ILL_CONDITIONED_BELOW:g} is "
            f"ill-conditioned); {shown}."
        )
    rounding = grown_rounding(jump, result.accuracy)
    if rounding:
        said.append(
            f"warning: errors grow in this jump. The sampled active damping multiplies them by up to "
            f"{jump.error_growth:.2g}, so that rounding alone leaves an error of about {100.0 * rounding:.2g} %, "
            "however fine the accuracy asked for."
        )
    if jump.ill_conditioned and not said:
        first = next(number for number, item in enumerate(result.jumps, 1) if item.ill_conditioned)
        said.append(f"warning: this jump follows jump {first}, which is ill-conditioned, and is known no better.")
    return said


def _repeats(result: SceneResult) -> list[str]:
    """Say what simulating again with finer steps has not mended, and what it came to where it took too many."""
    jump, said = result.jump, []
    if jump.open_book:
        share = abs(jump.energy_residual_J) / jump.energy_at_play_J
        again = f", though it was simulated again {times(jump.repeats)} with finer steps" if jump.repeats else ""
        said.append(
            f"warning: the energy book of this jump does not close within the accuracy{again}. It is off by "
            f"{share:.1e} of what it turns over, where {result.accuracy:g} was asked for, and so may be the other "
            "numbers."
        )
    if jump.outcome == "step_limit" and jump.repeats:
        said.append(
            f"warning: the scene was simulated again {times(jump.repeats)} with finer steps, since errors grow in it "
            "or an energy book did not close within the accuracy, and they are too many: ask for a coarser --accuracy."
        )
    return said
