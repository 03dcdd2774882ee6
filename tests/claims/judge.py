"""Each claim of a comparison and its verdict, judged by runs of its own: true, misleading or false."""

import math
import re
from typing import NamedTuple

import numpy as np
from vibroscope.engine import (
    Checkpoint,
    ComparisonQuestion,
    Kind,
    Record,
    Reference,
    compare,
    simulate,
    verdict,
    with_located_steps,
)

from tests.claims import runs as own
from tests.claims.runs import Runs, changed, energy_lost, period_of, rebound_alone, undamped_duration
from tests.claims.sentences import Left, apply, changes_in, first, kinds_in, share

TRUE, MISLEADING, FALSE = "true", "misleading", "false"
BETTER, MUCH_BETTER = 1.2, 1.5  # times less than what is named leaves: misleading, and false
NO_MATTER = 0.002  # of the reference: what is less is no difference to anybody
SAME, CLOSE = 0.02, 0.10  # of the agreement's words
REMOVED, HALF, APART = 0.75, 0.5, 0.85  # the definition of blame: of what can be removed; left of all; of the reference
REBOUNDS, RESOLVED = 0.15, 10  # a contact that stands for an impact: restitution within, and steps at least
NOTHING = re.compile("No K(, D)? or time step that was tried|No number alone")
AROUND = (0.91, 0.955, 1.0, 1.05, 1.1)  # neighbours whose median counts, so that luck does not
EXPONENT = 0.005  # per period: a larger Lyapunov exponent is positive …
UNCLEAR, PIECES, MORE_PIECES = 0.1, 200, 4000  # … and one below this is averaged over more periods
SLOW_LAWS = ("hunt-crossley", "flores", "jankowski")  # a contact without a step is integrated
SHRINKS = 0.7  # times as wide with more steps: a band that the time step makes
STEPPED = ("steps", "limit", "status", "integrator")


class Claim(NamedTuple):
    """A claim of one row of the table, and what became of it."""

    row: str
    outcome: str
    text: str


def judge(setting):
    """All claims about a setting, and the verdict."""
    found = compare(ComparisonQuestion(*setting))
    words = verdict(found)
    return judge_words(setting, found, words), words


def judge_words(setting, found, words):
    """All claims of a comparison and a verdict."""
    return [*_Judge(setting, found, words).claims()]


def within(found, wanted, factor, absolute=0.0):
    """Whether two numbers are within a factor of each other, or so near."""
    if abs(found - wanted) <= absolute:
        return True
    return found > 0 and wanted > 0 and max(found / wanted, wanted / found) <= factor


def graded(found, wanted, close, far, absolute=0.0):
    """True within one factor, misleading within another."""
    if within(found, wanted, close, absolute):
        return TRUE
    return MISLEADING if within(found, wanted, far, 2 * absolute) else FALSE


def scaled(method, factor):
    """A method with another K, and the damper that rebounds as before."""
    damping = method.damping and method.damping * math.sqrt(factor)
    return changed(method, stiffness=method.stiffness * factor, damping=damping)


def scatter(values, period):
    """Standard deviation about the points of a cycle."""
    whole = len(values) // period * period
    return float(np.sqrt(np.mean(values[-whole:].reshape(-1, period).var(axis=0))))


