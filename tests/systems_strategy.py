"""Systems of every kind for hypothesis: clearance or preload, a wall, base motion, forces, constants."""

from hypothesis import strategies as st
from vibroscope.engine import Excitation, System

amplitudes = st.floats(-2, 2).map(lambda value: round(value, 3))
phases = st.floats(-4, 4).map(lambda value: round(value, 3))
dampings = st.floats(0, 0.2).map(lambda value: round(value, 4))
excitations = st.builds(
    Excitation,
    base=amplitudes,
    base_phase=phases,
    force1=amplitudes,
    force1_phase=phases,
    force2=amplitudes,
    force2_phase=phases,
    constant1=amplitudes,
    constant2=amplitudes,
)
two_bodies = st.builds(
    System,
    kappa=st.floats(0.4, 3).map(lambda value: round(value, 3)),
    mu=st.floats(0.1, 5).map(lambda value: round(value, 3)),
    d1=dampings,
    d2=dampings,
    d3=st.none(),
    restitution=st.floats(0, 0.9),
    clearance=amplitudes,
    excitation=excitations,
)
walls = st.builds(
    System, d1=dampings, restitution=st.floats(0, 0.9), clearance=amplitudes, wall=st.just(True), excitation=excitations
)
general_systems = st.one_of(two_bodies, walls)
