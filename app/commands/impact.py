"""``vibroscope impact``: what a contact alone gives with a law, an integrator, a contact status and a step."""

import argparse
import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, NamedTuple

from vibroscope.app.commands.codes import code_alone
from vibroscope.app.commands.numbers import SI, measured, number, share
from vibroscope.app.commands.options import (
    OTHER_ETA,
    SCHEME_OPTIONS,
    add_fields,
    add_initial_option,
    law_of,
    missing_words,
    stepping_of,
    system_file,
)
from vibroscope.app.commands.parser import Command, OneLineParser, entries, option
from vibroscope.app.commands.report import Report, Row, note
from vibroscope.app.explorer.parameters import LAW_WORDS
from vibroscope.engine import percent, written
from vibroscope.engine.law_table import HERTZ
from vibroscope.engine.one_impact.choose import CLOSE_TO_ASKED
from vibroscope.engine.one_impact.question import NO_STEPS

if TYPE_CHECKING:
    import numpy as np
    from vibroscope.engine import Impact, MoreauJean, TimeStepping, WithStep

OVER = {"steps-per-contact": (0.5, 100.0), "speed": (0.1, 10.0), "time": ()}  # from where to where; speed: times this
VALUES = 100  # of a band
_UNITS = {"penetration": "_m", "force": "_N", "time": "_s", "time_step": "_s", "mass": "_kg", "speed": "_m_per_s"}
SHARES = ("without_solution", "two_solutions", "blown_up", "stuck")
_SPANS = ("restitution", "penetration", "force", "steps")
BAND = ("restitution_least", "restitution_mean", "restitution_greatest", "penetration_m", "force_N", *SHARES)
_EXAMPLES = """\
examples:
  vibroscope impact --mass '1 kg' --speed '1 m/s' --K '1e6 N/m' --restitution 0.5 --steps-per-contact 5
  vibroscope impact --mass '0.2 kg' --speed '2 m/s' --K '5e5 N/m' --D '40 N s/m' --time-step '0.1 ms' --status end
  vibroscope impact --mass '20 g' --permitted-penetration '0.1 mm' --restitution 0.7 --steps-per-contact 20 --bounds
  vibroscope impact --materials steel,pla --radius '10 mm' --law hunt-crossley --restitution 0.7
  vibroscope impact --system my.toml --eta 1.2 --K '1e5 N/m' --restitution 0.6 --time-step '1 ms'
  vibroscope impact --moreau-jean 0.5 --restitution 0.5 --time-step '1 ms' --speed '2 m/s'
  vibroscope impact --code mujoco --K '1e5 N/m' --D '50 N s/m' --time-step '2 ms'
  vibroscope impact --K 1e6 --restitution 0.5 --integrator hht --over steps-per-contact=0.5:100 > band.csv
  vibroscope impact --K 1e6 --restitution 0.5 --steps-per-contact 5 --over time > force.csv
"""


