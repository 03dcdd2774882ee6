"""The time step: one motion with n steps per period, fixed and cut where contact changes, by the method that is set."""

import math
from dataclasses import replace

import numpy as np
from bokeh.models import Line, Scatter
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.method_words import STEP_NAMES, brief_name
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.formats import Figure, Series
from vibroscope.app.export.scripts import initial_option, method_python, scheme_options, sweep_command, sweep_python
from vibroscope.app.page.shared.curves import AWAITED, Axis, Curves, Plot, curve
from vibroscope.app.page.shared.figure import GREEN, VERMILLION, cursor_line
from vibroscope.app.page.shared.seen import say
from vibroscope.app.page.study.tab import StudyView, engine_obstacle, free_obstacle, method_lines
from vibroscope.app.runtime.number_text import print_number
from vibroscope.app.studies.time_step import SAMPLE, STEPS, TRANSIENT, PartialStep, StepQuestion, grow_step
from vibroscope.engine import STATUSES, Status, percent, written
from vibroscope.engine.facts import Amount, Statement, Symbol, joined, stated
from vibroscope.engine.sweeps import SCHEMES

_LOOKS = {  # of each scheme: colour, marker, dash, colour of its points once a period
    "fixed": (VERMILLION, "diamond", "solid", None),
    "located": (GREEN, "circle", "dashed", GREEN),
}
_SIZES = {"spread": "scatter", "error_time_step": "error_time_step"}  # axes of the sizes over n, and their variables
# Smaller values are rounding; drawn, they would only stretch the axis.
_FLOOR = 1e-10


def _decades(least: float, greatest: float) -> tuple[float, float]:
    """Whole decades that hold all sizes, and one above for the legend."""
    low, high = np.round(np.log10([least, greatest]), 6)  # of columns in single precision
    return 10.0 ** (np.ceil(low) - 1), 10.0 ** (np.ceil(high) + 1)


def _phase(scheme: str) -> Plot:
    colour, marker, _, fill = _LOOKS[scheme]
    look, shown = {"line_color": colour, "line_width": 1.3}, {"x": "xi2", "y": "v2"}  # at a wall these hold ξ₁ and ξ₁′
    dots = curve(Scatter, f"step_section_{scheme}", **shown, **look, marker=marker, size=8, fill_color=fill)
    return Plot(AWAITED, **shown, entries={"": ("", [curve(Line, f"step_orbit_{scheme}", **shown, **look), dots])})


def _over_steps(name: str, title: str) -> Plot:
    entries = {}
    for scheme, (colour, marker, dash, _) in _LOOKS.items():
        source, shown = f"step_{name}_{scheme}", {"x": "n", "y": "size", "line_color": colour}
        line = curve(Line, source, **shown, line_width=1.5, line_dash=dash)
        entries[scheme] = (
            STEP_NAMES[scheme],
            [line, curve(Scatter, source, **shown, fill_color=colour, marker=marker, size=10)],
        )
    return Plot(title, "n", name, entries)


class TimeStepView(Curves):
    """Two phase plots and, below them, two logarithmic plots over n."""

    axes = {  # noqa: RUF012 - read only
        "xi2": Axis(-8, 8, "displacement ξ₂", "displacement"),
        "v2": Axis(-8, 8, "velocity ξ₂′", "velocity"),
        "n": Axis(STEPS[0] / 1.4, STEPS[-1] * 1.4, "steps per period n = T/Δτ", logarithmic=True),
        "spread": Axis(_FLOOR, 1.0, "standard deviation of ξ₂", "displacement", logarithmic=True, fit=_decades),
        "error_time_step": Axis(
            _FLOOR, 1.0, "rms difference from exact penalty, relative", logarithmic=True, fit=_decades
        ),
    }
    plots = {f"step_phase_{scheme}": _phase(scheme) for scheme in SCHEMES} | {
        "step_spread": _over_steps("spread", "Blur about the cycle (drawn down to 10⁻¹⁰ A)"),
        "step_error_time_step": _over_steps("error_time_step", "Error by the time step alone"),
    }

    def __init__(self) -> None:
        super().__init__()
        self._cursors = {f"step_{name}": cursor_line(name=f"step_cursor_{name}") for name in _SIZES}
        for name, cursor in self._cursors.items():
            self.figures[name].add_layout(cursor)

    def update(self, setting: Setting, result: PartialStep | None) -> None:
        """Move the cursors; draw what is known, the phase plots with the n that is nearest to the one set."""
        for cursor in self._cursors.values():
            cursor.location = setting.steps
        self.label(setting, lambda words: words.replace("ξ₂", "ξ₁") if setting.bodies == "wall" else words)
        if result is None:
            return
        fresh, index = self.changes_to(result.question), result.nearest(setting.steps)
        for scheme in SCHEMES:
            self._draw(result, index, scheme, setting)
        self.follow(*_SIZES, "xi2", "v2", fresh=fresh)
        for name, variable in _SIZES.items():
            why = result.why_none(variable)
            seen = f"no number, since {why}" if why else _seen(result, index, variable)
            self.say(f"step_{name}", seen, setting)

    def _draw(self, result: PartialStep, index: int, scheme: str, setting: Setting) -> None:
        question, method = result.question, result.question.method
        stiffness = result.stiffness if np.ndim(result.stiffness) == 0 else float(f"{result.stiffness[index]:.6g}")
        numbers = {"eta": question.eta, "K": stiffness, "D": method.damping}
        fields = [(shown_field(name, setting), value) for name, value in numbers.items() if value is not None]
        at = ", ".join(field.words(value) if not field.unit else field.measure(value) for field, value in fields)
        name = f", {brief_name(method)}" if method.has_choices else ""
        title = f"T/{result.steps[index]:.0f}, {STEP_NAMES[scheme]}{name}, {at}"
        say(self.figures[f"step_phase_{scheme}"], title, result.words(index, scheme), setting)
        for source, shown in (("orbit", result.orbit), ("section", result.section)):
            self.write(f"step_{source}_{scheme}", dict(zip(("xi2", "v2"), shown(index, scheme).values(), strict=True)))
        for name, variable in _SIZES.items():
            sizes = result.of_scheme(variable, scheme)
            fine = np.isfinite(sizes)
            self.write(f"step_{name}_{scheme}", {"n": result.steps[fine], "size": np.maximum(sizes[fine], _FLOOR)})


