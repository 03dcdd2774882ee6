"""Errors whose text the user reads. No panel import."""

from vibroscope.app.runtime import logs, metrics
from vibroscope.engine.facts import Statement, message_of


class Refused(ValueError):
    """A value from outside that is not accepted; the text is for the user."""

    def __init__(self, name: str, text: str) -> None:
        super().__init__(text)
        self.name = name

    def log(self) -> None:
        """Count and log the refusal, without the refused text."""
        metrics.REFUSED.add("value")
        logs.event("refused", what="value", name=self.name)


def error_text(error: BaseException) -> str | Statement:
    """The text of an error as the page may show it.

    The engine raises ValueError and ArithmeticError with messages for the user. The text of any other error may hold a
    path of the server, so it goes to the log only.
    """
    known = isinstance(error, ValueError | ArithmeticError)
    return message_of(error) if known else "a fault of the server, see its log"
