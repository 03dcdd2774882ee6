"""The problems of the hard cases: groups of generators that yield (name, Problem[, further entries of hard.json]).

SYSTEM_GROUPS are those of the general systems, STOP_GROUPS those of free bodies, two stops, pulses and records.
"""

from hard_cases.contacts import chatter, limits, starts, stiffness
from hard_cases.frequencies import close_frequencies, from_rest, resonance, undamped
from hard_cases.grazes import grazing, grazing_force
from hard_cases.stops_and_loads import GROUPS as STOP_GROUPS
from hard_cases.systems import SYSTEM_GROUPS

__all__ = ["GROUPS", "STOP_GROUPS", "SYSTEM_GROUPS"]
GROUPS = (from_rest, chatter, resonance, stiffness, grazing, grazing_force, limits, close_frequencies, undamped, starts)
