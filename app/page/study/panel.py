"""The panel beside the figures of a study: choices, progress, a key of the colours, and statements in words."""

from collections.abc import Callable, Mapping, Sequence

import param
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.field_units import ShownField
from vibroscope.app.explorer.link import ViewChoice
from vibroscope.app.explorer.reading import read_choice
from vibroscope.app.explorer.typed import read_shown_number, read_typed_number
from vibroscope.app.page.shared.component import Component

LONGEST_TEXT = 200


class StudyPanel(Component):
    """Native inputs; every message from them is checked against the `ViewChoice` that it is about."""

    spec = param.Dict(
        doc="Title, hint, figures; switches (name, label, choices) and numbers (name, label, mode, when); where there "
        "are such also cursor, file (label, drop, largest), and aligned figures"
    )
    chosen = param.Dict(doc="What is chosen, by name")
    status = param.Dict(default={}, doc="How far: text, share, running")
    file = param.String(default="", doc="Name of the file that was chosen last")
    refused = param.String(default="", doc="Why the number that was typed last is not taken")
    fields = param.Dict(default={}, doc="How numbers that have a unit are shown: label, name, factor")
    away = param.Dict(default={}, doc="Choices of each switch, and names of numbers, that do not apply to the system")
    key_title = param.String(default="", doc="What the colours stand for")
    key = param.List(default=[], doc="Colour, name and pattern of each class")
    statements = param.List(default=[], doc="Head and text of what the figures say")

    script = "study/study"
    sheets = ("shared/scroll_cue", "shared/upload")

    def __init__(
        self,
        choices: Sequence[ViewChoice],
        spec: dict,
        chosen: dict,
        on_choice: Callable[[dict], None],
        on_stop: Callable[[bool], None],
    ) -> None:
        self._choices = [each for each in choices if each.shown]
        self._fields: dict[str, ShownField] = {}  # of the numbers that have a unit
        super().__init__(
            spec=spec | _rows(self._choices), chosen=chosen, css_classes=["study"], sizing_mode="stretch_width"
        )
        self.listen(stop=(bool, on_stop), choose=(dict, lambda wanted: on_choice(self.allowed(wanted))))

    def show_fields(self, fields: dict[str, ShownField], while_empty: Mapping[str, str]) -> None:
        """Show these numbers in the units that are chosen; what is chosen stays in those of the model.

        ``while_empty``: texts of the numbers that hold where a field is empty, by name.
        """
        self._fields = fields
        self.fields = {
            name: {"label": field.label, "name": field.name.removeprefix(", "), "factor": field.factor}
            | ({"empty": while_empty[name]} if name in while_empty else {})
            for name, field in fields.items()
        }

    def allowed(self, wanted: dict) -> dict:
        """The present choices, changed as far as the wanted ones are allowed; says why one is not."""
        chosen, self.refused = dict(self.chosen), ""
        for each in self._choices:
            if each.name in wanted:
                try:
                    chosen[each.name] = self._read(each, wanted[each.name])
                except Refused as error:
                    self.refused = str(error)
        return chosen

    def _read(self, choice: ViewChoice, given: object) -> float | str | None:
        """What is chosen, or typed; raises `Refused`."""
        if choice.words:
            return read_choice(choice.name, given, list(choice.words))
        if not choice.bounds:
            return str(given)[:LONGEST_TEXT]
        if choice.first is None and not str(given).strip():
            return None
        if field := self._fields.get(choice.name):
            text = read_shown_number(choice.label, given, field, choice.bounds, choice.whole, not field.unit)
        else:
            text = read_typed_number(choice.label, given, choice.bounds, whole=choice.whole)
        return int(text) if choice.whole else float(text)


def _rows(choices: Sequence[ViewChoice]) -> dict[str, list[dict]]:
    """The choices for the browser."""
    switches = [each for each in choices if each.words]
    numbers = [each for each in choices if not each.words]
    return {
        "switches": [{"name": each.name, "label": each.label, "choices": dict(each.words)} for each in switches],
        "numbers": [
            {
                "name": each.name,
                "label": each.label,
                "mode": "decimal" if each.bounds else "text",
                "when": dict(each.when),
            }
            for each in numbers
        ],
    }
