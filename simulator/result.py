"""What a simulation gives: one result a jump, in SI units, with what it cost to compute."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

from data_schema.notebook import fields_html
from simulator.effects.registry import ENERGIES
from simulator.scene import Scene

if TYPE_CHECKING:
    import xarray


@dataclass(frozen=True, slots=True)
class ModeChange:
    """A change of the contact mode, at a time since touchdown."""

    time_s: float
    before: str
    after: str


@dataclass(frozen=True, slots=True)
class JumpResult:
    """One jump, from touchdown on. Heights are above the undisturbed surface; None: not reached.

    Energies are in joules. Those of the stance are integrals from touchdown to the last lift-off before the apex; those
    of the jump run to its end, as do the losses and gains that effects declare, each a field (`BOOKED` of
    `simulator.effects.registry`), and the residual of the energy book. `cost_J` is the sum of the cost's parts in the
    stance (with the effect `cost_of_whole_jump`, in the jump), `COSTS` there and the mechanical one, and of the passive
    draw.

    `decision_margin` is the distance of the closest decision of the sampled controller, in units of the local error, or
    of the closest event that was nearly missed or nearly met (lift-off, touchdown, a leg that folds or is straight, a
    switch without a clock) or came nearly after another (the foot meets the grains, the body turns, the emulator's
    platform begins to yield, its shortest hold ends; `decision_tick` is None for both); None where none was within 10.
    With one the jump is `ill_conditioned`, and `other_branch` is it with the other decision at a tick. It is also
    `ill_conditioned` where sampled damping, or contact of a slow foot, amplifies errors (`error_growth`) until rounding
    alone takes half of the accuracy; where a controller without a clock chatters (a margin of 0); and where the cost is
    a small difference of what is turned over.

    `unresisted_sink_m` is how far a lifted foot sank below its print without meeting the ground (effect
    `contact_once_risen`); `cancelled_liftoff` among the counters how often the gains of flight took a lift-off back
    (without that effect).

    `errors` are estimated absolute errors by output, where they were asked for; `ill_conditioned` then says that one is
    above the accuracy, so that all are the least that they may be, and `coarser` is the jump of the coarser simulation
    where that ends otherwise (`simulator.error_bars`).

    `repeats` counts how often the scene was simulated again with finer steps, because errors grew or the energy book
    did not close within the accuracy; where it never closed, `open_book` is true. `under_surface`: the body gets below
    the surface of the grains, which act on the foot alone. `never_rose`: the lifted foot never rose above its print,
    and the touchdown is where the body falls: no jump.
    """

    outcome: str
    touchdown_time_s: float
    liftoff_time_s: float | None
    max_depth_m: float
    unresisted_sink_m: float
    liftoff_body_height_m: float | None
    liftoff_body_velocity_m_s: float | None
    liftoff_foot_velocity_m_s: float | None
    apex_height_m: float | None
    apex_foot_height_m: float | None
    apex_time_s: float | None
    next_touchdown_time_s: float | None
    next_touchdown_body_velocity_m_s: float | None
    stance_heat_J: float  # noqa: N815
    stance_mechanical_J: float  # noqa: N815
    stance_drag_J: float  # noqa: N815
    jump_heat_J: float  # noqa: N815
    jump_mechanical_J: float  # noqa: N815
    jump_drag_J: float  # noqa: N815
    passive_J: float  # noqa: N815
    cost_J: float  # noqa: N815
    leg_work_J: float  # noqa: N815
    ground_loss_J: float  # noqa: N815
    grain_energy_J: float  # noqa: N815
    impact_loss_J: float  # noqa: N815
    reset_work_J: float  # noqa: N815
    for _column in (column for energy in ENERGIES for column in energy.columns):  # those that have no line here
        __annotations__.setdefault(_column, "float")
    del _column
    energy_residual_J: float  # noqa: N815
    energy_at_play_J: float  # noqa: N815
    decision_margin: float | None
    decision_tick: int | None
    error_growth: float
    min_leg_length_m: float
    max_leg_length_m: float
    min_body_height_m: float
    capped_time_s: float
    counters: dict[str, int]
    mode_changes: tuple[ModeChange, ...]
    steps: int
    rhs_evaluations: int
    repeats: int = 0
    ill_conditioned: bool = False
    under_surface: bool = False
    open_book: bool = False
    never_rose: bool = False
    other_branch: JumpResult | None = None
    errors: Mapping[str, float] | None = None
    coarser: JumpResult | None = None

    def _repr_html_(self) -> str:
        """Return the jump in a sentence, and its numbers below in a fold, as notebooks show it."""
        height = "no apex" if self.apex_height_m is None else f"apex at {self.apex_height_m:.4g} m"
        data = {field.name: getattr(self, field.name) for field in fields(self)}
        return fields_html(data, sentence=f"{self.outcome}: {height}, {self.cost_J:.4g} J.")


@dataclass(frozen=True, slots=True)
class SceneResult:
    """All jumps of a scene, simulated at one accuracy.

    `interpreted`: in plain Python, at least at first, as no kernel was compiled for the effects yet. With error bars
    the jumps are simulated to `finer_accuracy`, and `accuracy` is what was asked for.
    """

    scene: Scene
    accuracy: float
    jumps: tuple[JumpResult, ...]
    compile_time_s: float
    wall_time_s: float
    interpreted: bool = False
    trajectory: xarray.Dataset | None = None
    finer_accuracy: float | None = None

    @property
    def jump(self) -> JumpResult:
        """The last jump: the only one of most scenes, the steady one of the others."""
        return self.jumps[-1]

    def _repr_html_(self) -> str:
        """Return the last jump as notebooks show it."""
        return self.jump._repr_html_()
