"""Odd arguments of every public name: a result, or a ValueError in one clear line; nothing else."""

import contextlib
import inspect
import warnings

import numpy as np
import pytest
import vibroscope.engine as engine
from vibroscope.engine import (
    HHT,
    Cells,
    ExactPenalty,
    Measurement,
    Newmark,
    Record,
    Reference,
    System,
    TimeStepping,
    Units,
    motion,
    simulate,
)

ODD = (
    *(None, "abc", "", b"x", {}, {"a": 1}, object(), 1j, [], [1, 2, 3], ["abc"], [10**400], [[1, 2], [3]], [None]),
    *(float("nan"), float("inf"), -float("inf"), -1, 0, 10**400, -(10**400), 10**5000, True, range(3), len),
    *(np.float64(2.0), np.float32(1.5), np.int64(3), np.bool_(True), np.array(2.0), np.datetime64("2020-01-01")),
    *(np.array([]), np.array([1.0, 2.0]), np.array(["x"]), np.full(4, np.nan), (1, 2, 3, 4)),
)
# What NumPy and Python say of what they cannot convert: no words for a user.
UNCLEAR = ("ambiguous", "could not convert", "inhomogeneous", "broadcast", "string conversion", "unpack", "zero-size")

SYSTEM, NEWMARK, REFERENCE = System(), Newmark(1000, 18, 100), Reference()
AT_THE_END = TimeStepping(1000, 18, 100, status="end")
MOTION = motion(simulate(SYSTEM, 2.76, REFERENCE, periods=20, keep=4))
PROBLEM = {"system": SYSTEM, "eta": 2.76, "method": REFERENCE}
SHORT = {"transient": 2, "sample": 4}
STUDY = engine.EtaStudy(SYSTEM, REFERENCE, values=[2.7, 2.8], **SHORT)
QUESTION = engine.SettingQuestion(SYSTEM, 2.76, limits=engine.Limits(steps_max=8, stiffness=100.0, damping=5.0))
PULSE = engine.Load.half_sine(1.0, 1.0)
MEASURED = Measurement(np.linspace(0, 5, 41), np.ones((2, 41)), None, "absolute")
MEASURED_AT = {"system": SYSTEM, "eta": 2.76, "measurement": MEASURED}


def run_cells(**arguments):
    return engine.run_cells(Cells(**arguments), transient=2, sample=2, threads=1)


def swept(make):
    """The study that is made, given up once it is checked."""
    return lambda **arguments: past_the_border(engine.sweep)(study=make(**arguments))


def past_the_border(function):
    """The function, given up once its arguments are taken: what it computes from them takes long."""

    def call(**arguments):
        with contextlib.suppress(engine.Cancelled):
            function(**arguments, cancelled=lambda: True)

    return call


