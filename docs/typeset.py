r"""Displayed formulas as MathML, which browsers typeset without a script.

Pages hold TeX in blocks of the language "math", as GitHub does. The number of a formula, ``\tag{16}``, stands at its
right, and ``#eq-16`` leads to it.
"""

import re

from docutils.nodes import SkipNode
from docutils.utils.math import MathError
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.errors import SphinxError

TAG = re.compile(r"\\tag\{(\d+)\}")
PRIMES = re.compile(r"('+)(?:\^(\{[^}]*\}|\\?\w+|[+-]))?")
ACCENTED = re.compile(r"(\\(?:tilde|hat|bar|d?dot)\{[^}]*\})_")


def mathml(tex: str, as_block: bool = True) -> str:
    """TeX as MathML.

    Primes become superscripts, since docutils sets them on the line, and the index of a letter with an accent gets a
    base of its own, since docutils sets it below the letter.

    Raises SphinxError where docutils does not know a command.
    """
    raised = PRIMES.sub(lambda found: "^{" + r"\prime" * len(found[1]) + f" {found[2] or ''}}}", tex)
    raised = ACCENTED.sub(r"\1{}_", raised)
    try:
        return tex2mathml(raised.strip(), as_block).replace("<mi>′</mi>", '<mi class="prime">′</mi>')
    except MathError as error:
        raise SphinxError(f"{error} In the formula {tex}") from None


def visit_inline(page, node) -> None:
    """Write a formula in a line of text."""
    page.body.append(mathml(node.astext(), as_block=False))
    raise SkipNode


def visit_block(page, node) -> None:
    """Write a formula with its number, if it has one."""
    tex = node.astext()
    number = TAG.search(tex)
    name = f' id="eq-{number[1]}"' if number else ""
    page.body.append(f'<div class="formula" tabindex="0"{name}>{mathml(TAG.sub("", tex))}')
    if number:
        page.body.append(f'<a class="formula-number" href="#eq-{number[1]}">({number[1]})</a>')
    page.body.append("</div>\n")
    raise SkipNode


def setup(app) -> dict:
    """Make it the way in which formulas are written."""
    app.add_html_math_renderer("mathml", (visit_inline, None), (visit_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
