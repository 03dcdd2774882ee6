"""The explorer: a Panel page and a command line over the engine's public names.

Data runs one way: `explorer.reading` (texts) → `explorer.state` (the setting) → `explorer.compute` (both solvers) →
`explorer.present` (column arrays) → the figures of a tab in `page`, changed in place. `page.session` wires one browser
session, `server` serves it.
"""

_KNOBS = "its stiffness K, its damping D or the time step"
QUESTION = f"Is the motion that a penalty contact shows real, or an artefact of {_KNOBS}?"
