"""The base class of the page's own components.

A file that the browser sends in parts, a character for each byte (`upload.js`).
"""

from collections.abc import Callable, Mapping
from typing import ClassVar
from weakref import WeakKeyDictionary

import panel as pn
from panel.theme.native import Native
from vibroscope.app.compat import FastUpdates
from vibroscope.app.explorer.measured import LARGEST_FILE
from vibroscope.app.page.files import esm, style

LONGEST_NAME = 80
Acts = Mapping[str, tuple[type, Callable[[object], None]]]  # by the name of a message: its type, and what to do with it


def too_large(size: float, fewer: str, command: str) -> str:
    """Why the page does not take a file of so many bytes, and what does; empty if it takes it."""
    if size <= LARGEST_FILE:
        return ""
    most = LARGEST_FILE // 2**20
    return (
        f"The file has {size / 2**20:.1f} MiB, and the page takes {most}: give fewer {fewer}; `{command}` takes 16 MiB."
    )


class Upload:
    """Puts the parts of a file together.

    Parameters
    ----------
    begin : callable
        Called with the name, as it may be shown, and the size in bytes that is announced; of a larger file than
        ``largest`` nothing follows. Called again, with the size that has come, if a file proves to be larger.
    take : callable
        Called with the content.
    largest : int
        Bytes.
    """

    def __init__(
        self, begin: Callable[[str, float], None], take: Callable[[bytes], None], largest: int = LARGEST_FILE
    ) -> None:
        self._begin, self._take, self._largest = begin, take, largest
        self._name, self._size, self._parts = "", 0, []
        self.acts = {"file": (dict, self._start), "part": (dict, self._add), "end": (object, self._end)}  # see `listen`

    def _start(self, file: dict) -> None:
        self._parts, self._size = [], 0
        self._name = "".join(c if c.isprintable() else "�" for c in str(file.get("name", "")))[:LONGEST_NAME]
        size = file.get("size")
        self._begin(self._name, size if isinstance(size, int | float) else 0)

    def _add(self, parts: dict) -> None:
        texts = [text for text in parts.values() if isinstance(text, str)]
        self._size += sum(map(len, texts))
        self._parts = [*self._parts, *texts] if self._size <= self._largest else []

    def _end(self, _: object) -> None:
        content, self._parts = "".join(self._parts).encode("latin-1", errors="replace"), []
        if self._size > self._largest:
            self._begin(self._name, self._size)
        else:
            self._take(content)


class _CachedDesign(Native):
    """Panel's default design; it looks up its style sheets once per document and kind of component.

    Panel asks its design with each change of a parameter, and the design looks for its files each time. Without the
    cache a move takes 7 to 10 % more time of the server's event loop (``benchmarks/hooks.py design``).
    """

    def __init__(self, **params) -> None:
        super().__init__(**params)
        self._cached = WeakKeyDictionary()

    def params(self, viewable: pn.viewable.Viewable, doc=None) -> tuple[dict, dict]:
        """See `panel.theme.Design.params`."""
        if doc is None:
            return super().params(viewable, doc)
        cached = self._cached.setdefault(doc, {})
        kind = type(viewable)
        if kind not in cached:
            cached[kind] = super().params(viewable, doc)
        parameters, of_children = cached[kind]
        return dict(parameters), of_children


_DESIGN = _CachedDesign()


class Component(FastUpdates, pn.custom.JSComponent):
    """A component of the page: parameters in Python, a view in JavaScript. It holds no other components.

    Attributes
    ----------
    script : str
        Name of its module, and of the style sheet beside it.
    sheets : tuple of str
        Names of the style sheets that it shares with others, before its own; None: it has none, since it shows nothing.
    """

    script: ClassVar[str]
    sheets: ClassVar[tuple[str, ...] | None] = ()

    def __init_subclass__(cls, **options) -> None:
        super().__init_subclass__(**options)
        cls._esm = esm(cls.script)
        cls._stylesheets = [] if cls.sheets is None else [style("shared/basics", *cls.sheets, cls.script)]

    def __init__(self, **params) -> None:
        super().__init__(**({"design": _DESIGN} | params))
        self._acts: Acts = {}

    def listen(self, **acts: tuple[type, Callable[[object], None]]) -> None:
        """Call these with what the browser sends by their names, if it is of the type that stands beside each."""
        if not self._acts:
            self.on_msg(lambda event: self.receive(event.data))
        self._acts |= acts

    def receive(self, message: object) -> None:
        """Act on a message of the browser."""
        act_on(message, self._acts)


def act_on(message: object, acts: Acts) -> None:
    """Act on a message as far as it is one that is listened for, in the order of ``acts``."""
    for name, (kind, act) in acts.items() if isinstance(message, dict) else ():
        if name in message and isinstance(message[name], kind):
            act(message[name])
