"""How the documentation is built (`make docs`): Sphinx from Markdown, with its figures, commands and reference."""

import os
import platform
import sys
import tempfile
from datetime import UTC, datetime
from importlib.metadata import version as version_of
from pathlib import Path

from vibroscope.app.performance.bench import processor

sys.path.insert(0, str(Path(__file__).parent))
from figures.style import STYLE

# The notebook runs without the user's own IPython profile; its kernel would warn of the port on which it listens.
ipython = tempfile.TemporaryDirectory()
os.environ["IPYTHONDIR"] = ipython.name
(profile := Path(ipython.name, "profile_default")).mkdir()
(profile / "ipython_kernel_config.py").write_text('c.IPKernelApp.log_level = "ERROR"\n')


def made() -> str:
    """When and on what this site is built."""
    libraries = ", ".join(f"{name} {version_of(name.lower())}" for name in ("NumPy", "Numba", "Vibroscope"))
    return f"{datetime.now(UTC):%d %B %Y}, {processor()}, Python {platform.python_version()}, {libraries}"


project = "Vibroscope"
version = release = version_of("vibroscope")
root_doc = "index"
myst_enable_extensions = ["substitution"]
myst_fence_as_directive = ["math"]  # as GitHub writes formulas
myst_substitutions = {"made": made()}
exclude_patterns = ["examples", "extra", "figures"]
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinxarg.ext",
    "matplotlib.sphinxext.plot_directive",
    "gallery",
    "stores",
    "system_keys",
    "terms",
    "typeset",
]
html_math_renderer = "mathml"  # of typeset.py
myst_heading_anchors = 4
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_ipywidgets_js = {}  # by default from another host; no page has a widget
suppress_warnings = ["mystnb.unknown_mime_type"]  # what HoloViews sends to a live notebook alone
smartquotes = False  # options have two hyphens

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # the kinds stand in the docstrings
add_module_names = False
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

plot_formats = [("svg", 72)]
plot_apply_rcparams = True
plot_rcparams = STYLE
plot_include_source = False
plot_html_show_formats = False
plot_html_show_source_link = False

html_theme = "furo"
html_title = f"Vibroscope {release}"
html_copy_source = False
html_show_copyright = False
html_static_path = ["site.css"]
html_css_files = ["site.css"]
html_extra_path = ["extra"]  # wheel/: the image puts a wheel there


def make_reachable(app, pagename, templatename, context, doctree) -> None:
    """Say which level captions have and let keys scroll what is wider than the page."""
    tree = context.get("furo_navigation_tree", "")
    context["furo_navigation_tree"] = tree.replace('role="heading"', 'role="heading" aria-level="2"')
    body = context.get("body", "").replace("<pre>", '<pre tabindex="0">')
    context["body"] = body.replace('<table class="docutils', '<table tabindex="0" class="docutils')


def setup(app) -> None:
    """Change pages after the theme has made its part."""
    app.connect("html-page-context", make_reachable, priority=900)