def _seen(result: PartialStep, index: int, variable: str) -> Statement:
    """The size of a curve at the n that is shown, of each scheme that has one there."""
    sizes = {scheme: float(result.of_scheme(variable, scheme)[index]) for scheme in result.schemes}
    numbers = (
        stated("{} {}", STEP_NAMES[scheme], Amount(size, "displacement", 2) if variable == "scatter" else percent(size))
        for scheme, size in sizes.items()
        if np.isfinite(size)
    )
    known = joined(", ", numbers)
    return stated("{} at T/{}", known, f"{result.steps[index]:.0f}") if known else known


class TimeStep(StudyView):
    """Figure 14 of the paper, at any η, K and D."""

    key = "step"
    title = "Time step"
    grow = staticmethod(grow_step)
    drawn, arrangement, tapped = TimeStepView, ("halves",), ("step_spread", "step_error_time_step")
    hint = (
        "A click in the lower figures sets n to the nearest of the study; so does the slider T/Δτ. "
        "Integrator, contact status and law are those that are set under Solver. "
        f"Each motion is run from its start (see System) over {TRANSIENT} periods, then {SAMPLE} are kept."
    )
    pictures = (
        *(
            Figure(
                f"step_phase_{scheme}",
                f"Phase plot, {STEP_NAMES[scheme]}",
                f"Velocity over displacement with the {scheme} step.",
            )
            for scheme in SCHEMES
        ),
        Figure("step_spread", "Blur over n", "Blur about the cycle over the steps per period."),
        Figure("step_error_time_step", "Error over n", "Error by the time step alone over the steps per period."),
    )

    def obstacle(self, setting: Setting) -> str:
        """Why there is no study: nothing drives the bodies, or the engine has no study of the method."""
        why = {} if setting.from_rest else {"why": "needs a motion that lasts"}
        return free_obstacle(setting, "this study", **why) or engine_obstacle(setting, self.question(setting))

    def question(self, setting: Setting) -> StepQuestion:
        """All but n itself, and whether steps are located: both are shown."""
        method = replace(setting.constant_step, steps=STEPS[0])
        if not setting.follows_step:
            return StepQuestion(setting.system, setting.eta, method, setting.own_start)
        method = replace(method, stiffness=1.0)  # each number of steps has its own
        return StepQuestion(setting.system, setting.eta, method, setting.own_start, setting.step_scale)

    def describe(self, setting: Setting, result: PartialStep) -> list[list[str]]:
        """The study, the n that is shown, and how blur and error fade, in words."""
        return [*method_lines(result.question, "is another model"), *statements(setting, result)]

    def table(self, name: str) -> list[Series]:
        """Orbit and section of the n that is shown, or a size over n."""
        result, what = self.result, name.removeprefix("step_").replace("spread", "scatter")
        if what in ("scatter", "error_time_step"):
            of = result.of_scheme
            return [Series(scheme, {"n": result.steps, what: of(what, scheme)}) for scheme in result.schemes]
        scheme, index = what.removeprefix("phase_"), result.nearest(self._result_setting.steps)
        orbit, section = result.orbit(index, scheme), result.section(index, scheme)
        return [Series("orbit", orbit), Series("section", section)]

    def python(self, setting: Setting) -> str:
        """`StepStudy` of the same steps."""
        system, eta, method, initial, scale = self.script_question(setting)
        how = f"steps={STEPS}, transient={TRANSIENT}, sample={SAMPLE}" + (
            "" if initial is None else f", initial={initial}"
        )
        how += "" if scale is None else f", stiffness_of_step={scale}"
        study = f"StepStudy(system, {method_python(method)}, {eta!r}, {how})"
        return sweep_python({"study": f"sweep({study})"}, system)

    def command(self, setting: Setting) -> str:
        """``vibroscope sweep step`` of the same steps."""
        system, eta, method, initial, scale = self.script_question(setting)
        stiffness = {"K": method.stiffness} if scale is None else {"stiffness-of-step": scale}
        numbers = {"eta": eta, **stiffness, "D": method.damping}
        options = "".join(f" --{name} {print_number(x)}" for name, x in numbers.items() if x is not None)
        options += f" --steps {','.join(map(str, STEPS))}{scheme_options(method)}"
        options += f" --transient {TRANSIENT} --sample {SAMPLE}"
        options += initial_option(initial)
        return sweep_command("step", system, options)

    def take_over(self, name: str, x: float, y: float) -> None:
        """Set n to that of the study which is nearest."""
        if self.result is not None:
            self.host.set({"steps": str(int(self.result.steps[self.result.nearest(x)]))})


