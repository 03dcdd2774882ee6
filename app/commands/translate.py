"""``vibroscope codes translate``: the contact of one code in physical numbers, and in the words of another code."""

import argparse
from collections.abc import Callable, Iterator, Sequence

from vibroscope.app.commands.parser import Command, OneLineParser
from vibroscope.app.commands.report import Report, Row

_WIDTH = 110
_OF_CODE = "CODE"
_EXAMPLES = """\
examples:
  vibroscope codes translate --from mujoco solref='-1000 -10' --mass '2 kg' --to adams
  vibroscope codes translate --from adams --to drake --mass '1 kg' --speed '1 m/s'
  vibroscope codes translate --from gazebo soft_erp=0.2 soft_cfm=1e-4 --step '1 ms' --to bullet
  vibroscope codes translate --from physical K='1e6 N/m' e=0.75 --mass '1 kg' --to mujoco
"""


def add(command: OneLineParser) -> None:
    """Add the options."""
    from vibroscope.app.codes.contact_words import NEEDED
    from vibroscope.app.codes.translation import SAME, translated_codes

    command.add_argument(
        "--from",
        dest="source",
        nargs="+",
        required=True,
        metavar=(_OF_CODE, "WORD=VALUE"),
        help=f"the code and its words, with units or without; words left out have their defaults. Codes and words: "
        f"{'; '.join(map(_words_of, translated_codes().values()))}",
    )
    command.add_argument(
        "--to", dest="target", required=True, choices=tuple(translated_codes(write=True)), metavar=_OF_CODE
    ).help = f"the other code: {', '.join(translated_codes(write=True))}"
    for name, (quantity, meaning, example) in NEEDED.items():
        command.add_argument(
            f"--{name}", type=_physical(name, quantity), metavar="F", help=f"{meaning}, such as '{example}'; SI units"
        )
    command.add_argument(
        "--same",
        choices=SAME,
        default=SAME[0],
        help="what of the damper stays: its coefficient, where both laws have one of the same kind, or the "
        "restitution (default %(default)s)",
    )


def _words_of(code) -> str:
    return f"{code.key} ({'; '.join(' '.join(form.words) for form in code.contact)})"


def _physical(name: str, quantity: str) -> Callable[[str], float]:
    """A reader of a positive number in SI units, or with a unit."""

    def read(text: str) -> float:
        from vibroscope.app.codes.contact_words import read_quantity
        from vibroscope.engine import QUANTITIES

        try:
            return read_quantity(name, text, quantity, unit=QUANTITIES[quantity].units[0])
        except ValueError as problem:
            raise argparse.ArgumentTypeError(str(problem)) from None

    return read


def run(options: argparse.Namespace) -> Report:
    """Translate."""
    from vibroscope.app.codes.contact_words import NEEDED, Around
    from vibroscope.app.codes.translation import translate, translated_codes

    key, *words = options.source
    known = translated_codes()
    if key not in known:
        raise ValueError(f"--from {key[:40]!r} is no code whose words are known: give one of {', '.join(known)}")
    around = Around(**{name: getattr(options, name) for name in NEEDED})
    found = translate(known[key], _given(words), known[options.target], around, options.same)
    return Report(_lines(found, words), found.as_dict())


def _given(words: Sequence[str]) -> dict[str, str]:
    """The words by name; raises ValueError for one without a value."""
    pairs = [word.partition("=") for word in words]
    if wrong := [name for name, mark, text in pairs if not (mark and text.strip())]:
        raise ValueError(f"--from ... {wrong[0][:40]!r} has no value: give it as {wrong[0][:40]}=...")
    return {name: text.strip() for name, _, text in pairs}


def _lines(found, words: Sequence[str]) -> Iterator[Row]:
    """The translation."""
    from vibroscope.app.codes.translation import contact_text
    from vibroscope.engine import written

    defaults = [f"{word}={text}" for word, text in found.defaults.items()]
    given = " ".join([*words, *(["by default", *defaults] if defaults else [])])
    yield Row(found.source.name, given, _WIDTH, _indent(found))
    yield Row("contact", contact_text(found.contact, found.restitution), _WIDTH, _indent(found))
    for each in found.written:
        yield Row(found.target.name, each.line, _WIDTH, _indent(found))
        units = ", ".join(f"{word} {each.words[word]} {unit}" for word, unit in each.units.items())
        known = "" if each.restitution is None else f"restitution {written(each.restitution)}"
        if units or known:
            yield Row("", "; ".join(filter(None, (units, known))), _WIDTH, _indent(found))
        for text in each.changed:
            yield Row("  not the same", text, _WIDTH, _indent(found))
    for text in found.unsaid:
        yield Row("not said", text, _WIDTH, _indent(found))
    for text in found.left_out:
        yield Row("not written", text, _WIDTH, _indent(found))


def _indent(found) -> int:
    return max(18, len(found.source.name) + 2, len(found.target.name) + 2)


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
