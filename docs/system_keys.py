"""The directive ``system-keys``: every key of a table of a system file, from the code that reads it."""

import re

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from vibroscope.engine.system_file import described_keys

HEADS = "key", "meaning", "unit", "range", "without it"


def rows(table: str) -> list[tuple[str, ...]]:
    """Name, meaning, unit, range and default of each key."""
    found = []
    for name, key in described_keys(table).items():
        default = str(key.default).lower() if isinstance(key.default, bool) else str(key.default)
        found.append((name, key.meaning, key.unit, key.allowed, default))
    return found


class SystemKeys(SphinxDirective):
    """A table of the keys of the table that is the argument."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Make the table."""
        lines = [".. list-table::", "   :header-rows: 1", ""]
        for name, *texts in (HEADS, *rows(self.arguments[0])):
            first = f"``{name}``" if name != HEADS[0] else name
            lines += [f"   * - {first}", *("     - " + re.sub(r"([\\_*|`])", r"\\\1", text) for text in texts)]
        return self.parse_text_to_nodes(StringList(lines, source="system_keys"))


def setup(app: Sphinx) -> dict:
    """Register the directive."""
    app.add_directive("system-keys", SystemKeys)
    return {"parallel_read_safe": True}
