"""``vibroscope codes translate``: the contact of one code in physical numbers, and in the words of another code."""

import argparse
from collections.abc import Iterator, Mapping, Sequence

from vibroscope.app.codes.catalogue import Code, codes
from vibroscope.app.codes.contact_words import NEEDED, Around
from vibroscope.app.codes.translation import SAME, Translation, contact_text, translate, translated_codes
from vibroscope.app.commands.numbers import SI, measured
from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report, Row
from vibroscope.engine import written
from vibroscope.engine.arguments import near_names

_WIDTH = 110
_EXAMPLES = """\
examples:
  vibroscope codes translate --from mujoco solref='-1000 -10' --mass '2 kg' --to adams
  vibroscope codes translate --from adams --to drake --mass '1 kg' --speed '1 m/s'
  vibroscope codes translate --from gazebo soft_erp=0.2 soft_cfm=1e-4 --step '1 ms' --to bullet
  vibroscope codes translate --from physical K='1e6 N/m' e=0.75 --mass '1 kg' --to mujoco
"""


def add(command: OneLineParser) -> None:
    """Add the options."""
    words = {key: "; ".join(" ".join(form.words) for form in code.contact) for key, code in translated_codes().items()}
    command.add_argument(
        "--from",
        dest="source",
        nargs="+",
        required=True,
        metavar=("CODE", "WORD=VALUE"),
        help="the code and its words, with units or without; words left out have their defaults. Codes and words: "
        + ", ".join(f"{key} ({text})" for key, text in words.items()),
    )
    targets = ", ".join(translated_codes(write=True))
    command.add_argument("--to", dest="target", required=True, metavar="CODE", help=f"one of {targets}")
    for name, (quantity, meaning, example) in NEEDED.items():
        words = f"{meaning}, in SI units or as '{example}'"
        command.add_argument(f"--{name}", type=measured(quantity), metavar="F", help=words)
    command.add_argument(
        "--same",
        choices=SAME,
        default=SAME[0],
        help="what of the damper stays: its coefficient, where both laws have one of the same kind, or the "
        "restitution (default %(default)s)",
    )
    command.set_defaults(file=SI)


def run(options: argparse.Namespace) -> Report:
    """Translate."""
    key, *words = options.source
    source = _code_of("--from", key, translated_codes())
    target = _code_of("--to", options.target, translated_codes(write=True))
    if wrong := [word for word in words if not word.partition("=")[2].strip()]:
        raise ValueError(f"--from ... {wrong[0][:40]!r} has no value: give it as {wrong[0][:40].rstrip('=')}=...")
    given = {name: text.strip() for name, _, text in (word.partition("=") for word in words)}
    around = Around(**{name: getattr(options, name) for name in NEEDED})
    found = translate(source, given, target, around, options.same)
    indent = max(18, *(len(code.name) + 2 for code in (found.source, found.target)))
    rows = (Row(label, text, _WIDTH, indent) for label, text in _lines(found, words))
    return Report(rows, found.as_dict())


def _code_of(name: str, key: str, known: Mapping[str, Code]) -> Code:
    """The code of an option; raises ValueError that offers the keys of codes that have a name like it."""
    if key in known:
        return known[key]
    named = {word.strip("()"): each for each, code in known.items() for word in (each, *code.name.split())}
    keys = {word.lower(): each for word, each in named.items()}
    near = dict.fromkeys(keys[word] for word in near_names(key.lower(), keys))
    listed = f"the words of {codes()[key].name} for a contact are not known; " if key in codes() else ""
    meant = f"did you mean {' or '.join(near)}? " if near else "" if listed else "there is no such code; "
    raise ValueError(f"{name} {key[:40]!r}: {listed}{meant}give one of {', '.join(known)}")


def _lines(found: Translation, words: Sequence[str]) -> Iterator[tuple[str, str]]:
    """The translation: labels and texts."""
    defaults = [f"{word}={text}" for word, text in found.defaults.items()]
    yield found.source.name, " ".join([*words, *(["by default", *defaults] if defaults else [])])
    yield "contact", contact_text(found.contact, found.restitution)
    for each in found.written:
        yield found.target.name, each.line
        units = ", ".join(f"{word} {each.words[word]} {unit}" for word, unit in each.units.items())
        known = "" if each.restitution is None else f"restitution {written(each.restitution)}"
        yield "", "; ".join(filter(None, (units, known))) or "no number has a unit"
        yield from (("  not the same", text) for text in each.changed)
    yield from (("not said", text) for text in found.unsaid)
    yield from (("not written", text) for text in found.left_out)


TRANSLATE = Command(
    "the contact of one code in the words of another",
    "Read the words that a code has for a contact, print the stiffness, damper, exponent and restitution that they "
    "say, and write these in the words of another code. What is not the same, and what one of the codes cannot say, is "
    "named.",
    _EXAMPLES,
    add,
    run,
    "one JSON object",
)
