"""Messages from the browser: each calls one method of the session. A message of another form is ignored.

A message is a dictionary with the browser's number of the move and one of the names below, such as
``{"move": 7, "set": {"eta": "1.2"}}``. Its content is unchecked text, and the called method decides whether it is
accepted; ``{"painted": 12}`` says that an update is on the screen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from vibroscope.app.explorer.scenes import scenes
from vibroscope.app.explorer.shelf import shelf

if TYPE_CHECKING:
    from vibroscope.app.page.session import Session


def route(session: Session, message: object) -> None:
    """Call the method of ``session`` that ``message`` asks for."""
    if not isinstance(message, dict):
        return
    if "painted" in message:
        session.painted(message["painted"])
        return
    if isinstance(message.get("move"), int):
        session.move = message["move"]
    for name, act in _ACTIONS.items():
        if name in message:
            act(session, message[name])
            return


def _set(session: Session, texts: object) -> None:
    if isinstance(texts, dict):
        session.set(texts)


def _choose_scene(session: Session, key: object) -> None:
    if isinstance(key, str) and key in scenes():
        session.set(scenes()[key].texts(), fresh=True)  # fresh also for the same scene: a way back from any zoom


def _choose_shelf(session: Session, key: object) -> None:
    if isinstance(key, str) and key in shelf():
        session.set(shelf()[key].texts(), fresh=True)


def _if_text(act: Callable[[Session, str], None]) -> Callable[[Session, object], None]:
    return lambda session, text: act(session, text) if isinstance(text, str) else None


_ACTIONS: dict[str, Callable[[Session, object], None]] = {
    "set": _set,
    "scene": _choose_scene,
    "shelf": _choose_shelf,
    "undo": lambda session, _: session.undo(),
    "redo": lambda session, _: session.redo(),
    "reset": lambda session, _: session.reset(),
    "pin": lambda session, on: session.pin(bool(on)),
    "unpin": lambda session, place: session.unpin(place) if isinstance(place, int) else None,
    "theme": _if_text(lambda session, theme: session.choose_theme(theme)),
    "view": _if_text(lambda session, key: session.open(key)),
    "take": _if_text(lambda session, what: session.take(what)),
    "load": lambda session, parts: session.load(parts),
}
