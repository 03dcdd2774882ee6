"""The directive ``gallery``: the scenes of the paper and the shelf of systems, each with its verdict and figure."""

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from vibroscope.app.explorer.compute import run_length
from vibroscope.app.explorer.presets import scenes, shelf
from vibroscope.app.explorer.state import Setting
from vibroscope.app.export.scripts import as_command
from vibroscope.engine import Comparison, ComparisonQuestion, compare, verdict


def settings() -> dict[str, Setting]:
    """The setting of each scene and of each system of the shelf, by key."""
    return {key: each.setting for key, each in (scenes() | shelf()).items()}


def comparison(setting: Setting) -> Comparison:
    """Both solutions, compared as the page does it."""
    how = {"reference": setting.reference, "initial": None if setting.from_rest else setting.initial}
    how |= run_length(setting.system, setting.eta, setting.initial)
    return compare(ComparisonQuestion(setting.system, setting.eta, setting.penalty, **how))


class Gallery(SphinxDirective):
    """One entry for each key of ``scenes`` or ``shelf``, which is the argument."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        """Make the entries."""
        entries = {"scenes": scenes, "shelf": shelf}[self.arguments[0]]()
        most = self.config.gallery_computed
        lines = [
            line for place, (key, entry) in enumerate(entries.items()) for line in self._lines(key, entry, place < most)
        ]
        holder = nodes.section()
        holder.document = self.state.document
        self.state.nested_parse(StringList(lines, "gallery"), 0, holder, match_titles=True)
        return holder.children

    def _lines(self, key: str, entry, computed: bool) -> list[str]:
        setting = settings()[key]
        return [
            f".. rubric:: {entry.title}",
            "",
            entry.caption,
            "",
            *(self._computed(key, entry, setting) if computed else ()),
            *([f"Source: {entry.tooltip}", ""] if entry.key in shelf() else []),
            ".. code-block:: sh",
            "",
            *(f"   {line}" for line in as_command(setting).splitlines()),
            "",
        ]

    def _computed(self, key: str, entry, setting: Setting) -> list[str]:
        said = verdict(comparison(setting))
        texts = [text.replace("|", r"\|").replace("*", r"\*") for text in (said.headline, *said.details)]
        figure = [f".. plot:: figures/entries.py entry_{key}", f"   :alt: Phase plots of {entry.title}", ""]
        return figure + [line for text in texts for line in (text, "")]


def setup(app: Sphinx) -> dict:
    """Register the directive, and of how many entries of each list it computes figure and verdict."""
    app.add_config_value("gallery_computed", 1000, "env")
    app.add_directive("gallery", Gallery)
    return {"parallel_read_safe": True}