def add(command: OneLineParser) -> None:
    """Add the options."""
    add = command.add_argument
    add(
        "--mass", type=measured("mass"), metavar="F", help="reduced mass, as '2 kg' (default 1 kg, or that of --system)"
    )
    met = command.add_mutually_exclusive_group()
    met.add_argument("--speed", type=measured("velocity"), metavar="F", help="closing speed (default 1 m/s)")
    words = "in place of the speed: those of all impacts in the reference of a system in physical units"
    met.add_argument("--system", dest="moving", type=system_file, metavar="FILE.toml", help=words)
    add("--eta", type=number, metavar="F", help="with --system: at this eta, in place of the frequency of the file")
    add_initial_option(command, more=", with --system; numbers without a unit are in m and m/s")
    spring = command.add_mutually_exclusive_group(required=True)
    help_k = "contact stiffness, as '1e6 N/m'; all numbers without a unit are in SI units"
    spring.add_argument("--K", type=measured("contact_stiffness"), metavar="F", help=help_k)
    words = "in place of K: the penetration that is permitted, as '0.1 mm', without a step and with the restitution"
    spring.add_argument("--permitted-penetration", type=measured("displacement"), metavar="F", help=words)
    words = "in place of K: the force that is permitted, as '2 kN', likewise"
    spring.add_argument("--permitted-force", type=measured("force"), metavar="F", help=words)
    words = "in place of K: Hertz' stiffness of two materials, as steel,pla, with --radius and a law of exponent 1.5"
    spring.add_argument("--materials", metavar="A,B", help=words)
    words = "of the surface of the first material, as '10 mm'; of the second in --radius2 (default: it is plane)"
    add("--radius", type=measured("displacement"), metavar="F", help=words)
    add("--radius2", type=measured("displacement"), default=math.inf, metavar="F", help="see --radius")
    words = (
        "in place of K: no spring, but Newton's impact law in the steps of Moreau and Jean with this theta, 0.5 to 1"
    )
    spring.add_argument("--moreau-jean", type=number, metavar="THETA", help=words)
    damper = command.add_mutually_exclusive_group()
    help_d = "contact damper, as '40 N s/m'; without a unit its half, as everywhere: the force is 2D times the speed"
    damper.add_argument("--D", type=measured("contact_damping"), metavar="F", help=help_d)
    words = "in place of D: what the contact alone is to give without a step, exactly and whatever the law's authors "
    words += "have as its damper (default with --system: that of the file)"
    damper.add_argument("--restitution", type=share, metavar="F", help=words)
    step = command.add_mutually_exclusive_group()
    step.add_argument("--time-step", type=measured("time"), metavar="F", help="time step, as '0.1 ms'")
    words = "in place of the time step: how many are in a contact, the half cycle of its spring, with the damper if "
    words += "that is linear"
    step.add_argument("--steps-per-contact", type=number, metavar="F", help=words)
    words = "constant force that presses the bodies together, such as a weight (default 0 N)"
    add("--force", type=measured("force"), default=0.0, metavar="F", help=words)
    law, hysteretic = LAW_WORDS
    words = f"{law}. With --restitution its damper is the one with which the contact alone has exactly that, and the "
    words += "answer says what the damper gives that its authors' formula, which compare and simulate take, asks for. "
    add_fields(command, *SCHEME_OPTIONS, law={"help": words + hysteretic})
    words = "with the integrator, the contact status and the law of this code of `vibroscope codes`"
    add("--code", metavar="NAME", help=words)
    words = "how far the restitution may be off for the largest step, as 0.05 or 5 %% (default %(default)s)"
    add("--tolerance", type=share, default=CLOSE_TO_ASKED, metavar="F", help=words)
    words = "also each integrator and contact status with the same numbers, and the steps that it needs, row by row "
    words += "(ten seconds, twice that or more with --force or a small --tolerance)"
    add("--schemes", action="store_true", help=words)
    words = "also from where to where around K and D the step is stable, gains no energy and has a solution"
    add("--bounds", action="store_true", help=words)
    words = "print a band as CSV instead: steps-per-contact=A:B or speed=A:B, in 100 values; or time: the force over "
    words += "time of the touches whose restitution is nearest to and farthest from what was asked, and without a step"
    add("--over", type=_over, metavar="NAME[=A:B]", help=words)
    command.set_defaults(file=SI, steps=NO_STEPS, located=False)


def _over(text: str) -> tuple[str, float, float] | tuple[str]:
    name, given, span = text.partition("=")
    if name not in OVER:
        raise argparse.ArgumentTypeError(f"{name[:40]!r} is neither of {', '.join(OVER)}: give {next(iter(OVER))}=A:B")
    if not given:
        return (name,)
    if not OVER[name]:
        raise argparse.ArgumentTypeError(f"{text[:60]!r}: {name} has no range, give {name} alone")
    low, mark, high = span.partition(":")
    ends = [number(end) for end in (low, high)] if mark else []
    if not ends or not 0 < ends[0] < ends[1] < float("inf"):
        raise argparse.ArgumentTypeError(f"{text[:60]!r} is no range: give {name}=A:B with 0 < A < B")
    return name, *ends


def _method_of(options: argparse.Namespace, damping: float | None) -> "TimeStepping":
    """The method that the options describe, with this D; that of a code if one is named."""
    if options.code is None:
        return stepping_of(options, D=damping)
    method = code_alone(options).method(options.K, damping, options.steps)
    if damping and method.damping is None:
        raise ValueError(f"--D: {options.code} takes its damper from the restitution: give --restitution in its place")
    return method