class _Judge:
    def __init__(self, setting, found, words):
        self.setting, self.found, self.words = setting, found, words
        run = found.runs.penalty
        sections = found.parts is not None and found.difference.measure != "displacements"
        self.runs = Runs(setting, run.periods, run.keep, sections)
        self.method = setting.method

    def claims(self):
        words = self.words
        if self.found.parts is None:
            return
        if "to judge" in words.headline:
            yield from self.of_changing()
            return
        yield from self.kinds()
        yield from self.contact_facts()
        if words.alone is None:
            yield from self.of_other_ends()
            return
        yield from self.agreement()
        yield from self.leaves()
        yield from self.blame()
        yield from self.blur()

    # --- what is left -------------------------------------------------------------------------------------------------

    @property
    def sections(self):
        return not self.runs.period

    @property
    def chance(self):
        if "_chance" not in vars(self):
            self._chance = self.runs.chance() if self.sections else 0.0
        return self._chance

    def left(self, change):
        method = apply(self.method, change)
        damping = "derived" if change.name == "joint damping" else "table"
        return self.runs.error(method, joint_damping=damping)

    def leaves(self):
        """Every "X leaves p %", repeated as it is printed."""
        said = [("a1", each) for each in changes_in(self.words.headline)]
        details = next((text for text in self.words.details if text.startswith("What is left at best")), "")
        said += [("a6" if each.name in ("status", "steps") else "a5", each) for each in changes_in(details)]
        for row, each in said:
            yield Claim(row, self.repeated(each), f"{each.words}: {each.left:.3g} said, {self.left(each):.3g} found")

    def repeated(self, each):
        found = self.left(each)
        absolute = 0.002 + self.chance
        if within(found, each.left, 1.1, absolute):
            return TRUE
        if not math.isfinite(found):
            return FALSE
        # a motion that does not repeat has another share in each window: where that is seen, two digits are chance
        method = apply(self.method, each)
        damping = "derived" if each.name == "joint damping" else "table"
        others = [found, *(self.runs.error(method, further=i, joint_damping=damping) for i in (2, 4, 6, 8))]
        if min(others) / 1.1 <= each.left <= max(others) * 1.1:
            return TRUE
        return MISLEADING if within(found, each.left, MUCH_BETTER, absolute) else FALSE

    # --- blame --------------------------------------------------------------------------------------------------------

    def blame(self):
        words, total = self.words, self.found.difference.total
        named = [each for each in changes_in(words.headline) if each.name != "several"]
        if "Nothing is to blame" in words.headline:
            yield Claim("c5", TRUE if self.runs.error(self.method) <= 2 * max(self.chance, 1e-3) else FALSE, "chance")
        elif words.together or NOTHING.search(words.headline):
            yield from self.none_alone(total)
        elif words.blame:
            yield from self.single(named, total)

    def single(self, named, total):
        """X is to blame: is another single number better?"""
        least = max(min(map(self.left, named)), self.chance)
        families = {"steps" if each.name in STEPPED else each.name for each in named}
        better = self.best_of_others(families, least / BETTER)
        outcome, text = TRUE, f"{'/'.join(each.words for each in named)} {least:.3g}"
        if better and least > NO_MATTER:
            found = max(better[0], self.chance)
            outcome = FALSE if found <= least / MUCH_BETTER else MISLEADING if found <= least / BETTER else TRUE
            if self.stands_for_impact(self.method) and not self.stands_for_impact(better[2]):
                outcome = TRUE  # errors cancel
            text += f"; {better[1]} {better[0]:.3g}"
        yield Claim("a2", outcome, text)
        for each in named:
            method = apply(self.method, each)
            if f"{each.words} leaves" in self.words.headline and method.law == "kelvin-voigt":
                cancels = bool(re.search(rf"{re.escape(each.words)} leaves [\d.]+ % by errors", self.words.headline))
                if cancels:
                    yield Claim("a9", FALSE if self.stands_for_impact(method) else TRUE, each.words)
        poor = [each for each in named if self.left(each) > APART and self.left(each) > total / 2]
        yield Claim("a7", MISLEADING if poor else TRUE, f"of {total:.3g}")
        if "neither K nor D nor the step mends it" in self.words.headline:
            yield from self.unmended(least)

    def none_alone(self, total):
        """No number alone, as it is said: by the definition of blame one would have to remove three quarters."""
        together = self.words.left if self.words.together else total
        best = self.best_of_others(set(), total)
        alone_left = max(best[0], self.chance) if best else total
        least = max(min(alone_left, together), self.chance)
        enough = min(total - REMOVED * (total - least), HALF * total, APART)
        outcome = FALSE if alone_left <= enough / 1.2 else MISLEADING if alone_left < enough / 1.05 else TRUE
        holds = self.words.together or self.stands_for_impact(self.method)
        if outcome != TRUE and holds and not self.stands_for_impact(best[2]):
            outcome = TRUE  # errors cancel
        yield Claim("a3", outcome, f"{best and best[1]} leaves {alone_left:.3g} of {total:.3g}; least {least:.3g}")
        said = [each.left for each in changes_in(self.words.headline.partition(" at best ")[2])]
        if said:
            outcome = MISLEADING if said[0] > total * 1.02 else FALSE if alone_left < said[0] / MUCH_BETTER else TRUE
            yield Claim("a4", outcome, f"at best {said[0]:.3g}; {best and best[:2]} of {total:.3g}")
        if "that was tried" in self.words.headline:
            yield from self.unmended(HALF * total * MUCH_BETTER)

    def stands_for_impact(self, method):
        """Whether a contact of a method alone rebounds as asked, and has enough steps; by its motion for other laws."""
        wanted = self.setting.system.restitution
        if method.law == "kelvin-voigt":
            rebound = rebound_alone(self.setting.system, method)
            lasting = float(undamped_duration(self.setting.system, method, 1.0))
        else:
            rebound, lasting = self.measured(self.runs.run(method), method)
        steps = lasting * self.setting.eta * (method.steps or math.inf) / (2 * math.pi)
        return abs(rebound - wanted) <= REBOUNDS and (steps >= RESOLVED or method.located)

    def unmended(self, left):
        """No K, D or time step mends it: pairs of K and D without a step."""
        method, found = self.method.limit, []
        for stiffness in np.geomspace(10, 1e6, 11):
            numbers = [{"stiffness": stiffness}]
            if method.damping is not None:
                scale = math.sqrt(stiffness * self.setting.system.mass_share)
                numbers = [{"stiffness": stiffness, "damping": ratio * scale} for ratio in (0.05, 0.2, 0.5, 1.0)]
            found += [changed(method, **each) for each in numbers]
        if method.law in SLOW_LAWS:
            return
        candidates = sorted(found, key=self.scanned)[:2]
        best = min((self.median(lambda f, m=m: scaled(m, f)), str(m)) for m in candidates)
        worst = max(best[0], self.chance)
        outcome = FALSE if worst <= left / 2 else MISLEADING if worst <= left / MUCH_BETTER / 1.05 else TRUE
        yield Claim("a8", outcome, f"{best[1]} leaves {best[0]:.3g} of {left:.3g}")

    def scanned(self, method):
        return self.runs.error(method, short=self.runs.is_slow)

    def median(self, make):
        return float(np.median([self.runs.error(make(factor)) for factor in AROUND]))

    def best_of_others(self, named, below):
        """The least median of the families that are not named, and its words; None if none is below."""
        found = []
        for name, values, make in self.families():
            if name in named or (name in ("limit", "status") and "steps" in named):
                continue
            low = sorted((self.scanned(make(value)), value) for value in values)[:3]
            for left, value in low:
                if left > below:
                    continue
                if name in ("K", "D", "steps"):
                    median = self.median(lambda factor, v=value, make=make: make(v * factor))
                else:
                    median = self.runs.error(make(value))
                text = f"{name} = {value if isinstance(value, str) else format(value, '.4g')}"
                found.append((median, text, make(value)))
        return min(found, default=None, key=lambda each: each[0])

    def families(self):
        method, few = self.method, self.runs.is_slow
        scale = math.sqrt(method.stiffness * self.setting.system.mass_share)
        yield "K", np.geomspace(3, 3e6, 13 if few else 25), lambda value: changed(method, stiffness=value)
        if method.damping is not None:
            yield "D", np.geomspace(1e-3, 1e2, 13 if few else 25) * scale, lambda value: changed(method, damping=value)
        factors = (0.5, 2, 4) if few else (0.25, 0.5, 2, 4, 8, 16, 32)
        yield "steps", [f * method.steps for f in factors], lambda value: changed(method, steps=max(4, round(value)))
        yield "limit", ["no step"], lambda value: method.limit
        if not method.located:
            yield "status", ["located"], lambda value: with_located_steps(method)

    # --- kinds --------------------------------------------------------------------------------------------------------

    def kinds(self):
        """What kind of motion both are, after LONG periods."""
        reference, penalty = self.words.reference, self.words.penalty
        if reference is None or penalty is None:
            return
        late = self.runs.late.section
        here = self.kind(Reference(), late)
        if (outcome := self.agrees(reference, here)) is not None:
            yield Claim("c1", outcome, f"reference {reference.type} {reference.near_period}, found {here}")
        later = min(5 * self.runs.periods, max(own.LONG, self.runs.periods))
        run = self.runs.run(self.method, max(later, own.SECTION), own.SECTION)
        there = self.kind(self.method.limit, run.section) if run.ok else ("ended", 0)
        if (outcome := self.agrees(penalty, there)) is not None:
            yield Claim("c2", outcome, f"penalty {penalty.type} {penalty.near_period}, found {there}")
        if (said := kinds_in(self.words.headline)) is not None:
            differ = here[0] != there[0] or (here[0] == "periodic" and here[1] != there[1])
            yield Claim("c3", TRUE if differ and said[0] != said[1] else FALSE, f"{said}; found {here}, {there}")

    def kind(self, method, section):
        """("periodic", period), ("chaotic", 0) or ("regular", 0) of a section and the same method without a step."""
        period = period_of(section, own.SECTION // 2)
        if (limit := self.period_without_step(method, section)) and (not period or period % limit == 0):
            return "periodic", limit  # a step may scatter it, or lock the scatter into a longer cycle
        if period:
            return "periodic", period
        if getattr(method, "law", "") in SLOW_LAWS:
            return "unknown", 0
        exponent = self.exponent(method, section[-1], PIECES)
        if abs(exponent) < UNCLEAR:  # the motion of a locked torus returns after a thousand periods
            exponent = self.exponent(method, section[-1], MORE_PIECES)
        return ("chaotic" if exponent > EXPONENT else "regular"), 0

    def period_without_step(self, method, section):
        """The period of the motion that the limit has from the end of a section."""
        if isinstance(method, Reference):
            return 0
        start = Checkpoint(self.runs.system, self.runs.eta, method, 0, tuple(section[-1]))
        periods = 400 if method.law in SLOW_LAWS else 2000
        run = simulate(self.runs.system, self.runs.eta, method, periods=periods, keep=200, initial=start)
        return period_of(run.section, 100) if run.ok else 0

    def exponent(self, method, state, pieces, settling=50):
        """Largest Lyapunov exponent per period, of two runs that are brought close again after each period."""
        system, eta, distance = self.runs.system, self.runs.eta, 1e-7
        one = np.array(state, float)
        direction = np.array([1.0, 0.5, 0.0, 0.0] if system.wall else [1.0, 0.5, -0.7, 0.3])
        other, total = one + distance * direction / np.linalg.norm(direction), 0.0
        for piece in range(settling + pieces):
            ends = []
            for start in (one, other):
                begin = Checkpoint(system, eta, method, 0, tuple(start))
                run = simulate(system, eta, method, periods=1, keep=1, initial=begin)
                if not run.ok:
                    return math.nan
                ends.append(run.section[-1])
            one, away = ends[0], ends[1] - ends[0]
            grown = max(float(np.linalg.norm(away)), 1e-14)
            total += math.log(grown / distance) * (piece >= settling)
            other = one + away * (distance / grown)
        return total / pieces

    @staticmethod
    def agrees(said, found):
        """Outcome of a kind that is said; None where it claims none."""
        kind, period = found
        if kind == "unknown":
            return None
        wanted = {Kind.CHAOTIC: "chaotic", Kind.QUASI_PERIODIC: "regular"}.get(said.type)
        if wanted is not None:
            return TRUE if kind == wanted else FALSE
        if said.type is Kind.UNDECIDED or not said.near_period:  # "nearly repeats", which has its own number
            return None
        return TRUE if (kind, period) == ("periodic", said.near_period) else FALSE

    # --- contact ------------------------------------------------------------------------------------------------------

    def contact_facts(self):
        found, words = self.found, self.words
        yield from self.counts()
        text = [words.headline, *words.details]
        if "Nothing touches" in words.headline:
            touches = any(len(run.impacts) or len(run.contacts) for run in (self.runs.reference, self.runs.penalty))
            yield Claim("c4", FALSE if touches else TRUE, "touches" if touches else "")
        if "stay in contact all the time" in words.headline:
            shares = [self.share_of(run) for run in (self.runs.reference, self.runs.penalty)]
            yield Claim("c4", TRUE if min(shares) > 0.999 else FALSE, f"{shares}")
        if (said := first(r"[Tt]he bodies part with ([\d.]+) of the speed", text)) is not None:
            yield from self.rebounds(said[0], text)
        if (said := first(r"a contact alone rebounds with ([\d.]+) of its speed", text)) is not None:
            yield from self.rebound_of_alone("d6", said[0])
        elif (said := first(r"rebounds with ([\d.]+) of its speed", text)) is not None:
            yield self.rebound("d6", said[0])
        if (said := first(r"A contact of this K and D alone lasts τ = ([\d.e+-]+)", text)) is not None:
            yield self.lasts_alone(said[0])
            yield self.lasts(*(first(r"In the motion contacts last τ = ([\d.e+-]+)", text) or said))
        if (said := first(r"lasts ([\d.]+) % of a period", [words.headline])) is not None:
            yield self.lasts(said[0] / 100 * found.runs.penalty.period)
        if (said := first(r"takes only ([\d.]+) steps", [words.headline])) is not None:
            step = found.runs.penalty.period / self.method.steps
            yield self.lasts(said[0] * step)

    def counts(self):
        """Impacts, contacts and contact time against all events, over whole cycles; force and energy."""
        for name, run in (("reference", self.runs.reference), ("penalty", self.runs.penalty)):
            said = getattr(self.found.motions, name)
            if not run.ok:
                continue
            cycle = max(said.near_period, 1)
            kept = run.keep // cycle * cycle
            end, begin = run.window[1], run.window[1] - kept * run.period
            impacts = int(np.sum(run.impacts.time > begin)) / kept
            begun = int(np.sum(run.contacts[:, 0] > begin)) / kept
            spans = np.clip(run.contacts, begin, end)
            share = float(np.sum(spans[:, 1] - spans[:, 0]) / (end - begin))
            for what, a, b in (
                ("impacts", said.impacts_per_period, impacts),
                ("contacts", said.contacts_per_period, begun),
                ("contact share", said.contact_share, share),
            ):
                yield Claim("d1", graded(a, b, 1.05, 1.2, 0.02), f"{name} {what}: {a:.3g} said, {b:.3g} found")
        counted = first(r"with ([\d.]+) contacts? a period for ([\d.]+) impacts?", [self.words.headline])
        if counted is not None:
            wanted = [len(run.impacts) / run.keep for run in (self.runs.penalty, self.runs.reference)]
            right = all(within(a, b, 1.1, 0.05) for a, b in zip(counted, wanted, strict=True))
            yield Claim("d2", TRUE if right else FALSE, f"{counted} said, {wanted} found")
        shares = first(r"Contact takes ([\d.]+) % of the time in the reference, ([\d.]+) %", self.words.details)
        if shares is not None:
            wanted = [self.share_of(run) for run in (self.runs.reference, self.runs.penalty)]
            right = all(within(a / 100, b, 1.1, 0.01) for a, b in zip(shares, wanted, strict=True))
            yield Claim("d1", TRUE if right else FALSE, f"{shares} said, {wanted} found")
        yield from self.force_and_energy()

    @staticmethod
    def share_of(run):
        spans = np.clip(run.contacts, *run.window)
        return float(np.sum(spans[:, 1] - spans[:, 0]) / (run.window[1] - run.window[0]))

    def force_and_energy(self):
        """Peak force, of every step, and the energy that the excitation gives, of the motions with evidence."""
        motions = self.found.with_evidence()
        for name, method in (("reference", Reference()), ("penalty", self.method)):
            said = getattr(motions, name)
            cycle = said.near_period
            steps = method.steps or 4000
            if not cycle or cycle * steps > 400_000:
                continue
            periods = cycle * max(1, 20 // cycle) if steps <= 4000 else cycle
            # several lengths: a motion that the time step blurs has another energy and another peak in each
            lengths = 12 if said.step_noise > 0 and periods * steps <= 40_000 else 4
            run = self.runs.run(method, keep=lengths * periods, record=Record(lengths * periods, steps))
            if not run.ok:
                continue
            if math.isfinite(said.energy_lost):
                created = said.energy_created if math.isfinite(said.energy_created) else 0.0
                found = [each + created for each in energy_lost(self.runs.system, self.runs.eta, run, lengths)]
                nearest = float(np.clip(said.energy_lost, min(found), max(found)))
                outcome = graded(said.energy_lost, nearest, 1.03, 1.15, 0.003 * abs(nearest) + 1e-6)
                yield Claim("d4", outcome, f"{name} energy {said.energy_lost:.4g} said, {np.round(found, 3)} found")
            if name == "penalty" and math.isfinite(said.peak_force):
                peaks = [float(force.max()) for force in np.array_split(run.trajectory.force, lengths)]
                peak = float(np.clip(said.peak_force, min(peaks), max(peaks)))
                if method.located and method.law in ("kelvin-voigt", "cut"):  # its damper acts from the touch on
                    peak = max(peak, 2 * method.damping * float(run.impacts.closing_speed.max(initial=0.0)))
                yield Claim(
                    "d3", graded(said.peak_force, peak, 1.1, 1.3), f"{said.peak_force:.4g} said, {peak:.4g} found"
                )

    def measured(self, run, method):
        """Restitution of the short contacts of a run, and the median of how long all last; nan without any."""
        times = run.impacts.time
        ends = dict(run.contacts)
        lasting = np.array([ends.get(time, math.nan) - time for time in times])
        closing = -np.diff(run.impacts.velocity_before, axis=1)[:, 0]
        parting = np.diff(run.impacts.velocity_after, axis=1)[:, 0]
        speeds = np.where(closing > 0, closing, math.nan)
        short = lasting <= 2 * undamped_duration(self.setting.system, method, speeds)
        apart, closing = np.maximum(parting[short], 0.0), closing[short].sum()
        closing -= (apart - parting[short]).sum()  # who still approach are in the same contact a moment later
        rebound = float(apart.sum() / closing) if short.any() else math.nan
        known = lasting[np.isfinite(lasting)]
        return rebound, float(np.median(known)) if len(known) else math.nan

    def rebounds(self, said, text):
        linear = self.method.law == "kelvin-voigt"
        if any("alone the bodies part" in each for each in text):
            yield from self.rebound_of_alone("d6", said)
        else:
            yield self.rebound("d6", said)
        ways = {"damping": first(r"which (?:K = [\d.e+]+ or )?D = ([\d.e+-]+)", text)}
        ways["stiffness"] = first(r"(?:which|or) K = ([\d.e+-]+) (?:or|alone)", text)
        for name, value in ways.items():
            if value is None or not linear:
                continue
            method = changed(self.method.limit, **{name: value[0]})
            given = rebound_alone(self.setting.system, method)
            run = self.runs.run(method)
            seen = self.measured(run, method)[0] if run.ok else math.nan
            wanted = self.setting.system.restitution
            outcome = graded(given, wanted, 1.1, 1.3, 0.02)
            if outcome == TRUE and math.isfinite(seen) and not within(seen, wanted, 1.1, 0.02):
                outcome = MISLEADING
            yield Claim(
                "d5", outcome, f"{name} {value[0]:g}: {given:.3g} alone, {seen:.3g} in the motion, e {wanted:g}"
            )

    def rebound_of_alone(self, row, said):
        if self.method.law != "kelvin-voigt":
            return
        given = max(rebound_alone(self.setting.system, self.method), 0.0)
        yield Claim(row, graded(said, given, 1.05, 1.2, 0.02), f"alone {said} said, {given:.3g} found")

    def lasts_alone(self, said):
        """Half an oscillation of the damped contact."""
        stiffness, mass = self.method.stiffness, self.setting.system.mass_share
        decay = self.method.damping / mass
        lasting = math.pi / math.sqrt(stiffness / mass - decay**2)
        return Claim("d7", graded(said, lasting, 1.01, 1.1), f"alone {said:.3g} said, {lasting:.3g} found")

    def rebound(self, row, said):
        seen = self.measured(self.runs.penalty, self.method)[0]
        if not math.isfinite(seen):
            lasting = self.method.law != "kelvin-voigt" and len(self.runs.penalty.impacts)
            return Claim(row, TRUE if said <= 0.02 or lasting else MISLEADING, f"{said} said, none measured")
        seen = max(seen, 0.0)
        return Claim(row, graded(said, seen, 1.05, 1.2, 0.02), f"{said} said, {seen:.3g} found")

    def lasts(self, said):
        median = self.measured(self.runs.penalty, self.method)[1]
        if not math.isfinite(median):
            return Claim("d7", TRUE, f"{said:.3g} said, no contact")
        return Claim("d7", TRUE if within(said, median, 1.5) else MISLEADING, f"{said:.3g} said, {median:.3g} found")

    # --- the rest -----------------------------------------------------------------------------------------------------

    def agreement(self):
        difference, words = self.found.difference, self.words
        total = self.runs.error(self.method)
        absolute = 0.002 + self.chance
        outcome = graded(difference.total, total, 1.05, 1.2, absolute)
        if outcome == MISLEADING and words.penalty is not None and not words.penalty.near_period:
            # of a motion that does not repeat, the last digits of a run decide which part of it is seen
            others = [total, *(self.runs.error(self.method, further=i) for i in (2, 4, 6, 8))]
            outcome = TRUE if min(others) <= difference.total <= max(others) else MISLEADING
        yield Claim("e1", outcome, f"{difference.total:.4g}, {total:.4g}")
        if difference.measure == "displacements" and self.found.pointwise:
            yield Claim("e2", TRUE if self.found.residual < 1e-6 * self.found.parts.size + 1e-9 else FALSE, "parts")
        allowed = {"yes": (0, SAME), "partly": (0, CLOSE), "no": (SAME, math.inf)}
        if words.agree in allowed and difference.measure == "displacements":
            low, high = allowed[words.agree]
            said = low * 0.98 <= difference.total <= high * 1.02
            yield Claim("e3", TRUE if said else FALSE, f"{words.agree}: {difference.total:.3g}")

    def blur(self):
        said = first(r"blurs each point of the section \(ξ[₁₂] by ±([\d.]+)\)", [self.words.headline])
        said = said or first(r"blurred by the time step \(±([\d.]+) in ξ[₁₂]\)", [self.words.headline])
        if said is None:
            return
        period = max(self.words.penalty.near_period, 1)
        sizes = {1: self.scatters(self.method, period)}
        for factor in (4, 16):  # four times the steps may still blur another way
            finer = changed(self.method, steps=factor * self.method.steps)
            # with more steps the motion may have another period
            sizes[4] = min((self.scatters(finer, each * period) for each in (1, 2, 3, 4)), key=np.median)
            if np.median(sizes[4]) < SHRINKS * np.median(sizes[1]):
                break
        # a few jumps of its phase would make more of it over all periods
        nearest = float(np.clip(said[0], min(sizes[1]), max(sizes[1])))
        outcome = graded(said[0], nearest, 1.3, 2.0)
        sizes = {factor: float(np.median(each)) for factor, each in sizes.items()}
        if outcome == TRUE and not sizes[4] < SHRINKS * sizes[1]:
            outcome = MISLEADING
        yield Claim("b", outcome, f"±{said[0]} said, {sizes[1]:.3g} found, {sizes[4]:.3g} with more steps")

    def scatters(self, method, period):
        """Standard deviations of the section about a cycle, of pieces of a run from the penalty solution's state on."""
        row, state = 0 if self.runs.system.wall else 2, tuple(self.runs.penalty.section[-1])
        start = Checkpoint(self.runs.system, self.runs.eta, method, 0, state)
        run = self.runs.run(method, 1000, 400 // period * period, initial=start)
        if not run.ok:
            return [math.nan]
        pieces = np.array_split(run.section[:, row], max(1, 400 // max(self.runs.keep, period)))
        return [scatter(piece, period) for piece in pieces]

    def of_changing(self):
        """A motion is said to change still: of some later thousand periods, that does change."""
        drifts = []
        for method in (Reference(), self.method):
            run = self.runs.run(method, self.runs.periods + 7 * own.SECTION, 8 * own.SECTION)
            if not run.ok:
                drifts.append(math.inf)
                continue
            here, *later = np.split(run.section, 8)
            size = own.rms(here[:, [0, 2]] - self.runs.rest)
            moved = [own.apart(here, each) / size for each in later]
            chance = [own.apart(one, other) / size for i, one in enumerate(later) for other in later[:i]]
            drifts.append(float(np.median(moved) / max(np.median(chance), 0.005)))
        outcome = TRUE if max(drifts) > 2 else FALSE
        yield Claim("h", outcome, f"later sections differ {max(drifts):.2g} times as much from it as from each other")

    def of_other_ends(self):
        """A different but valid motion: the reference keeps it from the penalty solution's state on."""
        if "different but valid motion" not in self.words.headline:
            return
        said = first(r"moves so too, ([\d.]+) % apart", [self.words.headline])[0] / 100
        start = tuple(self.runs.penalty.section[-1])
        if self.runs.system.wall is False and start[2] + self.runs.system.clearance < start[0]:
            middle = (start[0] + start[2] + self.runs.system.clearance) / 2
            start = (middle, start[1], middle - self.runs.system.clearance, start[3])
        begin = Checkpoint(self.runs.system, self.runs.eta, Reference(), 0, start)
        record = Record(self.runs.keep, own.PER_PERIOD, self.method.steps)
        how = {"periods": 6 * self.runs.periods, "keep": self.runs.keep, "initial": begin, "record": record}
        there = simulate(self.runs.system, self.runs.eta, Reference(), **how)
        here = self.runs.run(self.method, record=record)
        if not (there.ok and here.ok):
            yield Claim("c6", FALSE, "ended early")
            return
        one, two = own.by_period(there, self.runs.keep), own.by_period(here, self.runs.keep)
        size = own.rms(one - self.runs.rest[:, None, None])
        left = min(own.rms(two - np.roll(one, shift, axis=1)) for shift in range(self.runs.keep)) / size
        yield Claim("c6", graded(said, left, 1.2, 1.5, 0.003), f"{said:.3g} said, {left:.3g} found")


__all__ = ["FALSE", "MISLEADING", "TRUE", "Claim", "Left", "judge", "judge_words", "share"]
