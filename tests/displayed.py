"""Displayed formulas: where they stand in pages and docstrings, and what one is for the numbers of its symbols.

Pages display TeX, which `tests/tex.py` reads; docstrings have a notation of one line, which `value` evaluates.
"""

import ast
import functools
import math
import re
from pathlib import Path

import numpy as np

from tests.tex import plain

ROOT = Path(__file__).parents[1]
FUNCTIONS = {"max": max, "min": min, "exp": math.exp, "cos": math.cos, "ln": math.log, "arccos": math.acos}
FUNCTIONS |= {"arcsin": math.asin, "arcosh": math.acosh, "√": math.sqrt}
NUMBERS = {"π": math.pi, "½": 0.5, "¼": 0.25}
POWERS = {"²": 2.0, "³": 3.0, "⁻¹": -1}
COMPARED = set()  # numbers of the formulas that a test compares with the code, of all modules that are imported
BLOCK = re.compile(r"^ *```math\n(.*?)^ *```", re.MULTILINE | re.DOTALL)  # of a page, in TeX
TAG = re.compile(r" \\tag\{(\d+)\}")
NUMBERED = re.compile(r"\((\d+)\)[.,]? *$", re.MULTILINE)


def shown(text):
    """The numbered formulas of a docstring by number: the lines of a block that end with the number, as one."""
    found = {}
    for block in re.findall(r"(?:^ {4,}.+\n?)+", text, re.MULTILINE):
        lines = []
        for line in block.splitlines():
            number = NUMBERED.search(line.rstrip())
            lines.append(line[: number.start()] if number else line)
            if number:
                found.setdefault(int(number[1]), []).append("    ".join(one.strip() for one in lines))
                lines = []
    return found


class Formulas(dict):
    """Formulas by number, which notes in `read` the numbers that were asked for."""

    read = set()  # noqa: RUF012 - of all pages, since a test asks those of its own module

    def __getitem__(self, number):
        self.read.add(number)
        return super().__getitem__(number)


def compares(*numbers):
    """A test that compares these formulas with the code; one that has read no such formula at its end fails.

    Where the test has an argument `number`, it compares that one alone.
    """
    COMPARED.update(numbers)

    def decorate(test):
        @functools.wraps(test)
        def checked(**arguments):
            Formulas.read.clear()
            test(**arguments)
            wanted = {arguments["number"]} if "number" in arguments else set(numbers)
            assert wanted <= set(numbers)
            assert wanted <= Formulas.read, f"{wanted - Formulas.read} not read"

        return checked

    return decorate


@functools.cache
def of_pages():
    """The formulas of the theory by number, in the notation of docstrings; each number stands in one place."""
    found = Formulas()
    for page in (ROOT / "docs/theory").glob("*.md"):
        for tex in BLOCK.findall(page.read_text()):
            number = TAG.search(tex)
            if number:
                assert int(number[1]) not in found, f"({number[1]}) stands twice"
                found[int(number[1])] = plain(TAG.sub("", tex))
    return found


@functools.cache
def of_docstrings():
    """The formulas of the engine's docstrings by number."""
    found = {}
    for text in (path.read_text() for path in (ROOT / "engine").rglob("*.py")):
        for node in ast.walk(ast.parse(text)) if NUMBERED.search(text) else ():
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef):
                for number, formulas in shown(ast.get_docstring(node) or "").items():  # and lines of text that end so
                    found.setdefault(number, []).extend(one for one in formulas if re.search("[=≤≥]", one))
    return found


def parts(formula):
    """What a line says: equations and conditions that gaps separate, without the words for a law."""
    pieces = [piece.strip(" .,") for piece in re.split(r" {3,}", formula)]
    return [piece for piece in pieces if re.search("[=≤≥]", piece) and '"' not in piece] or pieces[:1]


