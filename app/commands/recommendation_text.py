"""What ``vibroscope recommend`` found, as text and as JSON."""

from collections.abc import Iterator, Sequence

from vibroscope.app.commands.physical_units import settings_text, unit_names
from vibroscope.app.commands.report import Line, Row, record, rows
from vibroscope.app.explorer.method_words import scheme_as_dict
from vibroscope.app.explorer.suggestion_words import contact_words, force_words, range_words, verified_words
from vibroscope.engine import Recommendation, Served, TimeStepping, Units, percent, written
from vibroscope.engine.facts import joined
from vibroscope.engine.one_impact.of_system import alone_as_dict
from vibroscope.engine.recommendation.contacts import Contacts

CONSTANT = "codes with a constant step"
CUT = "codes that cut the step where contact changes"

# --- for scripts ------------------------------------------------------------------------------------------------------


def as_json(found: Recommendation, units: Units | None = None) -> dict:
    """A recommendation as JSON for scripts; None for numbers that do not exist."""
    report = {
        "eta": found.eta,
        **_setting_json(found),
        **record(found.best, "error", "robust"),
        "solves": found.best and found.solves,
        "front": [_front_row(trial) for trial in found.front],
        "front_solves": [trial.cost * found.scheme.stages for trial in found.front],
        **record(found, "met", "joint_damping", "compensated", "kind", "reason"),
    }
    return report | _physical(units, found)


def range_json(found: Recommendation, units: Units | None = None) -> dict:
    """One setting for a range as JSON for scripts; None for numbers that do not exist."""
    report = {
        **_setting_json(found),
        **record(found if found.best else None, "time_step", eta_of_steps="eta"),
        **record(found.best, "error", "robust"),
        "etas": [_served_json(served) for served in found.served],
        "front": [_front_row(trial) for trial in found.front],
        **record(found, "met", "left_out", "limit", "kind", "reason"),
    }
    return report | _physical(units, found)


def _setting_json(found: Recommendation) -> dict:
    """The options of the search, and K, D and n of the best setting."""
    k, d, n = found.best.setting if found.best else (None, None, None)
    tolerances = {"restitution_tolerance": "tolerances.restitution", "force_tolerance": "tolerances.force"}
    ranges = {f"{symbol}_range": found.ranges.get(name) for symbol, name in (("K", "stiffness"), ("D", "damping"))}
    return {
        **record(found, "tolerance", located="question.located", **tolerances),
        **scheme_as_dict(found.scheme),
        **{"K": k, "D": d, "steps": n},
        **ranges,
        **_contacts_json(found.best and found.best.contacts),
        **alone_as_dict(found.alone),
    }


def _contacts_json(contacts: Contacts | None) -> dict:
    """What the contacts of a setting do; None for numbers that do not exist."""
    others = {"peak_force_without_step": "without_step", "steps_per_contact": "steps"}
    return record(contacts, "restitution", "peak_force", **others)


def _served_json(served: Served) -> dict:
    return record(served, "eta", "steps", "error", "robust") | _contacts_json(served.contacts)


def _physical(units: Units | None, found: Recommendation) -> dict:
    """Setting and front in the units of an FE input file."""
    if units is None or not found.best:
        return {}
    contact = units.of_contact(found.method)
    front = [
        [n, error, contact.physical("contact_stiffness", k), contact.physical("contact_damping", d)]
        for n, error, k, d in map(_front_row, found.front)
    ]
    names = unit_names(units, found.method)
    return {"physical": {"units": names, **units.settings(found.eta, found.method), "front": front}}


def _front_row(trial) -> list[float]:
    k, d, n = trial.setting
    return [n, trial.error, k, d]


# --- for people -------------------------------------------------------------------------------------------------------


def lines_of(found: Recommendation, units: Units | None = None) -> Iterator[Line]:
    """A recommendation as text: the setting, its error and cost, and the front."""
    yield from _asked_lines(found, f"eta = {found.eta:g}")
    if found.best is None:
        return
    error, robust = _beside(found, found.best.error), _beside(found, found.best.robust)
    yield f"{_setting_text(found)}, {found.best.setting.steps} steps per period{_cheaper_words(found)}"
    yield Row("error", f"{error}; {robust} is kept to with half the step and by 9 in 10 neighbours")
    yield from _contact_rows(found, units)
    if found.question.located or found.scheme.stages > 1:
        yield Row("cost", f"{found.solves:.1f} solves per period")
    yield from _mind_rows(found, units)
    yield from _front_lines(found, units)


def _mind_rows(found: Recommendation, units: Units | None) -> list[Row]:
    """What is to be kept in mind of a setting, and the setting in units."""
    kind, compensated, physical = "", "", ""
    if found.kind:
        kind = joined("", ("another kind of motion: ", found.kind))
    if found.compensated:
        part = percent(found.joint_damping)
        compensated = f"the joint damping alone makes {part}: errors cancel here, and need not elsewhere"
    if units is not None:
        physical = settings_text(units, found.eta, found.method)
    texts = (("mind", kind), ("mind", compensated), ("physical", physical))
    return [Row(label, text) for label, text in texts if text]


