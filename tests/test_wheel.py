"""The wheel, installed outside the checkout with nothing else of ours in reach: every command runs with all its data.

The dependencies are those of this test environment. Site-packages may be unwritable, as in a system-wide
installation; compiled kernels are then kept in the user's cache folder. One small kernel shows that, and that a
writable installation does the same; the commands find all of them compiled there, as copies of those of this checkout.
"""

import asyncio
import json
import os
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from pathlib import Path

import pytest
from numba.core.caching import UserWideCacheLocator
from vibroscope.engine.drivers.code_cache import complete_mark

from tests.browserless import Client
from tests.served import served
from tests.waiting import PATIENCE

ROOT = Path(__file__).parents[1]
FOLDERS = ("app", "assets", "engine")
SCENE = ("--eta", "2.76", "--K", "12000", "--D", "18", "--steps", "2000")


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """A source distribution, and a wheel that is built from it."""
    folder = tmp_path_factory.mktemp("dist")
    command = [sys.executable, "-m", "build", "--no-isolation", "--outdir", folder, ROOT]
    subprocess.run(command, check=True, capture_output=True, text=True, timeout=300)
    return folder


@pytest.fixture(scope="module")
def installed(built, tmp_path_factory):
    """Folder of a virtual environment that holds the wheel and finds the dependencies of this one."""
    folder = tmp_path_factory.mktemp("installed") / "venv"
    venv.create(folder, symlinks=True)
    site = sysconfig.get_path("purelib", "venv", {"base": str(folder), "platbase": str(folder)})
    Path(site, "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    (wheel,) = built.glob("*.whl")
    pip = [sys.executable, "-m", "pip", "--python", folder / "bin" / "python", "install", "--no-index", "--no-deps"]
    subprocess.run([*pip, wheel], check=True, capture_output=True, timeout=120)
    return folder


class Installed:
    """The installed commands, run from a folder that holds nothing, by a user who has an empty home."""

    def __init__(self, folder, home, prefix):
        self.folder, self.prefix = folder, prefix
        self.cwd = home / "work"
        self.cwd.mkdir(exist_ok=True)
        ours = {"PYTHONPATH", "PYTHONHOME", "XDG_CACHE_HOME"}
        kept = {name: value for name, value in os.environ.items() if name not in ours and "VIBROSCOPE" not in name}
        self.environment = {**kept, "HOME": str(home)}

    def command(self, name):
        return [*self.prefix, str(self.folder / "bin" / name)]

    def run(self, name, *arguments):
        command = [*self.command(name), *arguments]
        done = subprocess.run(command, cwd=self.cwd, env=self.environment, capture_output=True, text=True, timeout=600)
        assert done.returncode == 0, done.stderr
        return done.stdout


@pytest.fixture(scope="module")
def home(installed, tmp_path_factory):
    """A home folder with the machine code that this checkout has compiled, under the names of the installed kernels."""
    home, cache = tmp_path_factory.mktemp("home"), complete_mark().parent
    (kernels,) = installed.rglob("vibroscope/engine/kernels")
    for module in kernels.rglob("__init__.py"):
        here, there = (
            UserWideCacheLocator.get_suitable_cache_subpath(str(folder / module.relative_to(kernels)))
            for folder in (ROOT / "engine" / "kernels", kernels)
        )
        if (cache / here).exists():
            shutil.copytree(cache / here, home / ".cache" / "vibroscope" / cache.name / there)
    return home


@pytest.fixture(scope="module")
def unwritable(installed, home):
    """An installation that nothing can be written to."""
    prefix = []
    if os.geteuid() == 0:  # may write whatever the mode says, unless this right is given up
        if not shutil.which("setpriv"):
            pytest.skip("root gives up its right to write anywhere by setpriv (util-linux), which is not here")
        prefix = ["setpriv", "--bounding-set=-dac_override"]
    modes = {path: path.stat().st_mode for path in [installed, *installed.rglob("*")] if not path.is_symlink()}
    for path, mode in modes.items():
        path.chmod(mode & ~0o222)
    yield Installed(installed, home, prefix)
    for path, mode in modes.items():
        path.chmod(mode)


@pytest.fixture(scope="module", params=["unwritable", "writable"])
def user(request):
    """Whoever uses the installation."""
    if request.param == "unwritable":
        return request.getfixturevalue("unwritable")
    return Installed(request.getfixturevalue("installed"), request.getfixturevalue("home"), [])


def shipped():
    """Every file below the three folders that a user needs: no bytecode, and no notes of the site's generator."""
    paths = (path for folder in FOLDERS for path in (ROOT / folder).rglob("[!.]*"))
    return {str(path.relative_to(ROOT)) for path in paths if path.is_file() and "__pycache__" not in path.parts}


def test_the_wheel_holds_every_file_of_the_packages_and_no_other(built):
    (wheel,) = built.glob("*.whl")
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
    assert names == {f"vibroscope/{name}" for name in shipped()}


def test_the_source_distribution_holds_what_the_wheel_is_built_from(built):
    (source,) = built.glob("*.tar.gz")
    with tarfile.open(source) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert shipped() | {"pyproject.toml", "setup.py", "README.md"} <= names
    assert not any(name.startswith("tests") for name in names)


def test_what_is_imported_is_the_installed_package(user):
    code = "import vibroscope.app, vibroscope.assets, vibroscope.engine as e; print(e.__file__, *vibroscope.__path__)"
    assert all(Path(path).is_relative_to(user.folder) for path in user.run("python", "-c", code).split())


def test_unwritable_is_unwritable(unwritable):
    code = "import vibroscope.engine as e; open(e.__file__ + '.x', 'w')"
    with pytest.raises(AssertionError, match="PermissionError"):
        unwritable.run("python", "-c", code)


KERNEL = """
from vibroscope.engine.kernels.linear.cos_sin import cos_sin
cos_sin(0.5)
print(cos_sin.stats.cache_misses.total(), cos_sin.stats.cache_hits.total())
"""


def test_a_kernel_is_compiled_once_and_kept_in_the_home_folder(user, tmp_path):
    newcomer = Installed(user.folder, tmp_path, user.prefix)
    assert [newcomer.run("python", "-c", KERNEL) for _ in range(2)] == ["1 0\n", "0 1\n"]
    (code,) = tmp_path.rglob("cos_sin*.nbc")
    assert code.parents[1].name == complete_mark().parent.name


def test_simulate(unwritable, home):
    before = compiled(home)
    found = json.loads(unwritable.run("vibroscope", "simulate", "--solver", "newmark", *SCENE, "--json"))
    assert (found["status"], len(found["section"])) == ("ok", 50)
    assert compiled(home) == before  # what the checkout has compiled was found


def compiled(home):
    """When each file of machine code was written."""
    return {path: path.stat().st_mtime_ns for path in home.rglob("*.nb?")}


def test_sweep(unwritable, tmp_path):
    out = tmp_path / "eta.zarr"
    values = ("--from", "2.6", "--to", "2.8", "--count", "5", "--transient", "50", "--sample", "10")
    text = unwritable.run("vibroscope", "sweep", "eta", *values, "--solver", "reference", "--out", str(out), "--json")
    assert json.loads(text)["computed"] == 5
    assert out.is_dir()


def test_validate(unwritable):
    found = json.loads(unwritable.run("vibroscope", "validate", "B1", "--json"))
    assert found
    assert all(figure["agrees"] for figure in found)


def test_serve(unwritable, tmp_path):
    where = {"cwd": unwritable.cwd, "environment": unwritable.environment}
    with served(tmp_path / "log.txt", command=[*unwritable.command("vibroscope"), "serve"], **where) as server:
        asyncio.run(asyncio.wait_for(open_page(server.url), PATIENCE))
    assert "Traceback" not in server.log.read_text()


async def open_page(url):
    """One session, up to the page with the paper's first scene."""
    async with Client(url) as client:
        await client.ready()
        assert client.models("Figure")