class Matrix:
    """A matrix whose products side by side are those of matrices; `rows`: its numbers.

    A number that is added to it stands for so many times the unit matrix.
    """

    def __init__(self, rows):
        self.rows = np.asarray(rows)

    def _times_unit(self, other):
        return other.rows if isinstance(other, Matrix) else other * np.eye(len(self.rows))

    def __mul__(self, other):
        return Matrix(self.rows @ other.rows)

    def __rmul__(self, number):
        return Matrix(number * self.rows)

    def __truediv__(self, number):
        return Matrix(self.rows / number)

    def __add__(self, other):
        return Matrix(self.rows + self._times_unit(other))

    def __sub__(self, other):
        return Matrix(self.rows - self._times_unit(other))

    __radd__ = __add__

    def __neg__(self):
        return Matrix(-self.rows)

    def __pow__(self, power):
        return Matrix(np.linalg.matrix_power(self.rows, int(power)))

    def __abs__(self):
        return float(np.linalg.norm(self.rows))


class Reader:
    """Reads an expression as it is displayed: products side by side, powers and indices as they are set.

    A function without brackets has what follows without a space as its argument, and √ the next factor. A character
    that is no symbol, number or sign raises ValueError.
    """

    def __init__(self, text, symbols):
        self.text, self.at, self.bars, self.symbols = text, 0, 0, NUMBERS | symbols
        names = sorted((*self.symbols, *FUNCTIONS), key=len, reverse=True)
        self.name = re.compile("|".join(map(re.escape, names)))

    def next_is(self, characters):
        """Whether the next character is one of these."""
        return self.text[self.at : self.at + 1] in tuple(characters)

    def take(self, pattern):
        """What matches here, or None."""
        found = re.compile(pattern).match(self.text, self.at)
        self.at = found.end() if found else self.at
        return found and found[0]

    def need(self, pattern):
        """What has to match here."""
        found = self.take(pattern)
        if found is None:
            raise ValueError(f"{self.text[self.at :]!r} in {self.text!r} is no notation that is known")
        return found

    def sum(self):
        """Terms with signs."""
        self.take(" *")
        total = -self.product() if self.take("−") else self.product()
        while sign := self.take(" *[+−] *"):
            total = total + (self.product() if "+" in sign else -self.product())
        self.take(" *")
        return total

    def product(self, tight=False):
        """Factors side by side; a tight product ends at the first space."""
        value = self.factor()
        while not (tight and self.next_is(" /·")):
            mark = self.at
            sign = self.take(r" *(/|·) *") or self.take(" *")
            if "/" in sign:
                value = value / self.factor()
            elif "·" in sign or self.begins_a_factor():
                value = value * self.factor()
            else:
                self.at = mark
                break
        return value

    def begins_a_factor(self):
        """Whether a name, a number or a bracket follows."""
        follows = self.name.match(self.text, self.at) or self.next_is("([0123456789")
        return bool(follows) or (self.next_is("|") and not self.bars)

    def factor(self):
        """An atom with its powers."""
        value = self.atom()
        while True:
            if raised := self.take("[²³ⁿ]|⁻¹"):
                value **= POWERS[raised] if raised in POWERS else self.symbols["n"]
            elif self.take(r"\^"):
                value **= self.atom()
            else:
                return value

    def atom(self):
        """A number, a symbol, a bracket, a magnitude or a function."""
        if self.next_is("(["):
            return self.bracket()[0]
        if self.take(r"\|"):
            self.bars += 1
            value = self.sum()
            self.bars -= 1
            self.need(r"\|")
            return abs(value)
        if number := self.take(r"\d+(\.\d+)?"):
            return float(number)
        name = self.need(self.name)
        return self.function(name) if name in FUNCTIONS or callable(self.symbols[name]) else self.symbols[name]

    def bracket(self):
        """The values in a bracket."""
        self.need(r"[(\[]")
        values = [self.sum()]
        while self.take(","):
            values.append(self.sum())
        self.need(r"[)\]]")
        return values

    def function(self, name):
        """A function of its argument, perhaps with a power of its own."""
        raised = self.take("[²³]")
        if self.next_is("(["):
            values = self.bracket()
        else:
            self.take(" ")
            values = [self.factor() if name == "√" else self.product(tight=True)]
        return (FUNCTIONS | self.symbols)[name](*values) ** POWERS.get(raised, 1)


def value(text, symbols):
    """The number of a displayed expression, for the numbers of its symbols; a function is a symbol, too."""
    reader = Reader(text, symbols)
    found = reader.sum()
    reader.need("$")
    return found


def sides(formula, which=0):
    """Left-hand and right-hand side of one of the equations of a line."""
    left, _, right = parts(formula)[which].partition(" = ")
    return left, right