def _contact_rows(found: Recommendation, units: Units | None) -> list[Row]:
    """The ranges, the contacts, and what was verified."""
    force = written if units is None else lambda value: units.text("force", value)
    return rows(
        {
            "range": range_words(found),
            "contacts": contact_words(found),
            "peak force": force_words(found, force),
            "verified for": verified_words(found),
        }
    )


def _asked_lines(found: Recommendation, where: str) -> list[Line]:
    """What was asked, which codes it is for, and why nothing meets the tolerance."""
    lines = [f"{where}, {_kind_of_steps(found)}, tolerance {percent(found.tolerance)}"]
    return [*lines, *rows({"for": for_codes(found.scheme), "not met": "" if found.met else found.reason})]


def _setting_text(found: Recommendation) -> str:
    """K and D of the best setting."""
    k, d, _ = found.best.setting
    return f"{'set' if found.met else 'best found':18s}K = {written(k, 6)}, D = {written(d, 6)}"


def _cheaper_words(found: Recommendation) -> str:
    """That what is shown is not the setting of the least error, where no error found is within the tolerance."""
    least = min(found.front, key=lambda trial: trial.robust, default=found.best)
    if found.met or least.robust <= found.tolerance or least.cost <= found.best.cost:
        return ""
    return ": cheaper than that of the least robust error, and in the search hardly worse"


def _kind_of_steps(found: Recommendation) -> str:
    """The kind of steps that the settings were tried with, in words."""
    steps, scheme = "steps cut at contact changes" if found.question.located else "constant step", found.scheme
    if scheme.is_newmarks:
        return steps if scheme.linear else f"{steps}, law {scheme.law}"
    contact = "" if found.question.located else f" contact at the {scheme.status} of steps,"
    return f"{steps}, {scheme.integrator},{contact} law {scheme.law}"


def range_lines(found: Recommendation, units: Units | None = None) -> Iterator[Line]:
    """One setting for a range as text: the setting, what it does at each eta, what limits it, and the front."""
    yield from _asked_lines(found, "one setting for a range of eta")
    if found.left_out:
        etas = ", ".join(f"{eta:.4g}" for eta in found.left_out)
        yield Row("left out", f"eta = {etas}: the reference does not repeat itself, or nothing touches there")
    if found.best is None:
        return
    steps = f"{found.best.setting.steps} steps per period at eta = {found.eta:g}"
    yield f"{_setting_text(found)}, time step {written(found.time_step)} ({steps})"
    yield Row("limit", found.limit)
    yield from _contact_rows(found, units)
    yield from _mind_rows(found, units)
    yield "eta               steps     error    robust"
    for one in found.served:
        error, robust = _beside(found, one.error), _beside(found, one.robust)
        yield f"{one.eta:<10.6g}{one.steps:13d} {error:>9s} {robust:>9s}"
    yield from _front_lines(found, units)


def _beside(found: Recommendation, error: float) -> str:
    return percent(error, beside=found.tolerance)


def _front_lines(found: Recommendation, units: Units | None) -> list[str]:
    """The front as a table, with spring and damper in units where they are asked for."""
    heads = ["K", "D"]
    units = units and units.of_contact(found.scheme)
    if units is not None:
        names = (units.unit(quantity).replace("·", ".") for quantity in ("contact_stiffness", "contact_damping"))
        heads = [f"{head} / {name}" for head, name in zip(("K", "2D"), names, strict=True)]
    wide = max(9, *map(len, heads))
    lines = ["front             steps  solves     error    robust " + " ".join(f"{head:>{wide}s}" for head in heads)]
    for trial in found.front:
        k, d, n = trial.setting
        if units is not None:
            k, d = units.physical("contact_stiffness", k), units.physical("contact_damping", d)
        error, robust = _beside(found, trial.error), _beside(found, trial.robust)
        lines.append(f"{n:23d} {trial.cost:7.0f} {error:>9s} {robust:>9s} {written(k):>{wide}} {written(d):>{wide}}")
    return lines


def curve_lines(curve: Sequence[Recommendation]) -> Iterator[str]:
    """A design curve as text, one line an η."""
    yield "    eta         K         D   steps  solves     error    robust  met"
    for found in curve:
        if found.best is None:
            yield f"{found.eta:7.4f}  {found.reason.head}"
            continue
        (k, d, n), best = found.best.setting, found.best
        error, robust = _beside(found, best.error), _beside(found, best.robust)
        met = met_words(found) if found.met else f"no: {found.reason.head}"
        numbers = f"{found.eta:7.4f} {written(k, 6):>9} {written(d, 6):>9} {n:7d} {best.cost:7.0f}"
        yield f"{numbers} {error:>9s} {robust:>9s}  {met}"


def met_words(found: Recommendation) -> str:
    """Whether the tolerances are met, for a cell of a table."""
    return ("yes, of another kind" if found.kind else "yes") if found.met else "no"


def for_codes(scheme: TimeStepping) -> str:
    """The codes that a setting is for, by its kind of steps."""
    return CUT if scheme.located else CONSTANT
