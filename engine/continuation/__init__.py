"""Branches of periodic motions over a number of the problem, with their bifurcations.

``search`` is the way in and looks for branches, ``follow`` follows one; ``curve`` solves the equations of orbits with
one sequence of events (:mod:`..drivers.orbit`), ``orbit`` says where it holds, ``sequences`` what follows where it does
not. ``point_curve`` follows a point in two numbers; ``points`` has a problem for each kind. Both are curves for the
``tracer``.
"""