_SLOWEST = 1 / 6  # order: by half from the fewest steps of the study to the most
_MOST_DIGITS = 4  # after the point, of an order
_ROUNDING = 1e-11  # of a displacement: the width of a motion that repeats exactly
_ENDED = {Status.DIVERGED: "blown up.", Status.WITHOUT_SOLUTION: "stopped: a step has no solution."}


def statements(setting: Setting, result: PartialStep) -> list[list[str | Statement]]:
    """Head and text: the n that is shown, and how blur and error fade."""
    index = result.nearest(setting.steps)
    n = f"T/{result.steps[index]:.0f}"
    lines = [[f"{n}, {STEP_NAMES[scheme]}", _motion(result, index, scheme)] for scheme in result.schemes]
    for name, head in (("scatter", "Blur"), ("error_time_step", "Error by the time step")):
        lines.append([f"{head}, observed order", _orders(result, name)])
    return lines


def _motion(result: PartialStep, index: int, scheme: str) -> str | Statement:
    names = ("status", "scatter", "longest_contact_steps", "error")
    status, scatter, steps, error = (result.of_scheme(name, scheme)[index] for name in names)
    if status != 0:
        return _ENDED.get(STATUSES[int(status)], "ended early.")
    words, symbol = result.words(index, scheme), Symbol("ξ₁" if result.question.system.wall else "ξ₂")
    blur = "; no blur beyond rounding"
    if scatter > _ROUNDING:
        amount = stated("{} by ±{}", symbol, Amount(scatter, "displacement", 2))
        begin, about = (": ", "") if "blurred" in words else ("; ", " about the cycle")
        blur = stated("{}{}{} over {} periods", begin, amount, about, str(SAMPLE))
    against = f"; error against the reference {percent(error)}" if math.isfinite(error) else ""
    return stated("{}{}; longest contact {} steps{}.", words, blur, written(steps, 3), against)


def _orders(result: PartialStep, name: str) -> str:
    said = [f"{STEP_NAMES[scheme]}: {_order(result, name, scheme)}" for scheme in result.schemes]
    return f"{'; '.join(said)}."


def _order(result: PartialStep, name: str, scheme: str) -> str:
    if missing := result.why_none(name, scheme):
        return f"no number, since {missing}"
    if np.nanmax(result.of_scheme(name, scheme)) < 1e-10:
        return "none beyond rounding"
    order, error = result.order(name, scheme)
    if math.isnan(order):
        return "no order from a single number of steps"
    if order <= _SLOWEST:
        return "does not fall with n"
    if order <= error:
        return "rises and falls with n, so that it has no order"
    power = f"n to the power of −{_with_error(order, error)}"
    return f"falls unevenly, about as {power}" if order <= 3 * error else f"falls as {power}"


def _with_error(order: float, error: float) -> str:
    """An order and its standard error, to the first digit of that; without it where there is none, or next to none."""
    if not error > 0:
        return f"{order:.2f}"
    digits = max(0, -math.floor(math.log10(error)))
    return f"{order:.{digits}f} ± {error:.{digits}f}" if digits <= _MOST_DIGITS else f"{order:.{_MOST_DIGITS}f}"
