"""The course of one recharge as a logging charger sees it: constant current, then less and less, 1 Hz."""

from __future__ import annotations

import numpy as np

from data_schema.units import MAH_TO_COULOMB
from labbook.demo.writers import Recharge

_CURRENT_A = 1.0
_LEAST_CURRENT_A = 0.1
_RAMP_A_S = 0.25
_TAPER_FROM = 0.88
"""Part of the charge after which the current falls in proportion to what is left."""
_CELLS = 4
_CELL_RISE_V = 0.035
_CELL_RESISTANCE_OHM = 0.004


def recharge_course(seed: int, charge_mah: int, end_voltage_v: float) -> Recharge:
    """Draw a recharge that ends with the counter at `charge_mah` and the resting pack at `end_voltage_v`."""
    rng = np.random.default_rng(np.random.SeedSequence([seed, 3]))
    goal_c = charge_mah * MAH_TO_COULOMB
    currents_a, charged_c = [0.0], [0.0]
    while charged_c[-1] < goal_c:
        left = (goal_c - charged_c[-1]) / (goal_c * (1 - _TAPER_FROM))
        current_a = min(_CURRENT_A, currents_a[-1] + _RAMP_A_S, max(_LEAST_CURRENT_A, _CURRENT_A * left))
        current_a = round(current_a, 2)  # the log's resolution
        charged_c.append(charged_c[-1] + (currents_a[-1] + current_a) / 2)
        currents_a.append(current_a)
    current_a_array = np.array(currents_a)
    n = current_a_array.size
    done = np.minimum(np.array(charged_c) / goal_c, 1.0)
    rest_v = end_voltage_v / _CELLS - _CELL_RISE_V * (1 - done)
    imbalance_v = rng.normal(0, 0.002, _CELLS)
    loaded_v = rest_v[:, None] + _CELL_RESISTANCE_OHM * current_a_array[:, None]
    cell_v = loaded_v + (imbalance_v - imbalance_v.mean()) + rng.normal(0, 0.0008, (n, _CELLS))
    return Recharge(
        time_s=np.arange(n, dtype=np.float64),
        current_a=current_a_array,
        input_v=23.8 - 0.05 * current_a_array + rng.normal(0, 0.01, n),
        pack_v=cell_v.sum(axis=1) + rng.normal(0, 0.001, n),
        charge_mah=np.floor(done * charge_mah),
        internal_c=31.0 + 4.0 * done,
        external_c=np.zeros(n),
        cell_v=cell_v,
    )
