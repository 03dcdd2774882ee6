"""How the explorer is served: every setting, read from the environment and checked whole before anything starts.

A name here is an environment variable (``port`` is ``VIBROSCOPE_PORT``) and, where the command has it, an option, which
wins. What is wrong is told in one line that names everything that is wrong.
"""

from __future__ import annotations

import ipaddress
import os
import re
import secrets
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from pathlib import Path
from types import MappingProxyType

_ORIGIN = re.compile(r"[a-z0-9](?:[a-z0-9.-]*[a-z0-9])?(:\d{1,5})?|\[[0-9a-f:.]+\](:\d{1,5})?", re.ASCII)
_LABEL = r"[a-z0-9](?:[a-z0-9-]{0,61}[a-z0-9])?"  # of a host's name: longer or empty ones no resolver takes
_HOST = re.compile(rf"(?=.{{1,253}}$){_LABEL}(?:\.{_LABEL})*", re.ASCII | re.IGNORECASE)
_IPV6 = re.compile(r"[0-9a-f:.]+", re.ASCII | re.IGNORECASE)  # no zone: no browser takes one
_SHORTEST_KEY = 32
_OPTIONS = {"origins": "origin"}  # an option that is named otherwise
_OTHERS = {"VIBROSCOPE_BROWSER"}  # of the tests: see tools/browser.py
LEVELS = ("debug", "info", "warning", "error")


def whole(low: int, high: int) -> Callable[[str], int]:
    """A reader of whole numbers from ``low`` to ``high``."""

    def read(text: str) -> int:
        if not re.fullmatch(r"\d{1,15}", text, re.ASCII) or not low <= int(text) <= high:
            raise ValueError(f"a whole number from {low} to {high}")
        return int(text)

    return read


def one_of(*choices: str) -> Callable[[str], str]:
    """A reader of one of these words."""

    def read(text: str) -> str:
        if text not in choices:
            raise ValueError(" or ".join(choices))
        return text

    return read


def matching(pattern: re.Pattern, wanted: str) -> Callable[[str], str]:
    """A reader of texts of this form."""

    def read(text: str) -> str:
        if not pattern.fullmatch(text):
            raise ValueError(wanted)
        return text

    return read


_origin = matching(_ORIGIN, "hosts as in the browser's address bar, example.org or example.org:8080")


def _origins(text: str) -> tuple[str, ...]:
    return tuple(_origin(part.strip().lower()) for part in text.split(","))


def _address(text: str) -> str:
    if not _HOST.fullmatch(text) and not _is_ipv6(text):
        raise ValueError("an IP address without brackets, such as 127.0.0.1 or ::1, or a host's name")
    return text


def _is_ipv6(text: str) -> bool:
    try:
        return bool(_IPV6.fullmatch(text) and ipaddress.IPv6Address(text))
    except ValueError:
        return False


def _folder(text: str) -> str:
    if Path(text).exists() and not Path(text).is_dir():
        raise ValueError("a folder")
    return text


def _secret(text: str) -> str:
    if len(text) < _SHORTEST_KEY:
        raise ValueError(f"at least {_SHORTEST_KEY} characters that nobody can guess")
    return text


def _setting(default, read: Callable[[str], object], doc: str, *, variable: str = "", secret: bool = False):
    about = {"read": read, "doc": doc, "variable": variable, "secret": secret}
    if callable(default):
        return field(default_factory=default, repr=not secret, metadata=about)
    return field(default=default, repr=not secret, metadata=about)


