"""Words that a code has for a contact, typed on the page: what they say, in the words of another code too."""

import re
from collections.abc import Mapping
from dataclasses import replace

from vibroscope.app.codes.catalogue import Code
from vibroscope.app.codes.contact_words import Around
from vibroscope.app.codes.translation import PHYSICAL, Translation, contact_text, translate, translated_codes
from vibroscope.app.explorer.state import Setting
from vibroscope.app.runtime.number_text import print_number
from vibroscope.engine.law_table import LAWS

KEY = "words"  # of the row that sets what they say
FIELDS = ("mass", "speed")  # what is typed beside them, in SI units
_WORD = re.compile(r"([\w.]+)\s*=\s*(.*?)(?=[\s,;]*(?:[\w.]+\s*=|$))")
_WITHOUT_UNITS = "Choose units under “Units” to set it: these are physical numbers."


def translation(code: Code, chosen: Mapping[str, object], setting: Setting) -> Translation:
    """What is typed of a code; raises ValueError where it says no contact.

    A mass of 0 is that of the bodies, if units are chosen, and a speed of 0 is not known. The step is that of the
    setting.
    """
    given = {word: text.strip("\"'") for word, text in _WORD.findall(str(chosen[KEY]))}
    if not given:
        raise ValueError(f"write its words as name=value, as {example(code)}")
    numbers = {name: chosen[name] or None for name in FIELDS}
    if setting.scale:
        units, system = setting.own_units, setting.system
        if numbers["mass"] is None:
            masses = {"mass": system.mass_share, "lighter": system.lighter_mass}
            numbers |= {name: units.physical("mass", mass) for name, mass in masses.items()}
        numbers["step"] = units.settings(setting.eta, setting.penalty)["time_step"]
        numbers["area"] = units.physical("area", chosen["area"]) or None
    target = translated_codes(write=True).get(str(chosen["target"]), PHYSICAL)
    return translate(code, given, target, Around(**numbers))


def example(code: Code) -> str:
    """Its first words, with their defaults."""
    form = code.contact[0]
    return " ".join(f"{word}={form.defaults.get(word, '...')}" for word in form.words)


def statements(found: Translation) -> list[list[str]]:
    """The translation under heads: what is typed, each way of the other code, and what is not the same."""
    made = found.written if found.target is not PHYSICAL else ()
    lines = [
        [f"What {found.source.name} says", contact_text(found.contact, found.restitution)],
        [f"In {found.target.name}", "; or ".join(each.line for each in made)],
        ["Not the same", "; ".join(dict.fromkeys(text for each in made for text in each.changed))],
        ["Not said", "; ".join(found.unsaid)],
    ]
    return [[head, text] for head, text in lines if text]


def row(found: Translation, setting: Setting) -> dict:
    """The row of the table that sets it, as in `rules.rows_of`."""
    blank = dict.fromkeys(("motion", "total", "holds", "source", "url", "path"), "")
    numbers = [f"{name} = {text}" for name, text in found.contact.texts().items()]
    why = "" if setting.scale else _WITHOUT_UNITS
    title = {"key": KEY, "title": f"Words of {found.source.name}", "claim": "What is typed, in physical numbers."}
    return {**blank, **title, "own": True, "settable": bool(setting.scale), "numbers": numbers, "why": why}


def texts(found: Translation, setting: Setting) -> dict[str, str]:
    """Law, K and D as texts for `app.explorer.reading.read_setting`; raises ValueError where no units are chosen."""
    if setting.scale is None:
        raise ValueError(_WITHOUT_UNITS)
    mass = setting.own_units.physical("mass", setting.system.mass_share)
    contact = found.contact
    if contact.damping is None:
        contact = contact.with_restitution(contact.restitution, Around(mass=mass))
    units = replace(setting.own_units, law=contact.law, exponent=contact.exponent)
    numbers = {
        "K": units.model("contact_stiffness", contact.stiffness),
        "D": units.model("contact_damping", contact.damping),
    }
    if LAWS[contact.law].takes_exponent:
        numbers["exponent"] = contact.exponent
    if contact.penetration is not None:
        numbers["penetration"] = units.model("displacement", contact.penetration)
    given = {name: print_number(float(f"{value:.12g}")) for name, value in numbers.items()}
    return setting.with_contact(given) | {"law": contact.law, "damper": "typed", "stiffness": "typed"}
