"""The script with what the page uses of Panel's bundle and of Bokeh's bundle of widgets, a twentieth of both.

A bundle is a table of modules, which name the modules that they require. Here the modules of the page's models are put
together with all that these require. A browser would fetch, compile and run the rest without use: on a line of 1.6
Mbit/s that takes 1.1 s.
"""

import hashlib
import json
import re
from functools import cache
from pathlib import Path
from typing import NamedTuple

from bokeh.settings import settings as bokeh_settings
from panel.io.resources import DIST_DIR

# Panel's models of the page, by their modules.
MODELS = {
    "models/browser": "BrowserInfo",
    "models/column": "Column",
    "models/html": "HTML",
    "models/reactive_esm": "ReactiveESM",
}
_COMPONENT = "models/reactive_esm"
_MODULE = re.compile(r'^"?(\w+)"?: (?=function _\((\w+))', re.MULTILINE)
_END = re.compile(r'^\}, "?\w+"?, (\{.*\}), \{\}\);\}\);', re.MULTILINE)
_OF_BOKEH = "@bokehjs/"
# Translates a module of a component to JavaScript, which the page's are.
_TRANSLATES = ".transform=function"
_AS_IT_IS = "function _(e,t,n,o,r){o();n.transform=(code)=>({code})}"


class _Bundle(NamedTuple):
    head: str  # with the licence
    modules: dict[str, str]  # by identifier
    identifiers: dict[str, str]  # by name


def _read(path: Path) -> _Bundle:
    """Read a bundle; raises RuntimeError if it has another form."""
    text = path.read_text(encoding="utf-8")
    begins, end = [*_MODULE.finditer(text)], _END.search(text)
    if not begins or end is None:
        raise RuntimeError(f"{path} is no table of modules: install the versions of requirements/")
    ends = [*(begin.start() for begin in begins[1:]), end.start()]
    modules = {
        begin[1]: text[begin.end() : stop].strip().removesuffix(",") for begin, stop in zip(begins, ends, strict=True)
    }
    head = text[: text.index("(function")]
    return _Bundle(head, modules, {name: str(identifier) for name, identifier in json.loads(end[1]).items()})


def _required(module: str) -> list[str]:
    """The modules that a module requires, by identifier or by a name of Bokeh's."""
    require = re.match(r"function _\((\w+)", module)[1]
    return re.findall(rf'(?<![\w$.]){require}\("?([\w@/.-]+)"?\)', module)


@cache
def script() -> bytes:
    """The script; raises RuntimeError if a bundle has another form or lacks a model."""
    panel = _read(DIST_DIR / "panel.min.js")
    widgets = _read(Path(bokeh_settings.bokehjs_path()) / "js" / "bokeh-widgets.min.js")
    if missing := MODELS.keys() - panel.identifiers.keys():
        raise RuntimeError(f"Panel's bundle has no {', '.join(sorted(missing))}: install the versions of requirements/")
    modules, names = panel.modules | widgets.modules, {name: panel.identifiers[name] for name in MODELS}
    for each in _required(modules[names[_COMPONENT]]):
        if _TRANSLATES in modules.get(each, ""):
            modules[each] = _AS_IT_IS
    found, wanted = {}, [*names.values()]
    while wanted:
        identifier = wanted.pop()
        name = identifier.removeprefix(_OF_BOKEH)
        if name != identifier and name in widgets.identifiers:
            names[name] = identifier = widgets.identifiers[name]
        if identifier in modules and identifier not in found:  # what is in neither is in Bokeh's own script
            found[identifier] = modules[identifier]
            wanted += _required(modules[identifier])
    made = ",".join(f'{name}:require("{module}").{name}' for module, name in MODELS.items())
    found["page"] = f'function _(require){{require("@bokehjs/base").register_models({{{made}}})}}'
    table = ",\n".join(f"{json.dumps(identifier)}: {module}" for identifier, module in found.items())
    return f'{panel.head}Bokeh.register_plugin({{\n{table}\n}}, "page", {json.dumps(names)});\n'.encode()


@cache
def address() -> str:
    """Where the page finds the script, relative to its own address: it holds a digest of the content."""
    return f"static/libraries/{hashlib.sha256(script()).hexdigest()[:12]}.js"
