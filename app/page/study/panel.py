"""The panel beside the figures of a study: choices, progress, a key of the colours, and statements in words."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

import param
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.field_units import ShownField
from vibroscope.app.explorer.typed import read_shown_number, read_typed_number
from vibroscope.app.page.shared.component import Component

LONGEST_TEXT = 200


class StudyPanel(Component):
    """Native inputs; every message from them is checked against ``spec``."""

    spec = param.Dict(
        doc="Title, hint, switches (name, label, choices), limits and numbers (name, label, low, high; of mode text "
        "one is a text, of any words; one that may be empty is None then), cursor, file (label, drop, largest)"
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
    sheets = (
        "shared/scroll_cue",
        "shared/upload",
    )

    def __init__(
        self, spec: dict, chosen: dict, on_choice: Callable[[dict], None], on_stop: Callable[[bool], None], **params
    ) -> None:
        super().__init__(spec=spec, chosen=chosen, css_classes=["study"], sizing_mode="stretch_width", **params)
        self._fields: dict[str, ShownField] = {}  # of the numbers that have a unit
        self.listen(stop=(bool, on_stop), choose=(dict, lambda wanted: on_choice(self.allowed(wanted))))

    def show_fields(self, fields: dict[str, ShownField], while_empty: Mapping[str, str] = MappingProxyType({})) -> None:
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
        """The present choices, changed as far as the switches and limits allow the wanted ones."""
        chosen = dict(self.chosen)
        for switch in self.spec["switches"]:
            value = wanted.get(switch["name"])
            if isinstance(value, str) and value in switch["choices"]:
                chosen[switch["name"]] = value
        for limit in self.spec["limits"]:
            value = wanted.get(limit["name"])
            if type(value) in (int, float) and limit["low"] <= value <= limit["high"]:
                chosen[limit["name"]] = round(value)
        return chosen | self._typed(wanted)

    def _typed(self, wanted: dict) -> dict[str, float | str | None]:
        """The numbers that were typed, and texts as they are; says why a number is refused."""
        found, self.refused = {}, ""
        for number in self.spec["numbers"]:
            if number["name"] not in wanted:
                continue
            field = self._fields.get(number["name"])
            if number.get("mode") == "text":
                found[number["name"]] = str(wanted[number["name"]])[:LONGEST_TEXT]
                continue
            if number.get("empty") and not str(wanted[number["name"]]).strip():
                found[number["name"]] = None
                continue
            label, bounds, whole = number["label"], (number["low"], number["high"]), number["whole"]
            given = wanted[number["name"]]
            try:
                if field:
                    text = read_shown_number(label, given, field, bounds, whole, not field.unit)
                else:
                    text = read_typed_number(label, given, bounds, whole=whole)
            except Refused as error:
                self.refused = str(error)
            else:
                found[number["name"]] = int(text) if whole else float(text)
        return found
