"""A run under a load that is no harmonic, in words: for the page and the command line. No panel import."""

import math

from vibroscope.engine import PART_NAMES, Difference, Load, Transient, counted, percent, written
from vibroscope.engine.divergence.encounters import mean_closing_speed
from vibroscope.engine.facts import Amount, Statement, joined, stated
from vibroscope.engine.load import ON, quantity_of
from vibroscope.engine.one_impact.of_system import contact_alone

_AS_GIVEN = 7  # digits of what was typed, so that its text in units is that

_SEEN = 0.02  # of a load that steps may miss without a word


def words_of_load(load: Load, end: float) -> Statement:
    """What it is, its peak and its end; ``end``: that of the run."""
    return stated(
        "{} of the {}, peak {}; it ends at {}, the run at {}",
        load.words,
        ON[load.on],
        *(
            Amount(value, kind, _AS_GIVEN)
            for value, kind in ((load.peak, quantity_of(load.on)), (load.end, "time"), (end, "time"))
        ),
    )


def words_of_run(run: Transient) -> Statement:
    """Contacts, and what is left of the motion."""
    response, system = run.response, run.response.system
    counts = f"{counted(len(response.impacts), 'impact')}, {counted(len(response.contacts), 'contact')}"
    kind, words = ("displacement", "amplitude") if system.spring1 else ("velocity", "speed")
    left = [
        stated("body {} {}", str(body), Amount(value, kind))
        for body, value in enumerate(run.residual[: 1 if system.wall else 2], 1)
    ]
    state, missed = "in contact" if run.in_contact else "apart", run.load_missed
    note = f"; its steps miss {percent(missed)} of the load: take shorter ones" if missed > _SEEN else ""
    return stated(
        "{}; at the end the bodies are {}, with the free vibration ({}) {}{}",
        *(counts, state, words, joined(", ", left), note),
    )


def words_of_difference(found: Difference) -> str:
    """Its size and its parts."""
    parts = ", ".join(f"{PART_NAMES[name]} {percent(value)}" for name, value in found.parts.items())
    return f"{percent(found.total)} of the reference (rms of the displacements over the run): {parts}"


def words_of_peak_force(penalty: Transient, exact: Transient) -> Statement | str:
    """How the time step changes the largest contact force and acceleration; empty where nothing touches.

    ``exact``: the same K and D without a time step.
    """
    found, true = penalty.peaks, exact.peaks
    if not max(found["contact_force"], true["contact_force"]) > 0.0:
        return ""
    names = {"contact_force": "force", "acceleration1": "acceleration"}
    values = [Amount(each[name], quantity) for name, quantity in names.items() for each in (found, true)]
    return stated("{}, without a time step {}; largest acceleration of body 1 {}, without {}", *values)


def words_of_contact(reference: Transient, penalty: Transient) -> str:
    """What K and D give of the restitution that is asked for; empty where nothing collides, or without a step."""
    run, speed = penalty.response, mean_closing_speed(reference.response)
    if math.isnan(speed) or not run.method.has_step:
        return ""
    alone = contact_alone(run.system, run.eta, run.method, speed)
    if alone is None:
        return ""
    return f"alone it has a restitution of {alone.words}; e = {written(run.system.restitution)} is asked for"