def question_of(options: argparse.Namespace) -> "Impact":
    """The question that the options describe; of a method without a step where none is given."""
    from vibroscope.engine import Impact, stiffness_for

    by_restitution = options.restitution is not None
    options.K = _stiffness(options)
    method = _method_of(options, 0.0 if by_restitution else options.D)
    numbers = {"speed": options.speed, "mass": options.mass, "force": options.force}
    question = Impact(method.limit, **numbers)
    if by_restitution:
        question = question.with_restitution(options.restitution)
        question = stiffness_for(question, **permitted) if (permitted := _permitted(options)) else question
        method = replace(method, stiffness=question.method.stiffness, damping=question.method.damping)
    if options.time_step == 0:
        raise ValueError("--time-step 0: give a step above 0, or leave it out for a contact without a step")
    if options.time_step is not None:
        return replace(question, method=method, time_step=options.time_step)
    if options.steps_per_contact is None:
        return question
    if not options.steps_per_contact > 0:
        raise ValueError(f"--steps-per-contact {options.steps_per_contact:g}: give a number above 0")
    return replace(question, method=method, time_step=question.contact_time / options.steps_per_contact)


def _take_restitution(options: argparse.Namespace) -> None:
    """Take the restitution of the system where neither that nor D is given; raises ValueError without a system."""
    if options.D is not None or options.restitution is not None:
        return
    if options.moving is None:
        if options.K is not None:
            _method_of(options, 0.0)  # which names a number out of range first
        raise ValueError("the contact has no damper: give --D or --restitution, or --system with a restitution in it")
    options.restitution = options.moving.system.restitution
    note(f"--restitution is that of --system, {options.restitution:g}")


def _closing_speeds(options: argparse.Namespace) -> "np.ndarray | None":
    """Those of the system's reference in m/s, (n,), the median of which the options then hold; None without one."""
    file = options.moving
    if file is None:
        for name in ("eta", "initial"):
            if getattr(options, name) is not None:
                raise ValueError(f"--{name} says how the bodies of a system meet: give --system, or --speed")
        options.mass, options.speed = (1.0 if each is None else each for each in (options.mass, options.speed))
        return None
    import numpy as np
    from vibroscope.app.studies.one_impact import Run
    from vibroscope.engine import Reference

    if not file.has_units:
        raise ValueError("--system has no units: give it a table [physical] or [units], or give --speed")
    eta, units = file.usual_eta if options.eta is None else options.eta, replace(file.units, system="si")
    if eta is None:
        raise ValueError(missing_words("the command", {"eta": OTHER_ETA}))
    start = options.initial and tuple(map(units.model, ("displacement", "velocity") * 2, options.initial))
    speeds = units.physical("velocity", Run(file.system, eta, Reference(), start).closing_speeds())
    if not len(speeds):
        how = f"at eta = {eta:g}" if file.system.excitation.drives else "that nothing drives"
        raise ValueError(f"in the reference {how} no bodies collide: give --initial, or --speed in place of --system")
    options.mass = units.physical("mass", file.system.mass_share) if options.mass is None else options.mass
    options.speed = float(np.median(speeds))
    return speeds


def _stiffness(options: argparse.Namespace) -> float:
    """K; where it is to follow from what is permitted, one to begin with."""
    if _permitted(options):
        if options.restitution is None:
            raise ValueError("what is permitted gives K for a restitution: give --restitution in place of --D")
        return 1.0
    if options.materials is None:
        return options.K
    from vibroscope.app.codes.catalogue import materials
    from vibroscope.engine import ExactPenalty, hertz_stiffness

    names = options.materials.split(",")
    if len(names) != 2:
        raise ValueError(f"--materials {options.materials[:60]!r}: give two, as steel,pla")
    if options.radius is None:
        raise ValueError("--materials needs --radius: give that of the first surface, as '10 mm'")
    of_code = None if options.code is None else code_alone(options).method(1.0, 0.0, options.steps).limit
    if (of_code or ExactPenalty(1.0, 0.0, **law_of(options))).spring_exponent != HERTZ:
        raise ValueError("--materials gives the K of a force that grows as the 1.5th power: give --law hunt-crossley")
    return hertz_stiffness(*entries("material", names, materials()), options.radius, options.radius2)


def _permitted(options: argparse.Namespace) -> dict[str, float]:
    """The penetration or the force from which K is to follow."""
    given = {"penetration": options.permitted_penetration, "force": options.permitted_force}
    return {name: value for name, value in given.items() if value is not None}


