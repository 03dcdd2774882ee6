"""System files: written, read back, and refused if anything is wrong with them."""

import math

import hypothesis.strategies as st
import pytest
from hypothesis import given
from vibroscope.engine import Excitation, System, SystemFile, Units, brief_system_text, read_system, system_text
from vibroscope.engine.model import SECOND_STOP
from vibroscope.engine.system_file import SYSTEM_SIZE_LIMIT, described_keys, parse_system

ratios = st.floats(0, 1, exclude_max=True)


@given(
    d1=ratios, d2=ratios, d3=ratios, restitution=st.floats(0, 1), kappa=st.floats(1.5, 50), share=st.floats(0.1, 0.9)
)
def test_a_written_file_is_read_back(d1, d2, d3, restitution, kappa, share):
    system = System(kappa, d1, d2, 1 + share * (kappa - 1), d3, restitution)
    units = Units(omega1=kappa, m1=0.3, base_amplitude=share)
    assert parse_system(system_text(system, units).encode()) == SystemFile(system, units)


def test_the_default_is_table_1():
    assert parse_system(system_text().encode()) == SystemFile(System(), Units())
    assert parse_system(b"[system]\nwall = false") == SystemFile(System(), Units())


@pytest.mark.parametrize("content", [b"", b"# only words\n", b"[system]\n[units]\n"])
def test_a_file_without_any_entry_is_not_the_papers_system(content):
    with pytest.raises(ValueError, match=r"no entry: describe the system in a table \[physical\]"):
        parse_system(content)


def test_every_constant_is_explained_with_its_true_range():
    text = system_text()
    system, excitation, units = map(described_keys, ("system", "excitation", "units"))
    assert (system.pop("mass_ratio").default, system.pop("wall").default) == ("of kappa and kappa3", False)
    of_a_wall = system.pop("spring1")
    assert f"{of_a_wall.meaning} [-]; {of_a_wall.allowed}" in system_text(System(wall=True))
    both = system_text(System(clearance2=0.5, restitution2=0.4))
    for name in ("clearance2", *SECOND_STOP):
        key = system.pop(name)
        assert f"{key.meaning} [{key.unit}]; {key.allowed}" in both
    for name, (meaning, unit, allowed, _) in (system | excitation | units).items():
        line = next(line for line in text.splitlines() if line.startswith(f"{name} ="))
        assert meaning in line
        assert f"[{unit}]; {allowed}" in line
    assert list(system) == [*System().as_dict(), "clearance"]
    assert list(excitation) == list(Excitation().as_dict())
    for table, name, inside, outside in [
        ("system", "d1", "0", "1"), ("system", "d2", "0.999", "-0.001"), ("system", "d3", "0", "1.0"),
        ("system", "restitution", "1", "1.001"), ("system", "kappa", "1000", "1001"),
        ("system", "kappa3", "2.4", "2.41"), ("system", "kappa3", "1.01", "1"),
        ("system", "clearance", "-1e6", "-1.1e6"), ("excitation", "force2", "1e6", "2e6"),
        ("excitation", "base_phase", "-1000", "-1001"),
        ("units", "omega1", "1e-6", "9e-7"), ("units", "omega1", "1e9", "2e9"), ("units", "m1", "1e12", "2e12"),
        ("units", "m1", "1e-15", "9e-16"), ("units", "base_amplitude", "1e6", "2e6"),
        ("units", "base_amplitude", "1e-9", "9e-10"),
    ]:  # fmt: skip
        parse_system(f"[{table}]\n{name} = {inside}".encode())
        with pytest.raises(ValueError, match=f"{name} = "):
            parse_system(f"[{table}]\n{name} = {outside}".encode())


