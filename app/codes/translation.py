"""What a code writes for one contact, in the words of another code: `contact_words` says how each is read and written.

Where the dampers of both laws are of one kind, K and c stay. Else, and where it is asked for, the damper keeps the
restitution; a spring of another exponent keeps the deepest penetration. Both take the mass and the closing speed, by
the relations of :mod:`engine.contact`.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from vibroscope.app.codes.catalogue import Code, codes
from vibroscope.app.codes.contact_words import Around, Contact, Form, Missing
from vibroscope.app.explorer.parameters import LAW_NAMES
from vibroscope.engine import written
from vibroscope.engine.arguments import one_of
from vibroscope.engine.law_table import LAWS, deepest_penetration, powers_of

SAME = ("numbers", "restitution")
# The middle, as if it were a code.
PHYSICAL = Code(
    "physical",
    "Physical numbers",
    contact=(
        Form({"K": "contact_stiffness", "c": "contact_damping"}, "kelvin-voigt", "K = {K}, c = {c}"),
        Form({"K": "contact_stiffness", "e": "restitution"}, "cut", "K = {K}, e = {e}"),
    ),
)


class Unsaid(ValueError):
    """The words of a code cannot say a contact."""


@dataclass(frozen=True)
class Written:
    """A contact in words of the other code.

    Attributes
    ----------
    form : Form
    contact : Contact
        What these words say, in SI units.
    words : dict of str to str
    restitution : float or None
        Of that contact; None where the mass or the closing speed that it depends on is not given.
    changed : tuple of str
        What is not the same, in words.
    """

    form: Form
    contact: Contact
    words: dict[str, str]
    restitution: float | None
    changed: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """Plain values for JSON."""
        values = {name: value for name, value in vars(self).items() if name != "form"}
        return values | {"contact": vars(self.contact), "line": self.line, "units": self.units}

    @property
    def line(self) -> str:
        """The line of an input."""
        return self.form.text.format(**self.words)

    @property
    def units(self) -> dict[str, str]:
        """The unit of each word that has one."""
        return {word: unit for word in self.words if (unit := self.form.unit(word, self.contact))}


@dataclass(frozen=True)
class Translation:
    """A contact in the words of two codes.

    Attributes
    ----------
    source, target : Code
    defaults : dict of str to str
        The words of the source that were not given.
    contact : Contact
        In SI units.
    restitution : float or None
        As in `Written`.
    written : tuple of Written
        In each way in which the target says a contact.
    unsaid : tuple of str
        What the target cannot say, and what it has that the source does not say.
    left_out : tuple of str
        Ways of the target for which a number is not given, or out of their range.
    """

    source: Code
    target: Code
    defaults: dict[str, str]
    contact: Contact
    restitution: float | None
    written: tuple[Written, ...]
    unsaid: tuple[str, ...]
    left_out: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """Plain values for JSON."""
        values = {name: value for name, value in vars(self).items() if name not in ("source", "target")}
        parts = {"contact": vars(self.contact), "written": [each.as_dict() for each in self.written]}
        return {"from": self.source.key, "to": self.target.key} | values | parts


def translated_codes(write: bool = False) -> dict[str, Code]:
    """The codes whose words are known, by key; with ``write`` those into which a contact can be translated."""
    known = {PHYSICAL.key: PHYSICAL, **codes()}
    return {key: code for key, code in known.items() if (_writable(code) if write else code.contact)}


def translate(source: Code, given: Mapping[str, str], target: Code, around: Around, same: str = SAME[0]) -> Translation:
    """What the words of one code are in another.

    Parameters
    ----------
    source, target : Code
        With words for a contact, `Code.contact`.
    given : mapping of str to str
        Words of the source, as typed; of those left out their defaults are taken.
    around : Around
    same : str
        Of `SAME`: what of the damper stays the same where both laws have one of the same kind.

    Raises
    ------
    ValueError
        If a word is unknown or out of range, or a number is needed that is not given.

    Examples
    --------
    >>> from vibroscope.app.codes.catalogue import codes
    >>> found = translate(codes()["mujoco"], {"solref": "-1000 -10"}, codes()["gazebo"], Around(mass=2.0))
    >>> found.written[0].line
    '<kp>2000</kp> <kd>20</kd>'
    """
    one_of("same", same, SAME)
    form = _form_of(source, given)
    contact = form.read(given, around)
    found, left_out = [], {}
    for each in _writable(target):
        try:
            found.append(_write(each, contact, around, same, (source.name, target.name)))
        except (Missing, Unsaid) as problem:
            left_out[" and ".join(each.words)] = problem
    if not found:
        raise next(iter(left_out.values()), ValueError(f"{target.name} has no words for a contact"))
    defaults = {word: text for word, text in form.defaults.items() if word not in given}
    unsaid = [f"{code.name} alone has {text}" for code in (source, target) for text in code.alone]
    texts = tuple(f"{words}: {problem}" for words, problem in left_out.items())
    known = _restitution(contact, around)
    return Translation(source, target, defaults, contact, known, tuple(found), tuple(dict.fromkeys(unsaid)), texts)


def contact_text(contact: Contact, restitution: float | None) -> str:
    """A contact in words: law, numbers, and the restitution where it is known."""
    numbers = ", ".join(f"{name} = {text}" for name, text in contact.texts().items())
    known = "" if restitution is None else f"; restitution {written(restitution)}"
    return f"{LAW_NAMES[contact.law]}: {numbers}{known}"


def _writable(code: Code) -> tuple[Form, ...]:
    return tuple(form for form in code.contact if form.writable)


def _form_of(code: Code, given: Mapping[str, str]) -> Form:
    """The first form of a code that has all these words; raises ValueError with those that it has."""
    found = next((form for form in code.contact if set(given) <= set(form.words)), None)
    if found is None:
        ways = "; or ".join(" ".join(form.words) for form in code.contact)
        raise ValueError(f"{code.name} says no contact with {' '.join(given)[:60]}: give {ways}")
    return found


def _restitution(contact: Contact, around: Around) -> float | None:
    try:
        return contact.restitution_at(around)
    except Missing:
        return None


def _write(form: Form, contact: Contact, around: Around, same: str, names: tuple[str, str]) -> Written:
    """A contact in the words of a form, with what its law changes."""
    exponent = contact.exponent if form.word_of("exponent") and LAWS[form.law].takes_exponent else form.exponent
    fitted = replace(contact, law=form.law, exponent=exponent, penetration=None)
    changed = []
    if exponent != contact.exponent:
        mass, speed = around.need("mass"), around.need("speed")
        depth = deepest_penetration(contact.stiffness, mass, speed, contact.exponent)
        fitted = replace(fitted, stiffness=0.5 * (exponent + 1.0) * mass * speed**2 / depth ** (exponent + 1.0))
        what = f"the exponent {written(exponent)} stands for {written(contact.exponent)}"
        same_depth = f"the same deepest penetration, {written(1e3 * depth)} mm at {speed:g} m/s"
        changed.append(f"{what}: without dampers K gives {same_depth}")
    if LAWS[form.law].penetration:
        own = form.default_of("penetration")
        fitted = replace(fitted, penetration=contact.penetration or own)
        if contact.penetration is None:
            changed.append(f"the damper acts in full from {written(1e3 * own)} mm on; in {names[0]} from the touch on")
    elif contact.penetration is not None:
        changed.append(
            f"the damper acts from the touch on, not in full from {written(1e3 * contact.penetration)} mm on"
        )
    kept = powers_of(form.law, exponent) == powers_of(contact.law, contact.exponent)
    kept = kept and contact.restitution is None and same == SAME[0]
    if form.says_restitution:
        fitted = replace(fitted, restitution=contact.restitution_at(around), damping=None)
    elif not kept:
        e = contact.restitution_at(around)
        fitted = fitted.with_restitution(e, around)
        changed.append(f"c is another: it gives the same restitution, {written(e)}")
    words, after = _readable(form, form.write(fitted, around), around), _restitution(fitted, around)
    if fitted.restitution is not None:  # words that are made for one may give another
        asked, after = after, _given(form, words, around)
        made_for = asked
        if same == SAME[1] and written(asked, 3) != written(after, 3):
            made_for = _made_for(form, fitted, around)
            words = form.write(replace(fitted, restitution=made_for), around)
            after = _given(form, words, around)
        if same == SAME[1] and written(asked, 3) != written(after, 3):
            changed.append(f"its formulas give no restitution below {written(after)}")
        elif written(made_for, 3) != written(after, 3):
            changed.append(f"its formulas are for the restitution {written(made_for, 3)}; it gives {written(after)}")
    if form.law != contact.law and contact.restitution is None:
        changed.append(_other_law(form.law, contact, names, _restitution(contact, around), after))
    return Written(form, fitted, words, after, tuple(changed))


def _readable(form: Form, words: dict[str, str], around: Around) -> dict[str, str]:
    """The words; raises `Unsaid` where they would be refused if they were read."""
    try:
        form.read(words, around)
    except Missing:  # what it says of the contact depends on more than the words
        return words
    except ValueError as problem:
        raise Unsaid(f"this contact is beyond these words: {problem}") from None
    return words


def _given(form: Form, words: Mapping[str, str], around: Around) -> float | None:
    return _restitution(form.read(words, around), around)


def _made_for(form: Form, fitted: Contact, around: Around) -> float:
    """The restitution for which the formulas of a form give that of a contact, or the nearest that they do."""
    low, high = 0.0, 1.0
    while high - low > 1e-9:
        middle = 0.5 * (low + high)
        words = form.write(replace(fitted, restitution=middle), around)
        low, high = (low, middle) if _given(form, words, around) > fitted.restitution else (middle, high)
    return high


def _other_law(law: str, contact: Contact, names: tuple[str, str], before: float | None, after: float | None) -> str:
    """That the laws differ, and what that does to the restitution, as far as it is known."""
    text = f"the law is {LAW_NAMES[law]} in {names[1]}, {LAW_NAMES[contact.law]} in {names[0]}"
    if before is None or after is None or written(before, 3) == written(after, 3):
        return text
    return f"{text}: the restitution is {written(after, 3)} in place of {written(before, 3)}"
