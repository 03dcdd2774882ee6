"""The settings of the server, read from the environment and checked completely before anything starts.

Each field is an environment variable (``port`` is ``VIBROSCOPE_PORT``). An option of the command, where there is one,
has precedence. All errors are reported in one line.
"""

import ipaddress
import os
import re
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType

_ORIGIN = re.compile(r"[a-z0-9](?:[a-z0-9.-]*[a-z0-9])?(:\d{1,5})?|\[[0-9a-f:.]+\](:\d{1,5})?", re.ASCII)
_LABEL = r"[a-z0-9](?:[a-z0-9-]{0,61}[a-z0-9])?"  # of a host name; resolvers reject longer and empty ones
_HOST = re.compile(rf"(?=.{{1,253}}$){_LABEL}(?:\.{_LABEL})*", re.ASCII | re.IGNORECASE)
_IPV6 = re.compile(r"[0-9a-f:.]+", re.ASCII | re.IGNORECASE)  # no zone identifier: browsers reject it
_SHORTEST_KEY = 32
_OPTIONS = {"origins": "origin"}  # options whose name differs from the field
_OTHERS = {"VIBROSCOPE_BROWSER"}  # used by the tests, see tools/browser.py
LEVELS = ("debug", "info", "warning", "error")


def _such(expected: str, holds: Callable[[str], object], convert: Callable[[str], object] = str) -> Callable:
    """Return a parser of texts for which ``holds`` is true; for others it raises ValueError with what is expected."""

    def parse(text: str) -> object:
        if not holds(text):
            raise ValueError(expected)
        return convert(text)

    return parse


def _whole_number(low: int, high: int) -> Callable[[str], int]:
    """Return a parser of whole numbers from ``low`` to ``high``."""
    digits = re.compile(r"\d{1,15}", re.ASCII)
    expected = f"a whole number from {low} to {high}"
    return _such(expected, lambda text: digits.fullmatch(text) and low <= int(text) <= high, int)


def _one_of(*choices: str) -> Callable[[str], str]:
    """Return a parser that accepts one of ``choices``."""
    return _such(" or ".join(choices), choices.__contains__)


def _is_ipv6(text: str) -> bool:
    try:
        return bool(_IPV6.fullmatch(text) and ipaddress.IPv6Address(text))
    except ValueError:
        return False


_origin = _such("hosts as in the browser's address bar, example.org or example.org:8080", _ORIGIN.fullmatch)
_address = _such(
    "an IP address without brackets, such as 127.0.0.1 or ::1, or a host's name",
    lambda text: _HOST.fullmatch(text) or _is_ipv6(text),
)
_folder = _such("a folder", lambda text: Path(text).is_dir() or not Path(text).exists())
_secret = _such(f"at least {_SHORTEST_KEY} characters that nobody can guess", lambda text: len(text) >= _SHORTEST_KEY)


def _origins(text: str) -> tuple[str, ...]:
    return tuple(_origin(part.strip().lower()) for part in text.split(","))


def _setting(default, parse: Callable[[str], object], doc: str, *, variable: str = "", secret: bool = False):
    about = {"parse": parse, "doc": doc, "variable": variable, "secret": secret}
    if callable(default):
        return field(default_factory=default, repr=not secret, metadata=about)
    return field(default=default, repr=not secret, metadata=about)