# Name: what is called, good arguments, and which of them become odd (by default all).
CALLS = {
    "System": (System, SYSTEM.as_dict(), None),
    "Reference": (Reference, {"joint_damping": "table", "threshold": 0.002}, None),
    "ExactPenalty": (ExactPenalty, {"stiffness": 1.0, "damping": 1.0}, None),
    "Newmark": (
        Newmark,
        {"stiffness": 1, "damping": 1, "steps": 100, "every_step": False, "located": False, "law": "kelvin-voigt"},
        None,
    ),
    "TimeStepping": (
        TimeStepping,
        {"stiffness": 1, "damping": 1, "steps": 100, "integrator": HHT(), "status": "end", "without_solution": "keep"},
        None,
    ),
    "HHT": (HHT, {"alpha": -0.1}, None),
    "Units": (Units, {"omega1": 1.0, "m1": 1.0, "base_amplitude": 1.0, "system": "si"}, None),
    "Measurement": (Measurement, vars(MEASURED), None),
    "fit": (past_the_border(engine.fit), MEASURED_AT | {"names": ("restitution",), "method": Reference()}, None),
    "compare_measured": (
        past_the_border(engine.compare_measured),
        MEASURED_AT | {"penalty": NEWMARK, "reference": REFERENCE, "periods": 60, "initial": (0, 0, 0, 0)},
        None,
    ),
    "measured_verdict": (engine.measured_verdict, {}, ("compared",)),
    "synthetic_measurement": (
        engine.synthetic_measurement,
        {"system": SYSTEM, "eta": 2.76, "periods": 1, "per_period": 8, "noise": 0.0, "phase": 0.0, "frame": "absolute"},
        ("system", "eta", "per_period", "noise", "phase", "frame", "seed"),
    ),
    "measurement_text": (engine.measurement_text, {"measurement": MEASURED, "units": Units(), "comment": ""}, None),
    "parse_measurement": (engine.parse_measurement, {"content": b"", "units": None}, None),
    "diagram": (past_the_border(engine.diagram), {"system": SYSTEM, "method": REFERENCE}, None),
    "shipped_diagram": (engine.shipped_diagram, {"system": SYSTEM, "method": REFERENCE}, None),
    "SettingQuestion": (
        engine.SettingQuestion,
        {
            "system": SYSTEM,
            "etas": [2.7, 2.8],
            "tolerances": engine.Tolerances(),
            "limits": engine.Limits(),
            "scheme": NEWMARK,
            "reference": REFERENCE,
        },
        None,
    ),
    "Tolerances": (engine.Tolerances, {"displacement": 0.1, "restitution": 0.1, "force": 0.2}, None),
    "steps_at": (engine.steps_at, {"eta": 2.7, "highest": 2.8, "steps": 100}, None),
    "search_attractors": (
        past_the_border(lambda **given: list(engine.search_attractors(**given))),
        PROBLEM | {"starts": 1, "seed": 0},
        None,
    ),
    "system_text": (engine.system_text, {"system": SYSTEM, "units": None}, None),
    "Record": (lambda **record: simulate(**PROBLEM, periods=4, record=Record(**record)), {"periods": 2}, None),
    "simulate": (simulate, PROBLEM | {"periods": 4, "keep": 2, "initial": (0, 0, 0, 0), "record": None}, None),
    "simulate newmark": (simulate, PROBLEM | {"method": NEWMARK, "periods": 4, "keep": 2}, ("initial", "periods")),
    "Load": (engine.Load.half_sine, {"peak": 1.0, "duration": 1.0, "on": "base"}, None),
    "Load.record": (engine.Load.record, {"time": [0.0, 1.0], "value": [0.0, 1.0], "on": "base"}, None),
    "transient": (
        past_the_border(engine.transient),
        {"system": SYSTEM, "load": PULSE, "method": REFERENCE, "free": 1.0, "initial": (0, 0, 0, 0)},
        None,
    ),
    "transient_difference": (
        past_the_border(engine.transient_difference),
        {"system": SYSTEM, "load": PULSE, "penalty": NEWMARK, "reference": REFERENCE, "free": 1.0},
        None,
    ),
    "shock_response": (
        past_the_border(engine.shock_response),
        {"system": SYSTEM, "load": PULSE, "ratios": [1.0], "method": REFERENCE},
        None,
    ),
    "parse_record": (engine.parse_record, {"content": b"", "units": None, "on": "base"}, None),
    "Cells": (run_cells, {"system": SYSTEM, "eta": [2.7, 2.8], "method": NEWMARK}, None),
    "Cells, each": (
        run_cells,
        {"system": SYSTEM, "eta": [2.7, 2.8], "method": NEWMARK},
        ("stiffness", "damping", "steps", "initial", "chain"),
    ),
    "run_cells": (engine.run_cells, {"cells": Cells(SYSTEM, [2.7], REFERENCE), "threads": 1, **SHORT}, None),
    "compare": (
        engine.compare,
        {"question": engine.ComparisonQuestion(SYSTEM, 2.76, NEWMARK, periods=20, keep=4)},
        ("question", "responses"),
    ),
    "ComparisonQuestion": (
        lambda **given: engine.compare(engine.ComparisonQuestion(**given)),
        {"system": SYSTEM, "eta": 2.76, "penalty": NEWMARK, "periods": 20, "keep": 4},
        ("system", "eta", "penalty", "reference", "keep", "per_period"),
    ),
    "verdict": (engine.verdict, {}, ("comparison",)),
    "equal_restitution_damping": (engine.equal_restitution_damping, {"system": SYSTEM, "stiffness": 100.0}, None),
    "steady": (engine.steady, PROBLEM, ("system", "method", "initial", "record")),
    "motion": (motion, {"subject": SYSTEM, "eta": 2.76, "method": REFERENCE}, ("subject", "method", "initial")),
    "lyapunov": (engine.lyapunov, PROBLEM, ("system", "method", "initial")),
    "attractors": (engine.attractors, PROBLEM | {"starts": 1}, ("system", "method", "seed")),
    "recommend": (engine.recommend, {"question": QUESTION}, ("question",)),
    "design_curve": (engine.design_curve, {"question": QUESTION, "etas": []}, None),
    "repetition": (engine.repetition, {}, ("found",)),
    "difference_in_kind": (engine.difference_in_kind, {"reference": MOTION, "penalty": MOTION}, None),
    "EtaStudy": (
        swept(engine.EtaStudy),
        {"system": SYSTEM, "method": REFERENCE, "values": [2.7, 2.8], **SHORT},
        ("system", "method", "over", "eta", "direction", "coordinates", "lyapunov", "initial", "sample"),
    ),
    "PlaneStudy": (
        swept(engine.PlaneStudy),
        PROBLEM | {"method": NEWMARK, "K": [100.0], "D": [1.0], "parts": False, **SHORT},
        None,
    ),
    "BasinStudy": (
        swept(engine.BasinStudy.over),
        PROBLEM | {"axes": {"xi2": [1.0], "v2": [2.0]}, "start": (0, 0, 0, 0), "phase": 0.0, "sample": 32},
        None,
    ),
    "StepStudy": (swept(engine.StepStudy), PROBLEM | {"method": NEWMARK, "steps": [100], **SHORT}, None),
    "NoSolutionStudy": (
        swept(engine.NoSolutionStudy),
        PROBLEM | {"method": AT_THE_END, "K": [100.0], "steps": [100], **SHORT},
        None,
    ),
    "sweep": (past_the_border(engine.sweep), {"study": STUDY}, None),
    "spaced": (engine.spaced, {"name": "eta", "low": 1.0, "high": 2.0, "count": 3, "logarithmic": False}, None),
    "parse_system": (engine.parse_system, {}, ("content",)),
    "counted": (engine.counted, {"count": 1, "noun": "turn"}, None),
    "many": (engine.many, {"count": 1}, None),
    "percent": (engine.percent, {"fraction": 0.1, "beside": 0.2}, None),
    "rounded": (engine.rounded, {"value": 0.1}, ("value",)),
    "written": (engine.written, {"value": 0.1}, None),
}


