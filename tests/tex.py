"""Formulas of pages, which are TeX, in the notation of docstrings: `plain(r"\\frac{a}{2b_0}")` returns a/(2b₀)."""

import re

NAMES = "alpha beta gamma delta varepsilon zeta eta theta kappa lambda mu nu xi pi rho sigma tau varphi psi omega"
GREEK = dict(zip(NAMES.split(" "), "αβγδεζηθκλμνξπρστφψω", strict=True))
GREEK |= {"Delta": "Δ", "Phi": "Φ", "Lambda": "Λ", "Omega": "Ω"}
SIGNS = {"cdot": " · ", "mp": " ∓ ", "le": " ≤ ", "ge": " ≥ ", "infty": "∞", "circ": "°", "int": "∫"}
SIGNS |= {"oint": " ∮ ", "ldots": "…", "top": "T", "quad": " " * 4, "qquad": " " * 8, ",": " ", ";": " ", " ": " "}
SIGNS |= {"\\": " " * 4, "{": "{", "}": "}"}
FUNCTIONS = {"cos", "sin", "exp", "ln", "max", "min", "sup", "arccos", "arcsin"}
ACCENTS = {"hat": "\u0302", "tilde": "\u0303", "bar": "\u0304", "ddot": "\u0308", "dot": "\u0307"}
SIZES = {"left", "right", "bigl", "bigr", "Bigl", "Bigr"}
LOWER = str.maketrans("0123456789ijmnsuvx", "₀₁₂₃₄₅₆₇₈₉ᵢⱼₘₙₛᵤᵥₓ")
RAISED = dict(zip("0123456789-+njsT", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ⁿʲˢᵀ", strict=True))
TOKEN = re.compile(r"\\([A-Za-z]+|.)|(\d+(?:\.\d+)?)|('+)|(\s+)|(.)", re.DOTALL)
SHARES = {"1/2": "½", "1/4": "¼"}

FACTOR = re.compile(r"(?:d?[A-Za-zΑ-ω][\u0302-\u0304]?(?:_[a-z]|[₀-₉ᵢⱼ]*)′*|\d+|√?\(·*\))[²³]?")


class Converter:
    """Reads TeX token by token; `text` holds what is converted."""

    def __init__(self, tex):
        self.tokens = [found for found in TOKEN.finditer(tex) if not found[4]]
        self.at, self.text = 0, ""

    def argument(self):
        """The next group or token, as TeX."""
        begin, depth = self.at, 0
        while True:
            token = self.tokens[self.at][0]
            depth += (token == "{") - (token == "}")
            self.at += 1
            if depth == 0:
                break
        source = self.tokens[begin].string
        tex = source[self.tokens[begin].start() : self.tokens[self.at - 1].end()]
        return tex[1:-1] if tex[0] == "{" else tex

    def put(self, text):
        """Append it; a letter after the name of a function needs a space."""
        apart = re.search(r"(?:cos|sin|exp|ln|arcosh|arccos|arcsin)[⁰¹²³]?$", self.text) and text.strip()[:1].isalpha()
        self.text += " " * bool(apart) + text

    def convert(self):
        """All of it."""
        while self.at < len(self.tokens):
            found = self.tokens[self.at]
            self.at += 1
            if found[1]:
                self.command(found[1])
            elif found[3]:
                self.text += {1: "′", 2: "″", 3: "‴"}[len(found[3])]
            elif found[0] == "_":
                self.text += lowered(self.argument())
            elif found[0] == "^":
                self.text += raised(self.argument())
            else:
                self.character(found[0])
        return self.text

    def character(self, character):
        """A letter, a number, a bracket or a sign."""
        if character in "+-":
            unary = not self.text.strip() or self.text.rstrip()[-1] in "([,=≤≥·|" or self.text.endswith(" " * 4)
            self.text += {"+": "+", "-": "−"}[character] if unary else {"+": " + ", "-": " − "}[character]
        elif character in "=<>":
            self.text += f" {character} "
        elif character == "&":
            columns = self.tokens[self.at][0] == "&"  # two of them part columns, one is where lines are aligned
            self.at += columns
            self.text += " " * 4 * columns
        elif character not in "{}":
            self.put(character + " " * (character == ","))

    def command(self, name):
        """A command with its arguments."""
        if name in GREEK:
            self.put(GREEK[name])
        elif name in FUNCTIONS:
            self.text += name
        elif name == "sum":
            below = self.tokens[self.at][0] == "_"
            self.at += below
            self.text += f"Σ{lowered(self.argument()) if below else ''} "
        elif name in SIGNS:
            self.text += SIGNS[name]
        elif name in ACCENTS:
            self.put(plain(self.argument()) + ACCENTS[name])
        elif name in ("mathrm", "text"):
            self.put(self.argument().replace("“", '"').replace("”", '"'))
        elif name in ("frac", "tfrac"):
            self.put(fraction(plain(self.argument()), plain(self.argument())))
        elif name == "sqrt":
            inner = plain(self.argument())
            self.put("√" + (inner if len(inner) == 1 else f"({inner})"))
        elif name in ("begin", "end"):
            self.argument()
        elif name not in SIZES:
            raise ValueError(rf"\{name} has no notation in docstrings")


def plain(tex):
    """A formula in the notation of docstrings; ValueError at a command that has none."""
    return Converter(tex).convert()


def fraction(above, below):
    """One on a line: brackets around sums, and around products that divide."""
    if f"{above}/{below}" in SHARES:
        return SHARES[f"{above}/{below}"]
    factors = FACTOR.sub("x", masked(below))
    above = f"({above})" if re.search(" [+−] |^−", masked(above)) else above
    return f"{above}/{below if factors == 'x' else f'({below})'}"


def masked(text):
    """With dots for what brackets hold."""
    depth, outside = 0, ""
    for character in text:
        depth -= character in ")]"
        outside += "·" if depth else character
        depth += character in "(["
    return outside


def lowered(tex):
    """An index: small signs where there are any, one letter after a line."""
    text = re.sub(r"\\mathrm\{?([a-z])\}?|\s", r"\1", tex)
    text = plain(text)
    upright = "mathrm" in tex
    if len(text) == 1 and text not in "0123456789ij∞" and not upright:
        return f"_{text}"
    return text.translate(LOWER)


def raised(tex):
    """A power: small signs where there are any."""
    if tex in ("*", r"\circ"):
        return {"*": "*"}.get(tex, "°")
    text = plain(tex).replace("−", "-").replace(" ", "")
    if all(character in RAISED for character in text):
        return "".join(RAISED[character] for character in text)
    text = SHARES.get(text, text.replace("-", "−"))
    return f"^{text}" if re.fullmatch(r"[\d.]+|¼", text) else f"^({text})"
