"""The report of one state of the page: HTML that opens without a server. No panel import.

What a colleague needs: the system as it was entered, the question, the verdict, figures, the suggestion, limits.

The label in the file of a figure: the figure, the setting, the program, the page.
"""

from collections.abc import Mapping, Sequence
from html import escape
from typing import NamedTuple

from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.method_words import name_of_method
from vibroscope.app.explorer.parameters import EXCITATION_FIELDS, FIELDS, SECOND_STOP_FIELDS, START_FIELDS
from vibroscope.app.explorer.physical_fields import is_shown, physical_field, physical_numbers
from vibroscope.app.explorer.state import Setting, integrator_numbers, law_numbers
from vibroscope.app.export.formats import Figure, program
from vibroscope.engine import written

_ALWAYS = ("damping1_ratio", "damping2_ratio", "clearance_mm")  # said where they are zero, too


def figure_label(tab: str, figure: Figure, setting: Setting | None, address: str) -> dict[str, str]:
    """The label of a figure's file: its ``title`` and ``description``, with the address of the page."""
    lines = [figure.caption]
    if setting is not None:
        lines.append("Setting: " + ", ".join(f"{name} = {text}" for name, text, _ in setting_rows(setting)) + ".")
    lines += [f"Made by {program()}.", f"The page: {address}"]
    return {"title": f"Vibroscope, {tab}: {figure.title}", "description": "\n".join(lines)}


Rows = list[tuple[str, str, str]]  # symbol or name, value in the units that are shown, and meaning


def setting_rows(setting: Setting) -> Rows:
    """All that a setting is: the system, its contact, and how it is solved; nothing that it does not have."""
    return [*system_rows(setting), *contact_rows(setting)]


def system_rows(setting: Setting) -> Rows:
    """The system as it was entered, without forces, phases and constants that are zero."""
    kind = [_choice("bodies", setting)]
    if setting.scale is None:
        names = (*setting.described_by, *(name for name in EXCITATION_FIELDS if name != "held"))
        names = [name for name in names if getattr(setting, name) or name not in EXCITATION_FIELDS]
        rows = [_row(name, setting) for name in names if name != "d3" or setting.joint_damping == "table"]
    else:
        numbers = {name: value for name, value in physical_numbers(setting).items() if is_shown(name, setting)}
        rows = [_physical_row(name, value, setting) for name, value in numbers.items() if value or name in _ALWAYS]
        rows.append(_row("restitution", setting))
        rows += [_row(name, setting) for name in SECOND_STOP_FIELDS[1:] if setting.stops == "two"]
    held = (
        [("held", f"{setting.held} of the base", "what keeps its amplitude over the frequency")] if setting.base else []
    )
    return [*kind, *rows, *held, _row("eta", setting)]


def contact_rows(setting: Setting) -> Rows:
    """The contact and the solvers: K, D, the step, law, integrator and their own numbers; the reference's ε and d₃."""
    names = ["K", "D", "steps", "law", *law_numbers(setting), "integrator", *integrator_numbers(setting)]
    names += ["located"] if setting.located == "yes" else ["status"]
    names += ["without_solution"] if setting.status == "end" else []
    names += ["stiffness", "step_scale"] if setting.follows_step else []
    names += ["initial_acceleration"] if setting.initial_acceleration != "equation" else []
    names += ["threshold"] + ([] if setting.bodies == "wall" else ["joint_damping"])
    if not setting.from_rest:
        names += START_FIELDS[:2] if setting.bodies == "wall" else START_FIELDS
    return [_row(name, setting) for name in names]


def _physical_row(name: str, value: float, setting: Setting) -> tuple[str, str, str]:
    field = physical_field(name, setting.units)
    return field.label, f"{written(field.factor * value, 6)} {field.unit}".strip(), field.hint


def _choice(name: str, setting: Setting) -> tuple[str, str, str]:
    field = FIELDS[name]
    return field.label, field.choices[getattr(setting, name)], field.hint


def _row(name: str, setting: Setting) -> tuple[str, str, str]:
    if FIELDS[name].choices:
        return _choice(name, setting)
    field = shown_field(name, setting)
    if name == "D" and setting.follows_restitution:
        return field.label, FIELDS["damper"].choices["restitution"], field.hint
    return field.label, field.measure(getattr(setting, name)), field.hint


