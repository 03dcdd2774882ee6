"""The digest of the code that numbers come from: what it must notice, and what it must not."""

import ast
import shutil
from pathlib import Path

import pytest
from vibroscope.engine.sweeps.digest import (
    ENGINE,
    code_digest,
    engine_digest,
    numerical_modules,
    remembered_digest,
    solver_digest,
)

STUDY = '''"""A study."""
from typing import TYPE_CHECKING

from vibroscope.engine.kernels import force as law
from vibroscope.engine.kernels.springs import STIFFNESS, spring  # the usual one

if TYPE_CHECKING:
    from vibroscope.engine.words import Word


def compute(x: float, steps: int = 2000) -> float:
    """Say what it computes."""
    if steps < 4:
        raise ValueError(f"steps = {steps}: give more")
    # why so
    return law.contact(x) + 2.5 * spring(x, STIFFNESS) / steps
'''
FORCE = '''"""Forces."""
from vibroscope.engine.kernels.springs import spring, spring_squared


def contact(x):
    """The contact force."""
    return spring(x, 3.0) if x > 0 else 0.0
'''
SPRINGS = """STIFFNESS = 12_000.0


def spring(x, k):
    return k * x


def spring_squared(x, k):
    return k * x * x
"""
WORDS = "Word = str\n"