def run(options: argparse.Namespace) -> Report:
    """Solve the contact."""
    _take_restitution(options)
    speeds = _closing_speeds(options)
    if options.moreau_jean is not None:
        return _nonsmooth(options)
    if options.over:
        return Report(_over_lines(options))
    return _report(question_of(options), options, speeds)


def _over_lines(options: argparse.Namespace) -> Iterator[str]:
    """The lines of the CSV."""
    name = options.over[0]
    if options.json:
        raise ValueError("--over prints CSV: leave --json out")
    if options.time_step is None and options.steps_per_contact is None:
        if name != "steps-per-contact":
            raise ValueError(f"--over {name} needs a step: give --time-step or --steps-per-contact")
        options.steps_per_contact = 1.0  # any: each value has its own
    question = question_of(options)
    return _band(question, options) if OVER[name] else _forces(question, options)


def _nonsmooth(options: argparse.Namespace) -> Report:
    """What Newton's impact law gives in steps."""
    from vibroscope.app.explorer.impact_words import span_and_mean
    from vibroscope.engine import MoreauJean, impact

    options.K = None
    given = [name for name in SCHEME_OPTIONS if getattr(options, name, None) is not None]
    given += [
        name for name in ("code", "schemes", "bounds", "over", "steps_per_contact", "D") if getattr(options, name)
    ]
    if given:
        raise ValueError(f"{option(given[0])} goes with a contact spring: leave it out with --moreau-jean")
    if options.time_step is None:
        raise ValueError("--moreau-jean needs a step: give --time-step, as '0.1 ms'")
    numbers = {name: getattr(options, name) for name in ("mass", "speed", "force", "restitution", "time_step")}
    question = MoreauJean(**numbers, theta=options.moreau_jean)
    found = impact(question)
    impulse, moved = found.force * question.time_step, question.speed * question.time_step
    asked = _data(question, *numbers) | {"integrator": question.scheme[0], "theta": question.theta}
    overlap = f"{written(1e3 * found.penetration)} mm, {written(found.penetration / moved, 3)} of a step of flight"
    lines = [
        Row("contact", f"impact law, theta = {question.theta:g}; {_met(question)}; step {_time(question.time_step)}"),
        Row("with this step", f"restitution {span_and_mean(found.restitution)}; impulse {written(impulse)} N s"),
        Row("", f"penetration {overlap}"),
    ]
    return Report(lines, {"asked": asked, "with_step": _with_step(found) | {"impulse_N_s": impulse}})


def _with_step(found: "WithStep") -> dict[str, object]:
    return _data(found, "restitution", "energy_lost", "penetration", "force", "steps", "time", *SHARES, "gained")


def _report(question: "Impact", options: argparse.Namespace, speeds: "np.ndarray | None") -> Report:
    from vibroscope.app.explorer.impact_words import (
        advice,
        answer,
        by_formula,
        counted_as,
        span_and_mean,
        steps_in_contact,
    )
    from vibroscope.engine import impact, largest_step

    alone = question.without_step
    asked = alone.restitution if options.restitution is None else options.restitution
    asked_for = _data(question, "mass", "speed", "force") | {
        "stiffness": question.method.stiffness,
        "damping": 2.0 * question.method.damping,
    }
    asked_for |= {"damping_ratio": question.ratio, "restitution": asked, "law": question.method.law}
    data = {"asked": asked_for, "without_step": _data(alone, *alone._fields)}
    counted = counted_as(question) if question.time_step else ""
    lines = [
        Row("contact", _contact_text(question)),
        *([Row("", counted, 110)] if counted else []),
        Row("without a step", f"restitution {written(alone.restitution)}, {_measures(alone)}, {_time(alone.time)}"),
    ]
    if options.restitution is not None and (of_authors := by_formula(question, asked)):
        lines += [Row("", of_authors, 110)]
    units = SI.units.of_contact(question.method)
    if not question.time_step:
        return Report(lines, data | {"with_step": None, "largest_step": None})
    found, largest = impact(question), largest_step(question, options.tolerance, asked)
    asked_for |= _data(question, "time_step", "steps_per_contact")
    asked_for |= {"integrator": question.method.integrator.name, "status": question.method.status}
    data |= {"with_step": _with_step(found), "largest_step": None}
    if largest is not None:
        data["largest_step"] = {"time_step_s": largest.step, "steps_per_contact": largest.steps_per_contact}
        data["largest_step"] |= {"tolerance": options.tolerance}
    e = span_and_mean(found.restitution)
    if math.isnan(found.restitution.mean):
        lines += [Row("with this step", f"restitution {e}")]
    else:
        lost = span_and_mean(found.energy_lost)
        lines += [Row("with this step", f"restitution {e}; share of the energy lost {lost}")]
        lines += [Row("", f"{_measures(found)}, {steps_in_contact(found)}")]
    said = answer(question, asked, found, by_numbers=options.restitution is None)
    lines += [Row("answer", said, 110), Row("", advice(largest, options.tolerance), 110)]
    for more, rows in (
        _of_motion(question, speeds) if speeds is not None else ({}, []),
        _of_bounds(question) if options.bounds else ({}, []),
    ):
        data |= more
        lines += rows
    if not options.schemes:
        return Report(lines, data, units)

    def table() -> Iterator[dict[str, object]]:
        return _schemes(question, asked, options.tolerance)

    return Report(chain(lines, [""], _table(table())), lambda: data | {"schemes": list(table())}, units)


