"""The problems of the hard cases: groups of generators that yield (name, Problem[, further entries of hard.json]).

SYSTEM_GROUPS are those of the general systems.
"""

from .contacts import chatter, limits, starts, stiffness
from .frequencies import close_frequencies, from_rest, resonance, undamped
from .grazes import grazing, grazing_force
from .systems import SYSTEM_GROUPS

__all__ = ["GROUPS", "SYSTEM_GROUPS"]
GROUPS = (from_rest, chatter, resonance, stiffness, grazing, grazing_force, limits, close_frequencies, undamped, starts)