@pytest.fixture
def engine(tmp_path):
    """A small engine: five studies, of which one computes, two kernels, and a module of words."""
    for folder in ("sweeps", "kernels"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").write_text("")
    for name in ("basin", "eta", "no_solution", "plane", "step"):
        (tmp_path / "sweeps" / f"{name}_study.py").write_text(STUDY if name == "eta" else "")
    (tmp_path / "sweeps" / "words.py").write_text(WORDS)
    (tmp_path / "kernels" / "force.py").write_text(FORCE)
    (tmp_path / "kernels" / "springs.py").write_text(SPRINGS)
    return tmp_path


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


SAME = {
    "docstring": ("sweeps/eta_study.py", '"""Say what it computes."""', '"""Return a number."""'),
    "no docstring": ("kernels/force.py", '    """The contact force."""\n', ""),
    "comment": ("sweeps/eta_study.py", "# why so", "# for another reason"),
    "format": ("kernels/springs.py", "return k * x * x", "return (\n        k\n        * x * x\n    )"),
    "spelling of a constant": ("kernels/springs.py", "12_000.0", "1.2e4"),
    "annotation": ("sweeps/eta_study.py", "x: float,", "x: complex,"),
    "text of an error": ("sweeps/eta_study.py", "give more", "take at least 4"),
    "for type checkers": ("sweeps/eta_study.py", "import Word", "import Sentence"),
    "words": ("sweeps/words.py", "str", "bytes"),
    "order of imports": ("kernels/force.py", "spring, spring_squared", "spring_squared, spring"),
}
OTHER = {
    "constant": ("kernels/springs.py", "12_000.0", "12_001.0"),
    "kind of a constant": ("sweeps/eta_study.py", "2.5 *", "25 *"),
    "operator": ("kernels/springs.py", "return k * x\n", "return k + x\n"),
    "default argument": ("sweeps/eta_study.py", "steps: int = 2000", "steps: int = 4000"),
    "order of operands": ("sweeps/eta_study.py", "(x, STIFFNESS)", "(STIFFNESS, x)"),
    "condition": ("kernels/force.py", "x > 0", "x >= 0"),
    "which error": ("sweeps/eta_study.py", "raise ValueError", "raise TypeError"),
    "which function of a module": (
        "kernels/force.py",
        "import spring, spring_squared",
        "import spring_squared as spring",
    ),
    "decorator": ("kernels/force.py", "def contact", "@staticmethod\ndef contact"),
}


@pytest.mark.parametrize("name", SAME)
def test_what_cannot_change_a_number_does_not_change_the_digest(engine, name):
    before = code_digest(engine)
    file, old, new = SAME[name]
    edit(engine / file, old, new)
    assert code_digest(engine) == before


@pytest.mark.parametrize("name", OTHER)
def test_what_can_change_a_number_changes_the_digest(engine, name):
    before = code_digest(engine)
    file, old, new = OTHER[name]
    edit(engine / file, old, new)
    assert code_digest(engine) != before


def test_the_digest_of_the_solvers_is_that_of_the_kernels_alone(engine):
    before = solver_digest(engine)
    edit(engine / "sweeps" / "eta_study.py", "2.5 * spring", "2.6 * spring")
    edit(engine / "kernels" / "force.py", "The contact force.", "The force of the contact.")
    assert solver_digest(engine) == before
    edit(engine / "kernels" / "springs.py", "k * x\n", "0.5 * k * x\n")
    assert solver_digest(engine) != before


def test_files_and_folders_can_be_renamed(engine):
    before = code_digest(engine)
    (engine / "kernels" / "springs.py").rename(engine / "kernels" / "a_spring.py")
    edit(engine / "kernels" / "force.py", ".springs", ".a_spring")
    edit(engine / "sweeps" / "eta_study.py", "kernels.springs", "kernels.a_spring")
    assert code_digest(engine) == before
    (engine / "kernels").rename(engine / "compiled")
    (engine / "compiled" / "force.py").rename(engine / "compiled" / "law.py")
    edit(engine / "compiled" / "law.py", "kernels.a_spring", "compiled.a_spring")
    edit(engine / "sweeps" / "eta_study.py", "kernels.a_spring", "compiled.a_spring")
    edit(engine / "sweeps" / "eta_study.py", "kernels import force as law", "compiled import law")
    assert code_digest(engine) == before


def test_the_same_name_from_another_module_is_another_function(engine):
    (engine / "kernels" / "soft.py").write_text(SPRINGS.replace("k * x\n", "0.5 * k * x\n"))
    before = code_digest(engine)
    edit(engine / "sweeps" / "eta_study.py", "kernels.springs import", "kernels.soft import")
    assert code_digest(engine) != before


def test_an_import_within_a_function_counts(engine):
    edit(engine / "sweeps" / "eta_study.py", "    # why so", "    from vibroscope.engine.kernels.hidden import spring")
    (engine / "kernels" / "hidden.py").write_text(SPRINGS)
    before = code_digest(engine)
    edit(engine / "kernels" / "hidden.py", "k * x\n", "k / x\n")
    assert code_digest(engine) != before


def test_it_is_remembered_until_a_source_changes_and_a_damaged_file_is_ignored(engine, tmp_path_factory):
    folder = tmp_path_factory.mktemp("cache") / "digests"
    assert remembered_digest(engine, folder) == code_digest(engine)
    (file,) = folder.iterdir()
    content = file.read_bytes()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("vibroscope.engine.sweeps.digest.code_digest", lambda engine: "computed anew")
        assert remembered_digest(engine, folder) != "computed anew"
        for at in range(len(content)):
            file.write_bytes(content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :])
            assert remembered_digest(engine, folder) == "computed anew"
    for damaged in (b"", b"0123", b"\xff" * 12):
        file.write_bytes(damaged)
        assert remembered_digest(engine, folder) == code_digest(engine)
    edit(engine / "kernels" / "springs.py", "12_000.0", "12_001.0")
    assert remembered_digest(engine, folder) == code_digest(engine)
    assert remembered_digest(engine, folder / "cannot" / "be") == code_digest(engine)


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """A copy of this engine."""
    copy = tmp_path_factory.mktemp("copy") / "engine"
    shutil.copytree(ENGINE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    return copy


def test_this_engine_without_comments_and_formatting_is_the_same(real, numerical):
    for path in (real / one for one in numerical):
        path.write_text(ast.unparse(ast.parse(path.read_text())))
    assert code_digest(real) == engine_digest()


@pytest.fixture(scope="module")
def numerical():
    """Paths of the modules of this engine that enter the digest."""
    return set(numerical_modules())


def test_what_computes_is_numerical_and_what_keeps_or_explains_is_not(numerical):
    found = {str(path) for path in numerical}
    assert {"model.py", "methods.py", "simulate.py", "cells.py", "sweeps/errors.py"} <= found
    assert any(path.startswith("drivers/") for path in found)
    kept = ("store", "store_location", "cluster", "growth", "cache", "batches")
    assert not found & {f"sweeps/{name}.py" for name in kept}
    assert not [path for path in found if path.startswith(("recommendation/", "measurement/", "hardcases/"))]


@pytest.mark.parametrize("folder", ["event_driven", "time_stepping", "linear", "equations", "batch"])
def test_the_compiled_kernels_are_numerical(numerical, folder):
    assert any(path.parent == Path("kernels", folder) for path in numerical)


def test_every_numerical_module_is_parsed_once(engine, monkeypatch):
    modules, parse, parsed = numerical_modules(engine), ast.parse, []
    with monkeypatch.context() as patch:
        patch.setattr(ast, "parse", lambda source: parsed.append(source) or parse(source))
        code_digest(engine)
    assert len(parsed) == len(modules)
