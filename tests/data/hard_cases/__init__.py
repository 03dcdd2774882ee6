"""The problems of the hard cases: groups of generators that yield (name, Problem[, further entries of hard.json])."""

from .contacts import chatter, limits, starts, stiffness
from .frequencies import close_frequencies, from_rest, resonance, undamped
from .grazes import grazing, grazing_force

GROUPS = (from_rest, chatter, resonance, stiffness, grazing, grazing_force, limits, close_frequencies, undamped, starts)
