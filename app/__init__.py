"""The explorer: a Panel page over the engine's public names.

Data runs one way: ``state`` (what is set) → ``compute`` (both solvers) →
``present`` (column arrays) → ``views`` (figures written in place); ``session``
wires one browser session, ``main`` serves it.
"""
