"""The container images that others make: pinned by digest, of a supported branch, looked up not long ago.

``python tools/images.py`` says what is wrong with one; ``python tools/images.py --pin`` asks the registry which digest
each tag has today and writes it, with the date, into the file (needs docker with buildx, or skopeo).

Above each image its file says, for example::

    # as of 2026-11-23, supported until 2027-04-30

where the second date is the end of support that the makers of the image announce for this branch.
"""

import argparse
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from pathlib import Path

ROOT = Path(__file__).parents[1]
FILES = ("Dockerfile", "compose.yaml")
MOST_DAYS = 60  # between two looks at the registry: branches mend security faults about once a month
IMAGE = re.compile(
    r"# as of (?P<looked_up>\S+), supported until (?P<supported>[\d-]+).*\n"
    r"(?P<key> *(?:ARG BASE=|image: ))(?P<tag>[\w./-]+:[\w.-]+)(?:@(?P<digest>\S+))?\n"
)
DIGEST = re.compile(r"sha256:[0-9a-f]{64}")


@dataclass(frozen=True)
class Image:
    """One image as its file names it."""

    file: str
    tag: str
    digest: str
    looked_up: date
    supported: date

    def unpinned(self) -> str:
        """What is wrong with its digest, or an empty text."""
        if DIGEST.fullmatch(self.digest):
            return ""
        return f"{self.file}: {self.tag} has no digest: run tools/images.py --pin where a registry can be reached"

    def aged(self, today: date) -> str:
        """Why it is too old, or an empty text."""
        if today > self.supported:
            return f"{self.file}: {self.tag} is of a branch supported until {self.supported}: take the next one"
        days = (today - self.looked_up).days
        if days > MOST_DAYS:
            return f"{self.file}: {self.tag} was looked up {days} days ago: run tools/images.py --pin"
        return ""


def images(root: Path = ROOT) -> Iterator[Image]:
    """The images that the files name."""
    for file in FILES:
        for found in IMAGE.finditer((root / file).read_text()):
            dates = map(date.fromisoformat, (found["looked_up"], found["supported"]))
            yield Image(file, found["tag"], found["digest"] or "", *dates)


def digest_of(tag: str) -> str:
    """The digest that a tag has in its registry now."""
    if shutil.which("docker"):
        command = ["docker", "buildx", "imagetools", "inspect", tag, "--format", "{{.Manifest.Digest}}"]
    elif shutil.which("skopeo"):
        command = ["skopeo", "inspect", "--format", "{{.Digest}}", f"docker://{tag}"]
    else:
        sys.exit("needs docker with buildx, or skopeo")
    digest = subprocess.run(command, check=True, capture_output=True, text=True).stdout.strip()
    if not DIGEST.fullmatch(digest):
        sys.exit(f"{tag}: no digest in {digest[:200]!r}")
    return digest


def pin(root: Path = ROOT) -> None:
    """Write today's digest of each tag into its file."""
    for file in FILES:
        text = (root / file).read_text()

        def pinned(found: re.Match) -> str:
            line = found[0].replace(f"as of {found['looked_up']}", f"as of {date.today()}")
            return line[: line.index("\n") + 1] + f"{found['key']}{found['tag']}@{digest_of(found['tag'])}\n"

        (root / file).write_text(IMAGE.sub(pinned, text))


def main() -> int:
    """Say what is wrong; 1 if an image is too old. One without a digest is a warning: it needs a registry."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pin", action="store_true", help="ask the registry for digests and write them")
    if parser.parse_args().pin:
        pin()
    found, today = list(images()), date.today()
    aged = [problem for each in found if (problem := each.aged(today))]
    unpinned = [f"NOT PINNED: {problem}" for each in found if (problem := each.unpinned())]
    print(*aged, *unpinned, f"images: {', '.join(each.tag for each in found)}", sep="\n")
    return bool(aged)


if __name__ == "__main__":
    sys.exit(main())
