"""The search for a better K, D and time step, in low-priority threads. No panel import."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.explanation import Explanation
from vibroscope.app.explorer.field_units import held_in_words, shown_content, shown_field, words_of_change
from vibroscope.app.explorer.method_words import name_of_method, scheme_texts
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.reading import most_steps
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.suggestion_words import contact_words, force_words, range_words, verified_words
from vibroscope.app.explorer.typed import read_typed_number
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.job import Answer
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.runtime.settings import current_settings
from vibroscope.app.runtime.workers import LONG, Workers, lower_priority, pool
from vibroscope.engine import (
    Limits,
    Recommendation,
    SettingQuestion,
    TimeStepping,
    Tolerances,
    percent,
    recommend,
    recommend_schemes,
    rounded,
    steps_at,
    written,
)
from vibroscope.engine.arguments import Poll
from vibroscope.engine.facts import ALL_DIGITS, Amount, Statement, Symbol, equation, joined, sentence, stated
from vibroscope.engine.recommendation.contacts import FORCE_RANGE, RESTITUTION_RANGE
from vibroscope.engine.recommendation.question import STEPS_MAX_RANGE, STIFFNESS_MAX_RANGE, largest_stiffness
from vibroscope.engine.recommendation.trials import Trial

_THREADS = 2  # searches that run at the same time, of all sessions
_PERCENT = (0.01, 100.0)  # range of a tolerance
_OFF = "off"  # a tolerance that is not asked for
_ETAS = 5  # of a range, at which settings are tried; between them what is found is tried, too
_OFFERED = (0.05, 0.1, 0.2, 0.5, 1.0)  # tolerances; the smallest one that can be met is offered
_ABOVE = 1.2  # times the part of the joint damping, which no K, D or step removes
_FRONT_POINTS = 10  # shown, at most
CACHE = Cache(32)  # results by their question


class Question(NamedTuple):
    """Everything that a search depends on: not K, D and Δτ, which it looks for, unless one of them is held."""

    search: SettingQuestion
    schemes: tuple[TimeStepping, ...] = ()  # all that is searched over where a code is asked for, in place of that set

    def follow(self, setting: Setting) -> "Question":
        """The question for another setting, with the same tolerance, limits and range."""
        etas = self.search.etas if self.search.is_range else setting.eta
        asked = replace(self.search, system=setting.system, etas=etas, reference=setting.reference)
        return Question(asked if self.schemes else replace(asked, scheme=_scheme(setting)), self.schemes)


class SoFar(NamedTuple):
    """What a search has found before its end: settings that no other one beats, cheapest first."""

    question: SettingQuestion
    front: list[Trial]
    eta: float = math.nan  # to which the steps per period of the settings belong

    @property
    def tolerance(self) -> float:
        """That of the displacements."""
        return self.question.tolerances.displacement


@dataclass(frozen=True)
class OfSchemes(Recommendation):
    """The best of several recommendations; ``others`` are those of the other integrators, best first."""

    others: tuple[Recommendation, ...] = ()


def default_limits(setting: Setting) -> dict[str, str]:
    """Limits and tolerances of a search, as texts; the unit of K, and name and unit of a range of η.

    They are the command line's, if this server allows them.
    """
    field, eta = shown_field("K", setting), shown_field("eta", setting)
    steps = print_number(min(Limits().steps_max, most_steps()))
    tolerances = {"restitution": print_number(Tolerances.restitution), "force": print_number(100 * Tolerances.force)}
    shown = tolerances | {
        "unit": field.unit or field.natural,
        "eta": f"Range of frequency {eta.label}",
        "eta_unit": eta.unit,
    }
    return {"K": field.number(largest_stiffness(setting.system)), "steps": steps, **shown}


def make_question(setting: Setting, typed: object, schemes: tuple[TimeStepping, ...] = ()) -> Question:
    """The question for a setting.

    Parameters
    ----------
    setting : Setting
    typed : mapping of str to str
        ``tolerance`` in per cent, and the limits of the search ``K`` and ``steps`` by `default_limits`, as typed; the
        ends ``from`` and ``to`` of a range of η, or neither; in ``hold`` which of K and D keep their present value; and
        the tolerances ``restitution`` and ``force``, that in per cent, or "off".
    schemes : tuple of TimeStepping
        What a code has, to search over in place of what is set.

    Raises
    ------
    Refused
        If one of them is none, or if the page could not be set to what the search may find.
    """
    if not setting.is_driven:
        raise Refused("eta", "Nothing drives the bodies: a search needs a motion that lasts. Give the base or a body "
                      "an amplitude, under System.")  # fmt: skip
    usual = default_limits(setting)
    asked = usual | dict(typed if isinstance(typed, Mapping) else {})
    percent = {"units": {"": 1.0, "%": 1.0}, "shown": "%"}
    tolerance = float(read_typed_number("tolerance", asked.get("tolerance"), _PERCENT, **percent)) / 100
    field = shown_field("K", setting)
    K_options = {"units": field.typed, "shown": field.unit}
    stiffness_max = float(read_typed_number("K allowed", asked["K"], STIFFNESS_MAX_RANGE, **K_options))
    if asked["K"] == usual["K"]:  # the text is rounded where units are shown, and the search would try other K
        stiffness_max = largest_stiffness(setting.system)
    steps_range = (STEPS_MAX_RANGE[0], min(STEPS_MAX_RANGE[1], most_steps()))
    steps_max = int(read_typed_number("T/Δτ allowed", asked["steps"], steps_range, whole=True))
    held = str(asked.get("hold", ""))
    if "D" in held and setting.follows_restitution:
        raise Refused("D", "D follows from the restitution, and cannot be held: choose “D as typed” under Solver.")
    if "K" in held and setting.follows_step:
        raise Refused("K", "K follows from the time step, and cannot be held: choose “K as typed” under Solver.")
    restitution_tolerance = _read_tolerance("restitution", asked["restitution"], RESTITUTION_RANGE)
    shares = tuple(100 * end for end in FORCE_RANGE)
    force_tolerance = _read_tolerance("peak force", asked["force"], shares, **percent)
    etas = _read_etas(setting, asked.get("from", ""), asked.get("to", ""))
    if schemes and len(etas) > 1:
        raise Refused("eta", "What a code has is searched at one frequency: leave the ends of the range empty.")
    force_tolerance = None if force_tolerance is None else force_tolerance / 100
    K, D = (getattr(setting, name) if name in held else None for name in "KD")
    asked = SettingQuestion(
        setting.system,
        etas,
        Tolerances(tolerance, restitution_tolerance, force_tolerance),
        Limits(stiffness_max, steps_max, K, D),
        schemes[0] if schemes else _scheme(setting),
        setting.reference,
    )
    return Question(asked, schemes)


def _scheme(setting: Setting) -> TimeStepping:
    """What the settings are tried with; its K, D and n have no effect."""
    return replace(setting.penalty, every_step=False)


def _read_tolerance(name: str, text: object, allowed: tuple[float, float], **options) -> float | None:
    """A tolerance as typed; None where it is switched off."""
    if str(text).strip().lower() == _OFF:
        return None
    try:
        return float(read_typed_number(f"{name} tolerance", text, allowed, **options))
    except Refused as error:
        raise Refused(error.name, f"{error} Or type “{_OFF}”.") from None


def _read_etas(setting: Setting, first: object, last: object) -> tuple[float, ...]:
    """The η of a range whose ends were typed, or that of the setting where neither was."""
    if first == last == "":
        return (setting.eta,)
    field = shown_field("eta", setting)
    options = {"units": field.typed, "shown": field.unit}
    low, high = (
        float(read_typed_number(f"{field.label} {name}", text, FIELDS["eta"].bounds, **options))
        for name, text in (("from", first), ("to", last))
    )
    if not low < high:
        raise Refused("eta", f"{field.label} from must be less than {field.label} to: give the ends of a range.")
    return tuple(float(f"{low + (high - low) * i / (_ETAS - 1):.6g}") for i in range(_ETAS))


def search_threads() -> Workers:
    """The threads of all searches; threads that a search starts inherit their low priority."""
    return pool("suggestion", _THREADS, lower_priority, margin=LONG)


def begin_search(question: Question, deliver: Callable[[Answer, object], None]) -> Answer:
    """Search; a worker thread calls ``deliver`` with its share and a `SoFar`, again and again, then with the result."""
    return Answer(question, _recommend, deliver, search_threads(), "suggestion")


def _recommend(question: Question, cancelled: Poll, report: Callable[[tuple[float, SoFar]], None]) -> Recommendation:
    found = CACHE.get(question)
    if found is not None:
        return found
    asked, schemes = question
    so_far = SoFar(asked, [])

    def keep(front: list[Trial], eta: float) -> None:
        nonlocal so_far
        so_far = SoFar(asked, front, eta)

    how = {
        "threads": current_settings().threads,
        "progress": lambda share: report((share, so_far)),
        "cancelled": cancelled,
    }
    if schemes:
        best, *others = recommend_schemes(asked, schemes, **how)
        found = OfSchemes(**vars(best), others=tuple(others))
    else:
        found = recommend(asked, **how, partial=keep)
    CACHE.put(question, found)
    return found


def trial_texts(trial: Trial, found: Recommendation | SoFar, setting: Setting) -> dict[str, str]:
    """K, D and n of a trial as texts for the controls; one Δτ for a range gives n at the η of the setting."""
    K, D, steps = trial.setting
    if found.question.is_range:
        steps = steps_at(setting.eta, found.eta, steps)
    own = {"located": "no", **scheme_texts(found.scheme)} if isinstance(found, OfSchemes) else {}
    return own | {"K": print_number(K), "D": print_number(D), "steps": print_number(steps)}


def suggestion_content(found: Recommendation, setting: Setting) -> dict:
    """The content of the page for a result, in the units of the setting.

    Returns
    -------
    dict
        ``met`` (bool), ``head`` (str), ``lines`` (list of str), ``use`` (texts of the best setting found, empty if
        there is none), ``possible`` (the least tolerance that it meets, as a text), ``tolerance`` (share), and
        ``front``: lists of steps, error, texts of a setting, the error as a text, and K and D in words, at most
        ten. The page takes each of these settings, since `make_question` has limited the search to those that it takes.
    """
    best, setting = found.best, in_law_of(found, setting)
    return {
        "met": found.met,
        "head": _head(found),
        "lines": shown_content(_lines(found, setting), setting.scale)
        + _held_lines(found, setting)
        + _start_lines(setting),
        "use": trial_texts(best, found, setting) if best is not None else {},
        "possible": percent(found.possible) if best is not None else "",
        "tolerance": found.tolerance,
        "front": [_point(trial, found, setting) for trial in _thin_front(found.front, best)],
    }


def _held_lines(found: Recommendation, setting: Setting) -> list[str]:
    """What of the base keeps its amplitude over a range of frequencies."""
    held = held_in_words(setting) if found.question.is_range else ""
    return [f"Over the range, {held} is held."] if held else []


def in_law_of(found: Recommendation, setting: Setting) -> Setting:
    """The setting with the contact law of a result, which says in which units its K and D are."""
    scheme = found.scheme
    return setting._replace(law=scheme.law, exponent=scheme.exponent)


def partial_content(so_far: SoFar, setting: Setting) -> dict:
    """The content of the page while a search goes on: ``lines``, ``tolerance``, ``front`` of `suggestion_content`."""
    tolerance, front, eta = so_far.tolerance, so_far.front, so_far.eta
    if not front:
        return {}
    met = next((trial for trial in front if trial.robust <= tolerance), None)
    at = stated(" at {} and more below", equation("η", eta)) if so_far.question.is_range else ""
    end = "; fewer steps may do." if met else "."
    line = stated("So far: {}{}", _trial_words(met or front[-1], tolerance, at), end)
    return {
        "lines": shown_content([line], setting.scale),
        "tolerance": tolerance,
        "use": {},
        "front": [_point(trial, so_far, setting) for trial in _thin_front(front, met)],
    }


def _trial_words(trial: Trial, tolerance: float, at: str | Statement = "") -> Statement:
    error = percent(trial.error, beside=tolerance)
    return stated("{}, T/Δτ = {} steps a period{}: error {}", _contact(trial), f"{trial.setting.steps:,}", at, error)


def _contact(trial: Trial) -> Statement:
    """K and D of a trial, with all their digits."""
    stiffness, damping, _ = trial.setting
    return stated("{}, {}", equation("K", stiffness, ALL_DIGITS), equation("D", damping, ALL_DIGITS))


def _point(trial: Trial, found: Recommendation | SoFar, setting: Setting) -> list:
    texts = trial_texts(trial, found, setting)
    words = words_of_change({name: texts[name] for name in "KD"}, setting)
    return [trial.setting.steps, trial.error, texts, percent(trial.error, beside=found.tolerance), words]


def offered_tolerance(explanation: Explanation) -> str:
    """A tolerance in per cent, as a text, that no joint damping stands in the way of."""
    floor = explanation.parts.get("joint_damping", 0.0)
    return rounded(100 * next((share for share in _OFFERED if share >= _ABOVE * floor), _OFFERED[-1]), 2)


def _head(found: Recommendation) -> str:
    asked = percent(found.tolerance) + (" over the range" if found.question.is_range else "")
    if found.met:
        return f"An error of {asked} is met" + (", by another kind of motion" if found.kind else "")
    if found.best is None:
        return "Nothing to suggest here"
    if found.best.robust <= found.tolerance:
        return f"An error of {asked} is met, but not what else is asked for"
    return f"An error of {asked} is not met; {percent(found.possible, beside=found.tolerance)} is possible"


def _lines(found: Recommendation, setting: Setting) -> list[str | Statement]:
    of = f"{name_of_method(found.scheme)}: " if isinstance(found, OfSchemes) else ""
    if found.best is None:
        return [sentence(of + found.reason), *(_other_lines(found) if of else [])]
    if found.question.is_range:
        return _range_lines(found, setting)
    best, robust = found.best, percent(found.best.robust, beside=found.tolerance)
    trial = _trial_words(best, found.tolerance)
    result = of + trial + f"; nine in ten neighbouring settings have at most {robust}."
    if found.question.located:
        result += f" It costs {best.cost:.0f} solves per period, since steps are cut where contact changes."
    lines = [result] if found.met else ["Best found: " + result, sentence(found.reason)]
    if found.kind:
        lines.append(stated("Mind: another kind of motion: {}.", found.kind))
    if found.compensated:
        part = percent(found.joint_damping)
        lines.append(f"Note: the joint damping alone causes {part}; errors cancel here, and may not at another η.")
    elif 1e-4 <= found.joint_damping <= found.tolerance:  # a larger one is the reason, nan means that there is none
        lines.append(f"The joint damping alone causes {percent(found.joint_damping)} of it.")
    return [*lines, *_contact_lines(found, setting), *_other_lines(found)]


def _contact_lines(found: Recommendation, setting: Setting) -> list[str | Statement]:
    """The ranges, the contacts, and what was verified, a sentence each."""
    scale = setting.scale
    force = written if scale is None else lambda value: scale.text("force", value)
    ranges, contacts = range_words(found), contact_words(found)
    lines = [stated("Met where one number alone is changed: {}.", ranges)] if ranges else []
    lines += [f"Contacts: {contacts}."] if contacts else []
    lines.append(f"Peak force: {force_words(found, force)}.")
    other = (
        ""
        if found.question.located or isinstance(found, OfSchemes)
        else (" For another code choose it under Your code: with another contact status a step may have no solution.")
    )
    return [*lines, f"Verified for {verified_words(found)}.{other}"]


def _other_lines(found: Recommendation) -> list[Statement]:
    """The steps that the other integrators of a code would need, in words."""
    lines = []
    for other in found.others if isinstance(found, OfSchemes) else ():
        name = name_of_method(other.scheme)
        if other.best is None:
            lines.append(stated("{}: {}.", name, other.reason))
        else:
            met = "" if other.met else "not met: "
            trial = _trial_words(other.best, other.tolerance)
            lines.append(stated("{}: {}{}, {} solves.", name, met, trial, f"{other.solves:.0f}"))
    return lines


def _range_lines(found: Recommendation, setting: Setting) -> list[str | Statement]:
    best = found.best
    error, robust = (percent(value, beside=found.tolerance) for value in (best.error, best.robust))
    result = stated(
        "{}, {} = {}, which is {} steps a period at {} and more below: error at most {}; nine in ten neighbouring "
        "settings have at most {}.",
        _contact(best),
        Symbol("Δτ"),
        Amount(found.time_step, "time"),
        f"{best.setting.steps:,}",
        equation("η", found.eta),
        error,
        robust,
    )
    lines = [result if found.met else "Best found: " + result, sentence(found.limit)]
    if not found.met:
        lines.append(sentence(found.reason))
    if found.kind:
        lines.append(stated("Mind: another kind of motion: {}.", found.kind))
    if found.left_out:
        etas = joined(", ", (equation("η", eta) for eta in found.left_out))
        lines.append(
            stated("Left out, since the reference does not repeat itself, or nothing touches there: {}.", etas)
        )
    errors = (
        stated("{} at {}", percent(one.error, beside=found.tolerance), equation("η", one.eta)) for one in found.served
    )
    return [*lines, stated("Error: {}.", joined(", ", errors)), *_contact_lines(found, setting)]


def _start_lines(setting: Setting) -> list[str]:
    return ["Mind: the search runs from rest, not from the own start."] if not setting.from_rest else []


def _thin_front(front: tuple, best) -> list:
    """At most `_FRONT_POINTS` points, evenly spread, the best among them."""
    if len(front) <= _FRONT_POINTS:
        return list(front)
    wanted = {round(i * (len(front) - 1) / (_FRONT_POINTS - 2)) for i in range(_FRONT_POINTS - 1)}
    return [trial for i, trial in enumerate(front) if i in wanted or trial is best]