def test_the_mass_ratio_may_be_given_instead_of_kappa3():
    assert parse_system(b"[system]\nmass_ratio = 0.5").system.mass_ratio == pytest.approx(0.5)
    with pytest.raises(ValueError, match="both kappa3 and mass_ratio"):
        parse_system(b"[system]\nmass_ratio = 0.5\nkappa3 = 1.8")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"[system]\nkapa = 2", "'kapa'; did you mean kappa"),
        (b"[sytem]\nkappa = 2", "unknown table 'sytem'; did you mean system"),
        (b"kappa = 2", "unknown table 'kappa'"),
        (b"system = 3", r"begin it with a line \[system\]"),
        (b"[[system]]\nd1 = 0", r"begin it with a line \[system\]"),
        (b"[system]\nkappa = '2'", "kappa = '2' in .system. is no number"),
        (b"[system]\nkappa = true", "is no number"),
        (b"[system]\nkappa = 2026-01-01", "is no number"),
        (b"[system]\nkappa = nan", "kappa = nan is outside"),
        (b"[system]\nrestitution = inf", "restitution = inf is outside"),
        (b"[system]\nd1 = 0.1\nkappa = 2..", "line 3"),
        (b"[system]\nd1 = 0\nd1 = 0", "line 3"),
        (b"[system]\nd1 = 0\nd1 = 0\n", "line"),
        (b"[system]\n\xff", "line 2: not UTF-8"),
        (b"[system]\nkappa = " + b"9" * 400, "beyond 1e308"),
        (b"[system]\nkappa = " + b"9" * 5000, "too long"),
        (b"[system]\nkappa = " + b"[" * 20000, "nested too deep"),
        (b"a." * 32000 + b"a = 1", "nested too deep"),  # tomllib would need quadratic time
        (b"#" * (SYSTEM_SIZE_LIMIT + 1), "larger than 65536 bytes"),
    ],
)
def test_a_faulty_file_is_refused_in_one_line(content, words):
    with pytest.raises(ValueError, match=words) as caught:
        parse_system(content)
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read_is_named_in_the_error(tmp_path):
    with pytest.raises(ValueError, match=r"nowhere\.toml: cannot be read: No such file"):
        read_system(tmp_path / "nowhere.toml")
    with pytest.raises(ValueError, match="cannot be read: Is a directory"):
        read_system(tmp_path)


def test_a_file_with_byte_order_mark_and_crlf_is_read(tmp_path):
    path = tmp_path / "own.toml"
    path.write_bytes(b"\xef\xbb\xbf[system]\r\nd1 = 0\r\n")
    assert read_system(path).system.d1 == 0


LINES = st.sampled_from(
    ["[system]", "[units]", "kappa = 3", "d1 = -1", "d2 = 1e400", "kappa3 = 2", "mass_ratio = 1", "m1 = 0x10", "= 2",
     "d3 = {a = 1}", "omega1 = 1_0", '"a\\nb" = 1', "e = [1, 2", "\x00", "restitution = -0.0"]
)  # fmt: skip


@given(st.one_of(st.binary(max_size=200), st.lists(LINES, max_size=8).map(lambda lines: "\n".join(lines).encode())))
def test_any_bytes_give_a_system_or_an_error_of_one_line(content):
    found, message = None, ""
    try:
        found = parse_system(content)
    except ValueError as problem:
        message = str(problem)
    if found is None:
        assert message
        assert "\n" not in message
    else:
        assert all(math.isfinite(value) for value in found.system.as_dict().values())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        ("mass_ratio = 0.5", ["gives no d3; 0.033 is taken", "here 0.007339"]),
        ("d1 = 0.1", ["gives no d3; 0.033 is taken"]),
        ("kappa = 3.0", ["kappa3 = 1.8 is taken", "m2/m1 = 0.3889", "gives no d3; 0.033 is taken"]),
        ("kappa = 3.0\nkappa3 = 2.0", ["gives no d3; 0.033 is taken"]),
        ('mass_ratio = 0.5\nd3 = "derived"', []),
        ("mass_ratio = 0.5\nd3 = 0.033", []),
        ("kappa = 2.41\nd1 = 0.0033", []),  # the paper's
        ("clearance = 1.0\nrestitution = 0.8", []),  # its pendulums, too
        ("wall = true\nd1 = 0.1", []),
    ],
)
def test_a_joint_taken_from_the_paper_is_said(content, said):
    """A file keeps its numbers, whenever it was written; whoever describes other bodies reads what was taken."""
    found = parse_system(f"[system]\n{content}".encode())
    assert bool(found.assumed) == bool(said)
    assert all(words in " ".join(found.assumed) for words in said)
    if any("0.033" in words for words in said):
        assert found.system.joint_damping("table") == 0.033


@pytest.mark.parametrize(
    "system", [System(mu=0.5), System(kappa=3.0), System(d1=0.1, d3=None), System(kappa=3, d3=0.1)]
)
def test_a_brief_file_of_other_bodies_leaves_nothing_to_assume(system):
    assert parse_system(brief_system_text(system).encode()) == SystemFile(system, Units())