def _of_motion(question: "Impact", speeds: "np.ndarray") -> tuple[dict[str, object], list[Row]]:
    """What the contact gives at the closing speeds of a motion, (n,), as JSON and as lines."""
    from vibroscope.app.explorer.impact_words import over_speeds_of_motion
    from vibroscope.engine import over_motion

    found = over_motion(question, speeds)
    histogram = zip(found.speed.tolist(), found.count.tolist(), strict=True)
    data = {"speeds": [{"speed_m_per_s": speed, "count": count} for speed, count in histogram]}
    data |= {"speed_m_per_s": _plain(found.speeds)}
    data |= _data(found, *_SPANS, "without_solution", "blown_up", "stuck")
    return {"motion": data}, [Row("motion", over_speeds_of_motion(found), 110)]


def _of_bounds(question: "Impact") -> tuple[dict[str, object], list[Row]]:
    """From where to where around K and D each holds, as JSON and as lines."""
    from vibroscope.engine import damping_bounds, stiffness_bounds

    found = {"stiffness": stiffness_bounds(question)._asdict()}
    if question.method.damping:
        found["damping"] = damping_bounds(question)._asdict()
    data = {name: _ends(bounds, name) for name, bounds in found.items()}
    return {"bounds": data}, list(_bounds_rows(found, question))


def _schemes(question: "Impact", asked: float, tolerance: float) -> Iterator[dict[str, object]]:
    """What each integrator and contact status gives, and the steps in a contact from which on it is close."""
    from vibroscope.app.explorer.impact_words import schemes
    from vibroscope.engine import largest_step

    for one, found in schemes(question, asked):
        name, status = one.scheme
        largest = largest_step(one, tolerance, asked) if status else None
        yield {
            "integrator": name,
            "status": status or None,
            **_data(found, "restitution", "without_solution", "blown_up"),
            "steps_per_contact": largest and largest.steps_per_contact,
        }


def _table(rows: Iterable[dict[str, object]]) -> Iterator[str]:
    heads = f"{'least':>8}{'mean':>8}{'greatest':>10}{'no solution':>13}{'needs steps':>13}"
    yield f"{'integrator':<28}{'status':<10}{heads}"
    for row in rows:
        numbers = "".join(
            f"{'-' if value is None else f'{value:.3f}':>{width}}"
            for value, width in zip(row["restitution"].values(), (8, 8, 10), strict=True)
        )
        none = percent(row["without_solution"]) if row["without_solution"] else "-"
        needs = written(row["steps_per_contact"], 3) if row["steps_per_contact"] else "over 500"
        status, needs = (row["status"], needs) if row["status"] else ("-", "-")  # it has no contact spring
        yield f"{row['integrator']:<28}{status:<10}{numbers}{none:>13}{needs:>13}"


def _bounds_rows(bounds: dict[str, dict], question: "Impact") -> Iterator[Row]:
    """From where to where around K and D each holds."""
    units = SI.units.of_contact(question.method)
    words = {
        "stable": ("stable in contact", "unstable in contact"),
        "no_energy_gained": ("gains no energy", "gains energy here"),
        "solution": ("has a solution", "has none here"),
    }
    for name, found in bounds.items():
        symbol, quantity = ("K", "contact_stiffness") if name == "stiffness" else ("c", "contact_damping")
        texts = []
        for key, ends in found.items():
            if ends is None:
                known = key != "stable" or question.method.linear
                texts += [words[key][1]] if known else []
                continue
            low, high = (units.text(quantity, end).replace("·", " ") for end in ends)
            parts = [f"from {low}"] * (ends[0] > 0) + [f"to {high}"] * (ends[1] < math.inf)
            texts.append(f"{words[key][0]} {' '.join(parts) or 'as far as was looked'}")
        yield Row(f"{symbol}, this step", "; ".join(texts), 110)


