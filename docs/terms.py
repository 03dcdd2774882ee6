"""The directive ``terms``: the words of a table of ``assets/glossary.toml``, each with its explanation."""

import re
import tomllib
from pathlib import Path

from docutils import nodes
from docutils.nodes import make_id
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

DOCS = Path(__file__).parent


def source_of(address: str) -> str:
    """The page and heading from which a section of the site is made."""
    place, _, wanted = address.partition("#")
    page = f"{place.removesuffix('.html')}.md"
    titles = re.findall(r"^#+ (.*)$", (DOCS / page).read_text(encoding="utf-8"), re.MULTILINE)
    slugs = {make_id(title): re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}
    return f"{page}#{slugs[wanted]}" if wanted else page


def paragraphs(table: str) -> list[str]:
    """Each word with its explanation and, of a term of the page, a link to what says more."""
    terms = tomllib.loads((DOCS.parent / "assets/glossary.toml").read_text(encoding="utf-8"))[table]
    if table == "code":
        return [f"**{head}**: {text}" for head, text in terms.items()]
    return [f"**{term['head']}**: {term['text']} ([more]({source_of(term['read'])}))." for term in terms]


class Terms(SphinxDirective):
    """The words of the table that is the argument, as paragraphs in Markdown."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Make the paragraphs."""
        lines = "\n\n".join(paragraphs(self.arguments[0])).splitlines()
        return self.parse_text_to_nodes(StringList(lines, source="terms"))


def setup(app: Sphinx) -> dict:
    """Register the directive."""
    app.add_directive("terms", Terms)
    return {"parallel_read_safe": True}