STYLE = """
body { max-width: 60rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 system-ui, sans-serif; color: #22303c; }
body { overflow-wrap: anywhere; }
table { border-collapse: collapse; } td, th { padding: 2px 14px 2px 0; text-align: left; font-weight: normal; }
@media (min-width: 46em) { td, th { overflow-wrap: break-word; } }
figure { margin: 1.5rem 0; } figure svg { max-width: 100%; height: auto; } figcaption { color: #566573; }
pre { padding: 10px; white-space: pre-wrap; background: #f3f5f7; font-size: 13px; }
@media screen and (prefers-color-scheme: dark) {
  body { background: #131416; color: #cfd0d0; } a { color: #7ab3f5; }
  pre { background: #202226; } figcaption { color: #9aa5b1; } figure svg { background: white; }
}
"""


LIMITS = (
    "Two bodies, or one and a wall, with one degree of freedom each; one contact, normal force only: no friction, no "
    "stress, no flexibility of the bodies.",
    "The excitation is harmonic. What is compared is the motion after the transient of one start; other starts may "
    "lead to other motions.",
    "The reference is a model, too: impacts have no duration, and a restitution e that does not depend on the speed.",
    "An error is the rms of the difference of the displacements, relative to the reference. The peak force of a "
    "contact model follows from its K, about as √K: it is a number of the model, not of the system.",
)


class Findings(NamedTuple):
    """What a tab says.

    Attributes
    ----------
    words : mapping of str to str
        The verdict and what is behind it: paragraphs by their headings.
    suggestion : sequence of str
        What to set instead, in sentences; empty where nothing was searched for.
    """

    words: Mapping[str, str]
    suggestion: Sequence[str] = ()


def as_report(
    title: str,
    findings: Findings,
    setting: Setting | None,
    figures: Sequence[tuple[str, str]],
    scripts: Sequence[str],
    source: Mapping[str, str],
) -> str:
    """The report.

    Parameters
    ----------
    title : str
        Title of the tab.
    findings : Findings
    setting : Setting or None
        The setting of the figures, if they depend on one.
    figures : sequence of tuple of str
        Each as SVG, with its caption.
    scripts : sequence of str
        That reproduce the numbers.
    source : mapping of str to str
        ``program``, ``made`` (date), ``address`` of the page, or its query.
    """
    lines = "".join(f"<h3>{escape(head)}</h3><p>{escape(text)}</p>" for head, text in findings.words.items())
    drawn = "".join(
        f"<figure>{svg[svg.index('<svg') :]}<figcaption>{escape(caption)}</figcaption></figure>"
        for svg, caption in figures
    )
    commands = "".join(f"<pre>{escape(script)}</pre>" for script in scripts)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Vibroscope report: {escape(title)}</title>
<style>{STYLE}</style></head><body>
<h1>Vibroscope report: {escape(title)}</h1>
{_question(setting) if setting else ""}
<h2>Verdict</h2>{lines}
<h2>Figures</h2>{drawn}
{_suggestion(findings.suggestion) if setting else ""}
<h2>Limits</h2>{_list(LIMITS)}
<h2>How to reproduce these numbers</h2>{commands}
<p>{escape(source["program"])}, {escape(source["made"])}; the page:
{_link(source["address"])}</p>
</body></html>
"""


def _link(address: str) -> str:
    """A link to a page; text where it is only the query of one."""
    shown = escape(address)
    return f'<a href="{shown}">{shown}</a>' if address.startswith("http") else shown


def _question(setting: Setting) -> str:
    """The system as it was entered, what is asked of it, and the contact that is asked about."""
    numbers = ", ".join(f"{label} = {text}" for label, text, _ in contact_rows(setting)[:3])
    law = FIELDS["law"].choices[setting.law]
    return f"""<h2>System</h2>{_table(system_rows(setting))}
<h2>Question</h2>
<p>Is the motion that a penalty contact shows real, or an artefact of its stiffness K, its damping D or the time step?
Here: {escape(numbers)} steps a period; contact law {escape(law)}; {escape(name_of_method(setting.penalty))}.</p>
{_table(contact_rows(setting))}"""


def _suggestion(lines: Sequence[str]) -> str:
    searched = lines or ("None was searched for: “Suggest K, D, Δτ” on the page does.",)
    return f"<h2>Suggestion</h2>{_list(searched)}"


def _list(lines: Sequence[str]) -> str:
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>"


def _table(rows: Rows) -> str:
    cells = "".join(
        f"<tr><th>{escape(label)}</th><td>{escape(text)}</td><td>{escape(doc)}</td></tr>" for label, text, doc in rows
    )
    return f"<table>{cells}</table>"
