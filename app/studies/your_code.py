"""The motion that a simulation code would show, and the results of its rules of thumb, one by one. No panel import.

The runs of the setting come first, then whether its steps have solutions, then one rule of thumb after the other.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from vibroscope.app.codes.catalogue import Code
from vibroscope.app.codes.rules import AS_SET, EXPLICIT, Rule, RuleOutcome, RuleQuestion, judge, rules
from vibroscope.app.explorer.compute import RunPair, compute_runs, run_length
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine import Response, Status, simulate
from vibroscope.engine.arguments import Poll
from vibroscope.engine.facts import Statement, message_of, sentence, stated

_POINTS = 240  # of a small picture
_CACHE = Cache(24)  # runs of rules, which shall not take the place of those that the page draws


class CodeQuestion(NamedTuple):
    """A setting with default `DRAWING_FIELDS`, and EA/h of the elements in contact in units of k₁, if it is known."""

    setting: Setting
    element_stiffness: float | None = None

    @property
    def asked(self) -> RuleQuestion:
        """The question of a rule."""
        setting = self.setting
        return RuleQuestion(setting.system, setting.eta, setting.penalty, self.element_stiffness)


@dataclass(frozen=True, eq=False)
class Judged:
    """A rule of thumb, what follows, and the phase plot of the observed body: (2, n), empty where there is none."""

    outcome: RuleOutcome
    orbit: np.ndarray


@dataclass(frozen=True, eq=False)
class PartialCode:
    """The results so far.

    Attributes
    ----------
    question : CodeQuestion
    runs : RunPair
        Of the setting.
    solvable : str
        Whether every step has a solution, in a sentence; empty until it is known, or where the status is not iterated.
    judged : tuple of Judged
        The setting itself, then the rules of thumb, as far as they are judged.
    """

    question: CodeQuestion
    runs: RunPair
    solvable: str = ""
    judged: tuple[Judged, ...] = ()

    @property
    def share(self) -> float:
        """The share of the rules that are judged."""
        return len(self.judged) / (1 + len(rules()))

    def data(self) -> dict[str, object]:
        """The results so far, for a file."""
        return {
            "steps_have_solutions": self.solvable,
            "rules": {each.outcome.rule.key: each.outcome.as_dict() for each in self.judged},
        }


def question_of(setting: Setting, element_stiffness: float | None = None) -> CodeQuestion:
    """Everything that the results depend on."""
    return CodeQuestion(setting.drawn_like(Setting()), element_stiffness)


def grow_code(question: CodeQuestion, last: PartialCode | None, cancelled: Poll) -> Iterator[PartialCode]:
    """Partial results, from ``last`` on; raises `Cancelled`."""
    result = last or PartialCode(question, compute_runs(question.setting, cancelled))
    yield result
    if not result.solvable:
        result = replace(result, solvable=_solvable(question.setting, cancelled))
    for rule in (AS_SET, *rules().values())[len(result.judged) :]:
        result = replace(result, judged=(*result.judged, _judge(rule, question, cancelled)))
        yield result


def rule_texts(rule: Rule, question: CodeQuestion) -> dict[str, str]:
    """The numbers that a rule gives, as texts for `read_setting`; raises ValueError where it gives none."""
    method, setting = rule.method(question.asked), question.setting
    given = {name: print_number(method.numbers[name]) for name in rule.gives}
    return setting.with_contact(given)


def code_texts(code: Code) -> dict[str, str]:
    """The texts that choosing a code sets: integrator, status and law. K, D and the step stay; its rules are judged."""
    return {"located": "no", **code.texts()}


def code_lines(code: Code, setting: Setting, contact_area: float | None = None) -> tuple[str, ...]:
    """The input of a code for what is set, in the units that are shown; without units, without dimension."""
    return code.words_for(setting.system, setting.eta, setting.penalty, setting.scale, contact_area)


def _solvable(setting: Setting, cancelled: Poll) -> str | Statement:
    """Whether the steps have solutions: by a run that stops at the first that has none."""
    method = setting.penalty
    if method.located:
        return "Steps are cut where contact changes, so that every step has a solution."
    if method.status != "end":
        return "The contact status is taken from the start of the step, so that every step has a solution."
    how = run_length(setting.system, setting.eta, setting.initial) | {
        "initial": setting.initial,
        "cancelled": cancelled,
    }
    run = simulate(setting.system, setting.eta, replace(method, without_solution="stop"), **how)
    if not run.ok:
        return _first_without_solution(run, method.without_solution)
    return f"Every step of {run.periods:,} periods has a solution."


_HANDLED = {"keep": "the status of the step before is kept", "halve": "such steps are halved"}


def _first_without_solution(run: Response, handled: str) -> Statement:
    """Where and why a step has no solution; what to do where that stops the run, else what becomes of such steps."""
    if run.status is not Status.WITHOUT_SOLUTION or handled not in _HANDLED:
        return sentence(run.message)
    return sentence(stated("{}; {}", run.message.without_advice, _HANDLED[handled]))


def _judge(rule: Rule, question: CodeQuestion, cancelled: Poll) -> Judged:
    asked, setting = question.asked, question.setting
    empty = np.empty((2, 0))
    try:
        with_rule = read_setting(rule_texts(rule, question), setting)
    except Refused as error:  # more than this server computes
        return Judged(RuleOutcome(rule, rule.method(asked), why=str(error)), empty)
    except ValueError as error:
        return Judged(RuleOutcome(rule, None, why=message_of(error) + "."), empty)
    runs = None if rule.kind == EXPLICIT else compute_runs(with_rule, cancelled, _CACHE)
    outcome = judge(
        rule,
        asked,
        reference=setting.reference,
        responses=[run.response for run in (runs.reference, runs.penalty)] if runs else (),
        initial=setting.initial,
        cancelled=cancelled,
    )
    return Judged(outcome, small_orbit(runs.penalty.orbit, setting) if runs else empty)


def small_orbit(orbit, setting: Setting) -> np.ndarray:
    """Displacement and velocity of the observed body in few points: (2, n), empty without an orbit."""
    if orbit is None:
        return np.empty((2, 0))
    row = setting.system.observed_body - 1
    chosen = np.linspace(0, len(orbit.time) - 1, min(_POINTS, len(orbit.time))).astype(int)
    return np.stack([orbit.displacement[row, chosen], orbit.velocity[row, chosen]])
