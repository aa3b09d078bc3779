"""A foot in beds of grains: as a table, as sentences, as data."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from data_schema.rounding import decimals_for, fixed_text
from labbook.presenting.simulation.simulated import scene_data
from labbook.terminal import columns, within_width
from reports.display import count_text, list_text
from simulator.grains.bed import SPREAD
from simulator.grains.foot import BedJumps, FootMotion, GrainsJump, GrainsStudy

CONTROLLERS = ("ce", "ad")
_MILLI = 1e3
_QUANTITIES: dict[str, tuple[str, Callable[[GrainsJump], float]]] = {
    "peak_compression_J": ("compression mJ", lambda jump: jump.peak_compression_j),
    "peak_extension_J": ("extension mJ", lambda jump: jump.peak_extension_j),
    "extension_work_J": ("foot's work mJ", lambda jump: jump.extension_work_j),
}


def bulk_extension_work_j(motion: FootMotion) -> float:
    """Return what the foot does on the bulk model's ground from the leg's shortest length on."""
    work_j = motion.bulk_work_j
    return float(work_j[-1] - np.interp(motion.extension_time_s, motion.time_s, work_j))


def ratios(beds: Sequence[BedJumps]) -> list[float]:
    """Return, of each bed, how many times the grains' peak in extension under CE is that under AD."""
    return [bed.jumps.ce.peak_extension_j / bed.jumps.ad.peak_extension_j for bed in beds]


def as_data(study: GrainsStudy) -> dict[str, Any]:
    """Return the whole study for JSON; of each bed the numbers of both jumps, without their course over time."""
    return {
        **scene_data(study.scene),
        "assumed_of_grains": asdict(study.beds[0].asked.material),
        "bulk": {
            name: {
                "max_depth_m": motion.max_depth_m,
                "extension_time_s": motion.extension_time_s,
                "liftoff_time_s": motion.liftoff_time_s,
                "extension_work_J": bulk_extension_work_j(motion),
            }
            for name in CONTROLLERS
            for motion in [getattr(study.motions, name)]
        },
        "beds": [
            {
                "diameter_m": bed.asked.diameter_m,
                "seed": bed.asked.seed,
                "grains": bed.n_grains,
                "solid_fraction": bed.solid_fraction,
                "step_s": bed.asked.step_s,
                "peak_ratio": ratios([bed])[0],
                **{
                    name: {
                        **{key: of(jump) for key, (_, of) in _QUANTITIES.items()},
                        "work_J": float(jump.work_j[-1]),
                        "book_residual": jump.book_residual,
                        "processor_s": jump.processor_s,
                        "ns_a_grain_and_step": jump.ns_a_grain_and_step,
                    }
                    for name in CONTROLLERS
                    for jump in [getattr(bed.jumps, name)]
                },
            }
            for bed in study.beds
        ],
        "settling_processor_s": study.settling_s,
    }


def as_lines(study: GrainsStudy) -> list[str]:
    """Return what people read: the beds, the table, how CE compares with AD, and what the numbers rest on."""
    scene, first = study.scene, study.beds[0].asked
    sizes = sorted({bed.asked.diameter_m for bed in study.beds})
    head = ("grains", "foot", *(title for title, _ in _QUANTITIES.values()), "bulk model mJ")
    rows = []
    for diameter_m in sizes:
        beds = study.of_diameter(diameter_m)
        for name in CONTROLLERS:
            jumps = [getattr(bed.jumps, name) for bed in beds]
            cells = (_with_scatter([_MILLI * of(jump) for jump in jumps]) for _, of in _QUANTITIES.values())
            bulk_mj = _MILLI * bulk_extension_work_j(getattr(study.motions, name))
            rows.append((_size(diameter_m), name.upper(), *cells, f"{bulk_mj:.0f}"))
    jumps = [getattr(bed.jumps, name) for bed in study.beds for name in CONTROLLERS]
    spent_s = study.settling_s + sum(jump.processor_s for jump in jumps)
    material = first.material
    beds_text = (
        f"{_size(one)}: {count_text(len(beds), 'bed')} of {list_text(sorted({str(bed.n_grains) for bed in beds}))} "
        f"grains, {100.0 * statistics.mean(bed.solid_fraction for bed in beds):.0f} % solid, the foot "
        f"{2.0 * scene['foot_radius'] / one:.2g} grains wide"
        for one in sizes
        for beds in [study.of_diameter(one)]
    )
    compared = []
    for one in sizes:
        found = ratios(study.of_diameter(one))
        more = "; of one bed the scatter is not known, --seeds 3 tells it."
        if len(found) > 1:
            more = f", {min(found):.3g} to {max(found):.3g} (mean ± standard deviation of {len(found)} beds)."
        times = f"{_with_scatter(found)} times the kinetic energy of AD{more}"
        compared.append(f"{_size(one)} grains: in extension CE gives them {times}")
    before = [
        f"{scene.name}: {scene.title}",
        f"beds of {first.width_m:g} m x {first.width_m:g} m, {first.depth_m:g} m deep. {'; '.join(beds_text)}.",
        "",
        "the grains' largest kinetic energy in compression and in extension; the foot's work in extension, on them and "
        "on the bulk model's ground:",
    ]
    after = [
        *compared,
        "extension: from the leg's shortest length until the foot has left. CE: b_ad of 0; AD: b_ad of "
        f"{scene['b_ad']:g} kg/m.",
        "one-way: the foot follows the bulk model's jump, whatever the grains do. Energies are told therefore; the "
        "force late in stance, where that model holds the foot still, is not that of a robot on grains.",
        f"assumed, without a source: Young's modulus {material.young_modulus_pa:g} Pa, Poisson's ratio "
        f"{material.poisson_ratio:g}, restitution {material.restitution:g}, friction {material.friction:g}, rolling "
        f"friction {material.rolling_friction:g}, diameters {100.0 * SPREAD:g} % about their mean; the scene's grains "
        f"weigh {scene['rho']:g} kg/m^3.",
        f"the energy book of the grains closes to {100.0 * max(jump.book_residual for jump in jumps):.1g} % of the "
        f"foot's work or better. {spent_s:.0f} s of processor time, of which {study.settling_s:.0f} s for settling, "
        f"which is kept; {statistics.median(jump.ns_a_grain_and_step for jump in jumps):.0f} ns a grain and step.",
    ]
    return [*within_width(before), "", *columns(head, rows), "", *within_width(after)]


def _size(diameter_m: float) -> str:
    return f"{_MILLI * diameter_m:g} mm"


def _with_scatter(values: Sequence[float]) -> str:
    mean = statistics.mean(values)
    scatter = statistics.stdev(values) if len(values) > 1 else 0.0
    if not scatter > 0.0:
        return f"{mean:.3g}" if mean < 100.0 else f"{mean:.0f}"
    places = decimals_for(scatter)
    return f"{fixed_text(mean, places)} ± {fixed_text(scatter, places)}"