def fault(function, arguments, odd):
    """What is wrong with what the call raises; None if it gives a result or refuses in words."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error", RuntimeWarning)
            warnings.simplefilter("ignore", np.exceptions.ComplexWarning)
            function(**arguments)
    except ValueError as error:
        text = str(error)
        if not text or "\n" in text or len(text) > 400 or any(words in text for words in UNCLEAR):
            return f"{odd}: unclear: {text[:80]}"
    except Exception as error:
        return f"{odd}: {type(error).__name__}: {str(error)[:80]}"
    return None


@pytest.mark.parametrize("name", CALLS)
def test_odd_arguments_are_refused_in_words(name):
    function, good, chosen = CALLS[name]
    good = {"digits": 2, **good} if name == "rounded" else good
    found = [fault(function, good | {odd: value}, odd) for odd in (good if chosen is None else chosen) for value in ODD]
    assert not list(filter(None, found))


def test_every_public_function_is_at_the_border():
    for name in engine.__all__:
        value = getattr(engine, name)
        if inspect.isfunction(value):
            assert hasattr(value, "__wrapped__"), name


def test_the_restitution_of_no_stiffness_is_refused():
    for stiffness in (-1, float("nan"), np.array([1.0, -1.0])):
        with pytest.raises(ValueError, match="no contact stiffness"):
            engine.equal_restitution_damping(SYSTEM, stiffness)


def test_numbers_of_numpy_give_the_same_result():
    here = {"values": [2.7, 2.8], **SHORT}
    other = Newmark(np.int64(1000), np.float32(18), np.int32(100), located=np.False_)
    assert engine.EtaStudy(SYSTEM, NEWMARK, **here).key == engine.EtaStudy(SYSTEM, other, **here).key
