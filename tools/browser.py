"""The browser that drives the page in tests: found, or else installed.

``python tools/browser.py`` prints its path. Tests only ever look (`find`); ``make test`` installs.
"""

import os
import shutil
import subprocess
import sys
from pathlib import Path

NAMES = ("chromium", "google-chrome", "google-chrome-stable", "chromium-browser")
# Asked in a process of its own: Playwright's driver may be started only once in each, and the tests need it.
ASK_PLAYWRIGHT = (
    "from playwright.sync_api import sync_playwright\n"
    "with sync_playwright() as playwright: print(playwright.chromium.executable_path)"
)


class NoBrowserError(RuntimeError):
    """No browser, and none could be installed."""


def find() -> str | None:
    """Path of a Chromium or Chrome: ``VIBROSCOPE_BROWSER``, one on the PATH, or Playwright's own."""
    chosen = os.environ.get("VIBROSCOPE_BROWSER")
    if chosen:
        if not _starts(chosen):
            raise NoBrowserError(f"VIBROSCOPE_BROWSER={chosen} does not start")
        return chosen
    on_path = filter(None, map(shutil.which, NAMES))
    return next((path for path in on_path if _starts(path)), None) or _playwrights_own()


def install() -> None:
    """Install a browser: Debian's package where that is possible, otherwise Playwright's download."""
    if Path("/etc/debian_version").exists() and os.geteuid() == 0 and not _is_ubuntu():
        # With what the package recommends: the fonts are among it.
        commands = [["apt-get", "update"], ["apt-get", "install", "--yes", "chromium"]]
    else:
        commands = [[sys.executable, "-m", "playwright", "install", "chromium"]]
    for command in commands:
        print("no browser yet:", *command, file=sys.stderr)
        # Their chatter goes to stderr: stdout carries the path alone.
        if subprocess.run(command, stdout=sys.stderr).returncode != 0:
            raise NoBrowserError(f"no browser for the tests, and this failed: {' '.join(command)}")


def find_or_install() -> str:
    """Path of a browser, installed if need be."""
    path = find()
    if path is None:
        install()
        path = find()
    if path is None:
        raise NoBrowserError("a browser was installed, but it does not start")
    return path


def _starts(path: str) -> bool:
    # Ubuntu's `chromium-browser` may be a stub that only asks for a snap.
    try:
        return subprocess.run([path, "--version"], capture_output=True, timeout=60).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def _playwrights_own() -> str | None:
    asked = subprocess.run([sys.executable, "-c", ASK_PLAYWRIGHT], capture_output=True, text=True)
    path = asked.stdout.strip()
    return path if asked.returncode == 0 and Path(path).is_file() else None


def _is_ubuntu() -> bool:
    # Its chromium package is a stub for a snap, which cannot be installed in a container.
    return "ubuntu" in Path("/etc/os-release").read_text().lower()


if __name__ == "__main__":
    try:
        print(find_or_install())
    except NoBrowserError as error:
        sys.exit(f"{error}\nInstall Chromium or Chrome, or name one: VIBROSCOPE_BROWSER=/path/to/chromium")