@dataclass(frozen=True)
class Settings:
    """A complete and valid set of settings."""

    port: int = _setting(5006, _whole_number(0, 65535), "port to listen on; 0 takes a free one")
    address: str = _setting("127.0.0.1", _address, "address to listen on")
    origins: tuple[str, ...] = _setting(
        (), _origins, "hosts under which browsers may open the page, separated by commas; by default the address itself"
    )
    proxied: str = _setting(
        "no",
        _one_of("no", "yes"),
        "whether X-Forwarded-For names the client: yes only if nobody but a proxy that sets it can connect",
    )
    threads: int = _setting(lambda: max(4, os.cpu_count() or 4), _whole_number(1, 256), "solver threads")
    sessions: int = _setting(100, _whole_number(1, 100_000), "sessions at a time; further visitors are asked to wait")
    steps: int = _setting(
        150_000_000, _whole_number(5_000_000, 10**12), "time steps × periods that one request may take"
    )
    cache_dir: str | None = _setting(
        None, _folder, "folder of compiled kernels and diagrams, by default the user's own"
    )
    cache_mb: int = _setting(
        1000,
        _whole_number(1, 10**6),
        "megabytes of diagrams kept in that folder; the least recently used are deleted first",
    )
    log_format: str = _setting("text", _one_of("text", "json"), "format of the log")
    log_level: str = _setting("info", _one_of(*LEVELS), "lowest level that is logged")
    metrics_token: str = _setting(
        "",
        _secret,
        "bearer token that gives other machines access to /metrics; by default only this machine has it",
        secret=True,
    )
    secret_key: str = _setting(
        lambda: secrets.token_urlsafe(48),
        _secret,
        "key that signs sessions; all replicas need the same, by default it is random",
        variable="BOKEH_SECRET_KEY",
        secret=True,
    )

    @property
    def host(self) -> str:
        """The address as browsers write it in a URL: an IPv6 address is compressed and in brackets."""
        if _is_ipv6(self.address):
            return f"[{ipaddress.IPv6Address(self.address).compressed}]"
        return self.address.lower()


def variable_of(name: str) -> str:
    """Return the environment variable of one field."""
    given = {f.name: f.metadata["variable"] for f in fields(Settings)}[name]
    return given or f"VIBROSCOPE_{name.upper()}"


def from_environment(
    environ: Mapping[str, str] = os.environ, *, given: Mapping[str, object] = MappingProxyType({})
) -> Settings:
    """Return all settings, from ``given``, the environment or the defaults, in this order of precedence.

    Parameters
    ----------
    environ
        Environment variables; an empty one counts as unset.
    given
        Values by field name, as a command line has them; None counts as not given.

    Raises
    ------
    ValueError
        One line that names every invalid value and what it should be.
    """
    values, errors = {}, []
    for item in fields(Settings):
        option = given.get(item.name)
        name = variable_of(item.name) if option is None else f"--{_OPTIONS.get(item.name, item.name)}"
        text = environ.get(name, "").strip() if option is None else str(option)
        if option is None and not text:
            continue
        try:
            values[item.name] = item.metadata["parse"](text)
        except ValueError as expected:
            shown = f"{len(text)} characters" if item.metadata["secret"] else repr(text[:40])
            errors.append(f"{name} must be {expected}, not {shown}")
    if errors:
        raise ValueError("; ".join(errors))
    return Settings(**values)


def unknown_variables(environ: Mapping[str, str] = os.environ) -> list[str]:
    """Return the variables that look like settings but are none, such as misspelt ones.

    They cause a warning and no error: container platforms add variables of their own, named after the service.
    """
    known = {variable_of(item.name) for item in fields(Settings)} | _OTHERS
    return sorted(name for name in environ if name.startswith("VIBROSCOPE_") and name not in known)


def describe() -> str:
    """Return every variable with its meaning and default, for ``--help``."""
    lines = ["environment (an option has precedence):"]
    for item in fields(Settings):
        default = "" if item.metadata["secret"] or item.default in (None, ()) else f" (default {_default_of(item)})"
        lines += [f"  {variable_of(item.name)}", f"      {item.metadata['doc']}{default}"]
    return "\n".join(lines)


def _default_of(item) -> object:
    return item.default if not callable(item.default_factory) else item.default_factory()


_current: Settings | None = None


def current_settings() -> Settings:
    """Return the settings of the running server, or the defaults if nothing is served."""
    return _current or Settings()


def use_settings(settings: Settings) -> None:
    """Make these the settings of this process."""
    global _current
    _current = settings
