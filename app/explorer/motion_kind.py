"""Kind of motion of each run: periodic, quasi-periodic, chaotic, or blurred by the time step. No panel import.

`engine.motion` decides it by further runs, which take from some tenths of a second to some seconds. So the kind comes
after the curves and after the explanation, in a thread of low priority, and is given up after `SECONDS`.
"""

import math
from functools import partial
from typing import NamedTuple

import numpy as np
from vibroscope.app.explorer.state import RunKey, Setting
from vibroscope.app.runtime.cache import Cache
from vibroscope.app.runtime.workers import Workers, lower_priority, own_time, pool
from vibroscope.engine import Cancelled, Kind, Motion, motion, percent
from vibroscope.engine.arguments import Poll
from vibroscope.engine.facts import Statement, joined, message_of, sentence, stated
from vibroscope.engine.motions.poincare_map import is_stable
from vibroscope.engine.motions.time_step_scatter import widths_text

SECONDS = 20.0  # for one motion
KINDS = Cache(200)  # by what the runs depend on
LITTLE = 0.001  # of the energy lost: less of it that the time step creates is not said


class MotionKind(NamedTuple):
    """A kind of motion in words.

    Attributes
    ----------
    kind : Kind
    name : str
    evidence : str or Statement
    """

    kind: Kind
    name: str
    evidence: str | Statement


_NAMES = {
    Kind.QUASI_PERIODIC: "quasi-periodic",
    Kind.CHAOTIC: "chaotic",
    Kind.DIVERGED: "blown up",
    Kind.UNDECIDED: "kind not decided",
}
Kinds = dict[str, MotionKind]  # of "reference" and "penalty"


def kind_threads() -> Workers:
    """The thread that judges motions of single settings, behind everything else."""
    return pool("kind of motion", 1, lower_priority)


def known_kinds(setting: Setting) -> Kinds | None:
    """The kinds of both motions if they are known, else None; nothing is computed."""
    if not setting.is_driven:
        return {}
    found = {name: KINDS.get(key) for name, key in setting.run_keys.items()}
    return None if None in found.values() else found


def judge_motions(setting: Setting, cancelled: Poll) -> Kinds:
    """The kinds of both motions, none of a free vibration; raises `engine.Cancelled` if ``cancelled()``."""
    if not setting.is_driven:
        return {}
    return {name: KINDS.get_or(key, partial(_judge, key, cancelled)) for name, key in setting.run_keys.items()}


def keep_kind(setting: Setting, name: str, found: Motion) -> None:
    """Keep the kind of a motion of "reference" or "penalty" that was judged for another purpose."""
    KINDS.put(setting.run_keys[name], describe_kind(found))


def with_kinds(texts: dict[str, str], kinds: Kinds | None) -> dict[str, str]:
    """The paragraphs of an explanation with the kinds of both motions, as far as they are known."""
    added = {
        name.capitalize(): f" {sentence(kind.name)} {kind.evidence}".rstrip() for name, kind in (kinds or {}).items()
    }
    return {head: text + added.get(head, "") for head, text in texts.items()}


def _judge(key: RunKey, cancelled: Poll) -> MotionKind:
    end = own_time() + SECONDS
    *problem, initial = key
    try:
        return describe_kind(motion(*problem, initial=initial, cancelled=lambda: cancelled() or own_time() > end))
    except ValueError as error:  # the engine does not judge this penalty solution
        why = sentence(message_of(error))
    except Cancelled:
        if cancelled():
            raise
        why = f"{SECONDS:.0f} s of computing did not decide it."
    return MotionKind(Kind.UNDECIDED, _NAMES[Kind.UNDECIDED], why)


def describe_kind(found: Motion) -> MotionKind:
    """The kind of a motion, and its evidence, with what the time step makes of its energy."""
    kind = _kind_of(found)
    energy = _energy(found)
    return kind._replace(evidence=joined(" ", filter(None, (kind.evidence, energy)))) if energy else kind


def _kind_of(found: Motion) -> MotionKind:
    kind = found.type
    if found.step_noise > 0:
        period = _period(found.period)
        return MotionKind(
            Kind.ARTEFACT,
            f"{period}, blurred by the time step",
            stated(
                "The blur is an artefact: it shrinks with the step ({}, over {} periods). Without a time step the "
                "motion has {}.{}",
                widths_text(found.bands),
                str(len(found.section)),
                period,
                _multiplier(found),
            ),
        )
    if kind is Kind.PERIODIC:
        return MotionKind(kind, _period(found.period), _multiplier(found).strip())
    if kind is Kind.CHAOTIC:
        return MotionKind(
            kind,
            _NAMES[kind],
            f"Neighbouring motions separate by a factor of {math.exp(found.lyapunov):.3g} each period "
            f"({_exponent(found)}); this is motion, not blur by the time step.",
        )
    if kind is Kind.QUASI_PERIODIC:
        return MotionKind(
            kind,
            _NAMES[kind],
            f"A second frequency, {found.rotation:.4f} of the excitation's, never fits into it ({_exponent(found)}).",
        )
    return MotionKind(kind, _NAMES[kind], sentence(found.reason))


def _period(period: int) -> str:
    return f"period {period}"


def _multiplier(found: Motion) -> str:
    """The largest Floquet multiplier and the nearest bifurcation; "" if the multipliers are not known."""
    if not len(found.multipliers):
        return ""
    largest = float(np.abs(found.multipliers).max())
    near = f"; nearest bifurcation: {found.bifurcation}, {found.margin:.2g} away" if found.bifurcation else ""
    over = "each period" if found.period == 1 else f"in {found.period} periods"
    if is_stable(found.multipliers):
        return f" A disturbance is multiplied by {largest:.2g} {over} (largest Floquet multiplier{near})."
    return f" A disturbance does not die away (largest Floquet multiplier {largest:.3g}{near})."


def _energy(found: Motion) -> str:
    """How much energy the time step creates or removes; "" without a step, or where that is next to nothing."""
    made, lost = found.energy_created, found.energy_lost
    if not abs(made) >= LITTLE * lost > 0.0:
        return ""
    what = "creates" if made > 0 else "removes"
    return f"The time step {what} {percent(abs(made) / lost)} of the energy that dampers and contact take in a period."


def _exponent(found: Motion) -> str:
    return f"largest Lyapunov exponent {found.lyapunov:+.3g} ± {found.lyapunov_error:.1g} per period"
