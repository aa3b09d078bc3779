"""Parameters that several effects read and energies that several turn over, each declared once."""

from __future__ import annotations

from simulator.effects.effect import Energy
from simulator.parameter import Parameter

FOOT_RADIUS = Parameter("foot_radius", "ground", "m", "radius of the flat disk of the foot", 1e-3, 0.2)
CONE_ANGLE = Parameter("cone_angle", "ground", "rad", "angle of the cone of grains under the foot", 0.2, 1.4)
MU = Parameter("mu", "ground", "1", "recruitment rate of the cone", 0.05, 20.0)
PHI = Parameter("phi", "ground", "1", "volume fraction of the grains", 0.05, 0.75)
RHO = Parameter("rho", "ground", "kg/m^3", "density of a grain", 10.0, 2e4)
ADDED_MASS_CONSTANT = Parameter(
    "added_mass_constant", "ground", "kg/m", "added mass a metre of depth beside the cone's (constant C)", 0.0, 20.0
)
CONE = (FOOT_RADIUS, CONE_ANGLE, MU)

STALL_TORQUE = Parameter("stall_torque", "drive", "N m", "stall torque of one of the two motors", 0.05, 500.0)
TORQUE_CONSTANT = Parameter("torque_constant", "drive", "N m/A", "torque a motor gives for each ampere", 1e-3, 10.0)
MOTOR_RESISTANCE = Parameter(
    "motor_resistance", "drive", "ohm", "winding resistance of one of the two motors", 1e-3, 100.0
)
VELOCITY_CONSTANT = Parameter(
    "velocity_constant", "drive", "V s/rad", "voltage a motor needs for each rad/s", 1e-3, 10.0
)

ACTIVE_DAMPING = Parameter("b_ad", "controller", "kg/m", "active damping for each m/s of the foot downwards", 0.0, 1e5)

GROUND_LOSS = Energy("ground_loss", "energy lost to the ground", -1, "lost to the ground")
IMPACT_LOSS = Energy("impact_loss", "energy lost at impacts", -1, "lost at impacts", sudden=True)