@dataclass(frozen=True)
class Settings:
    """One complete, valid set of settings."""

    port: int = _setting(5006, whole(0, 65535), "port to listen on; 0 takes a free one")
    address: str = _setting("127.0.0.1", _address, "address to listen on")
    origins: tuple[str, ...] = _setting(
        (), _origins, "hosts that browsers may open the page under, by commas; by default the address itself"
    )
    proxied: str = _setting(
        "no",
        one_of("no", "yes"),
        "whether X-Forwarded-For names the client: yes only where nobody but a proxy that sets it can connect",
    )
    threads: int = _setting(lambda: max(4, os.cpu_count() or 4), whole(1, 256), "threads that solve")
    sessions: int = _setting(100, whole(1, 100_000), "sessions held at once; whoever comes later is told to wait")
    steps: int = _setting(100_000_000, whole(5_000_000, 10**12), "time steps × periods that one setting may ask for")
    cache_dir: str | None = _setting(
        None, _folder, "folder of compiled kernels and diagrams, by default the user's own"
    )
    cache_mb: int = _setting(1000, whole(1, 10**6), "megabytes kept in that folder; the oldest diagrams go first")
    log_format: str = _setting("text", one_of("text", "json"), "form of the log's lines")
    log_level: str = _setting("info", one_of(*LEVELS), "least level that is logged")
    metrics_token: str = _setting(
        "",
        _secret,
        "lets /metrics be read from outside, as a bearer token; by default from this machine only",
        secret=True,
    )
    secret_key: str = _setting(
        lambda: secrets.token_urlsafe(48),
        _secret,
        "signs sessions; the same for all replicas, by default a random one",
        variable="BOKEH_SECRET_KEY",
        secret=True,
    )

    @property
    def host(self) -> str:
        """The address as it stands in a URL, and as browsers send it: one of IPv6 short and in brackets."""
        if _is_ipv6(self.address):
            return f"[{ipaddress.IPv6Address(self.address).compressed}]"
        return self.address.lower()


def variable_of(name: str) -> str:
    """The environment variable of one setting."""
    given = {f.name: f.metadata["variable"] for f in fields(Settings)}[name]
    return given or f"VIBROSCOPE_{name.upper()}"


def from_environment(
    environ: Mapping[str, str] = os.environ, *, given: Mapping[str, object] = MappingProxyType({})
) -> Settings:
    """All settings: what is ``given``, else the environment's, else the default.

    Parameters
    ----------
    environ
        Variables; an empty one counts as unset.
    given
        Values by the setting's name, as a command line has them: None counts as not given.

    Raises
    ------
    ValueError
        In one line, with everything that is wrong and what it should be.
    """
    values, wrong = {}, []
    for item in fields(Settings):
        said = given.get(item.name)
        name = variable_of(item.name) if said is None else f"--{_OPTIONS.get(item.name, item.name)}"
        text = environ.get(name, "").strip() if said is None else str(said)
        if said is None and not text:
            continue
        try:
            values[item.name] = item.metadata["read"](text)
        except ValueError as wanted:
            shown = f"{len(text)} characters" if item.metadata["secret"] else repr(text[:40])
            wrong.append(f"{name} must be {wanted}, not {shown}")
    if wrong:
        raise ValueError("; ".join(wrong))
    return Settings(**values)


def unknown(environ: Mapping[str, str] = os.environ) -> list[str]:
    """Variables that look like settings and are none: worth a warning, since a typing error passes for a default.

    No more than a warning: container platforms put variables of their own into every environment, named by the service.
    """
    known = {variable_of(item.name) for item in fields(Settings)} | _OTHERS
    return sorted(name for name in environ if name.startswith("VIBROSCOPE_") and name not in known)


def describe() -> str:
    """Every variable with its meaning and default, for ``--help``."""
    lines = ["environment (an option wins over it):"]
    for item in fields(Settings):
        default = "" if item.metadata["secret"] or item.default in (None, ()) else f" (default {_default_of(item)})"
        lines += [f"  {variable_of(item.name)}", f"      {item.metadata['doc']}{default}"]
    return "\n".join(lines)


def _default_of(item) -> object:
    return item.default if not callable(item.default_factory) else item.default_factory()


_in_force: Settings | None = None


def in_force() -> Settings:
    """What this process is served with; the defaults where nothing is served."""
    return _in_force or Settings()


def put_in_force(settings: Settings) -> None:
    """Serve with these from now on."""
    global _in_force
    _in_force = settings
