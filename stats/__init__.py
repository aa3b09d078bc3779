"""Arrays in, numbers out: statistics of runs, and jumps and apexes of height logs. No database, no files."""

from stats.anova import Anova, one_way_anova
from stats.apexes import DETECTORS, Detector, PublishedParameters, RobustParameters, find_jumps
from stats.cleaning import CleaningParameters
from stats.energy import BudgetTerm, EnergyBudget, energy_budget, joules_per_jump, joules_per_mah
from stats.flight_window import FlightWindowParameters
from stats.jumps import FLAGS, Jump, Jumps
from stats.parabola import Parabolas, fit_parabolas
from stats.passive_drain import DrainEstimate, PassiveDrain, fit_passive_drain
from stats.published_apexes import smoothing_bias_m
from stats.savings import Savings, percent_savings
from stats.shared_error import SharedSummary, describe_shared
from stats.stance import StanceParameters
from stats.summary import Summary, describe
from stats.two_sample import TwoSample, compare_two

__all__ = [
    "DETECTORS",
    "FLAGS",
    "Anova",
    "BudgetTerm",
    "CleaningParameters",
    "Detector",
    "DrainEstimate",
    "EnergyBudget",
    "FlightWindowParameters",
    "Jump",
    "Jumps",
    "Parabolas",
    "PassiveDrain",
    "PublishedParameters",
    "RobustParameters",
    "Savings",
    "SharedSummary",
    "StanceParameters",
    "Summary",
    "TwoSample",
    "compare_two",
    "describe",
    "describe_shared",
    "energy_budget",
    "find_jumps",
    "fit_parabolas",
    "fit_passive_drain",
    "joules_per_jump",
    "joules_per_mah",
    "one_way_anova",
    "percent_savings",
    "smoothing_bias_m",
]