def _ends(bounds: dict[str, tuple[float, float] | None], of: str) -> dict[str, dict[str, float | None] | None]:
    """Bounds as JSON, those of D as of the damper: no least or no greatest where none was found."""
    size = 2.0 if of == "damping" else 1.0
    return {
        name: ends and {"least": size * ends[0] or None, "greatest": size * ends[1]} for name, ends in bounds.items()
    }


def _data(found: "NamedTuple | WithStep", *names: str) -> dict[str, object]:
    """Numbers of what was found as JSON, with their units in the keys; of two without names the least and greatest."""
    return {f"{name}{_UNITS.get(name, '')}": _plain(getattr(found, name)) for name in names}


def _plain(value: float | tuple) -> object:
    if not isinstance(value, tuple):
        return value
    return dict(zip(getattr(value, "_fields", ("least", "greatest")), map(_plain, value), strict=True))


def _contact_text(question: "Impact") -> str:
    method, units = question.method, SI.units.of_contact(question.method)
    texts = [units.text("contact_stiffness", method.stiffness)]
    if method.damping is not None:
        ratio = "" if math.isnan(question.ratio) else f", damping ratio {written(question.ratio, 3)}"
        texts.append(f"{units.text('contact_damping', method.damping)}{ratio}")
    numbers = f"K = {texts[0]}" + (f", c = {texts[1]}" if texts[1:] else "")
    text = f"{numbers}; {_met(question)}"
    if not question.time_step:
        return text.replace("·", " ")
    step = f"step {_time(question.time_step)}, {written(question.steps_per_contact, 3)} in a contact"
    return f"{text}; {step}".replace("·", " ")


def _met(question: "Impact | MoreauJean") -> str:
    pressed = f", pressed by {written(question.force)} N" if question.force else ""
    return f"{written(question.mass)} kg at {written(question.speed)} m/s{pressed}"


def _measures(found) -> str:
    return f"penetration {written(1e3 * found.penetration)} mm, force {written(found.force)} N"


def _time(seconds: float) -> str:
    from vibroscope.engine.units import time_text

    return time_text(seconds) if seconds < math.inf else "it does not part"


def _band(question: "Impact", options: argparse.Namespace) -> Iterator[str]:
    """The lines over steps in a contact or the closing speed."""
    import numpy as np
    from vibroscope.engine import over_speeds, over_steps

    name, *ends = options.over
    of_speed = name == "speed"
    low, high = ends or [end * (question.speed if of_speed else 1.0) for end in OVER[name]]
    found = (over_speeds if of_speed else over_steps)(question, np.geomspace(low, high, VALUES))
    yield ",".join([name.replace("-", "_") + ("_m_per_s" if of_speed else ""), *BAND])
    for value, one in found:
        shares = (getattr(one, share) for share in SHARES)
        yield _line(value, *one.restitution, one.penetration, one.force, *shares)


def _forces(question: "Impact", options: argparse.Namespace) -> Iterator[str]:
    """The force over time of the best and the worst touch, and of the contact without a step."""
    from vibroscope.engine import force_courses

    yield "touch,instant,restitution,time_s,force_N"
    for name, course in force_courses(question, options.restitution).items():
        instant = "" if math.isnan(course.instant) else _line(course.instant)
        for row in zip(course.time, course.force, strict=True):
            yield f"{name},{instant},{_line(course.restitution, *row)}"


def _line(*numbers: float) -> str:
    return ",".join(f"{each:.9g}" for each in numbers)


COMMAND = Command(
    "what one contact gives with a law, an integrator, a contact status and a time step",
    "Two bodies meet, and no other force acts: print the restitution, the penetration and the force that the contact "
    "gives without a time step and with it, over all instants of touch within a step, and the largest step for which "
    "the restitution is close to what was asked for.",
    _EXAMPLES,
    add,
    run,
    "one JSON object",
)
