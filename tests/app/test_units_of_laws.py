"""K and D of laws that are not linear, as a person types and reads them: command line, fields, files, inputs."""

import json
import math
import re

import pytest
from vibroscope.app.codes.catalogue import codes
from vibroscope.app.commands.numbers import measured
from vibroscope.app.explorer.field_units import shown_field, shown_text
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.suggestion import OfSchemes, make_question, suggestion_content
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.tables import columns_in_units
from vibroscope.engine import parse_system, written
from vibroscope.engine.facts import equation

from tests.app.command_line import run_command
from tests.app.searches import SETTING, found_for

SHEET = """
[physical]
mass1_kg = 25.0
stiffness1_N_per_m = 98696.0
damping1_ratio = 0.07
wall = true
clearance_mm = 0.5
restitution = 0.5
force1_N = 25.0
frequency_Hz = 10.0
length_mm = {}
"""
HERTZ = ("--law", "hunt-crossley")


@pytest.fixture(params=["1.0", "1000.0"])
def sheet(request, tmp_path):
    """The same system, its displacements counted in mm and in m."""
    path = tmp_path / "system.toml"
    path.write_text(SHEET.format(request.param))
    return str(path)


def setting_of(length="1.07", **texts):
    system = parse_system(SHEET.format(length).encode())
    scale = {"omega1": str(system.units.omega1), "m1": "25", "amplitude": length, "units": "si", "law": "hunt-crossley"}
    return read_setting(scale | texts)


def test_the_command_line_reads_and_prints_n_per_m_to_the_power_of_n(sheet, capsys):
    """395.33 N is the force of the same contact, integrated with dimensions (tests/engine/test_units_of_laws.py)."""
    run = "motion", "--solver", "exact", "--system", sheet, *HERTZ
    _, out, _ = run_command(capsys, *run, "--K", "1e9 N/m^1.5", "--units")
    assert "stiffness 1e9 N/m^1.5" in out
    assert "peak force 395.3 N" in out
    _, out, _ = run_command(capsys, *run, "--K", "3.16228e4 N/mm^1.5", "--json", "--units", "mm-t-s")
    report = json.loads(out)["physical"]
    assert report["units"]["stiffness"] == "N/mm^1.5"
    assert report["settings"]["stiffness"] == pytest.approx(3.16228e4)
    assert report["peak_force"] == pytest.approx(395.33, abs=0.01)


def test_a_unit_of_another_law_is_refused_with_those_of_this_one(sheet, capsys):
    run = "motion", "--solver", "exact", "--system", sheet, *HERTZ
    status, _, err = run_command(capsys, *run, "--K", "1e9 N/m")
    assert status
    assert "'1e9 N/m' of the contact law hunt-crossley has no physical unit N/m: give it in N/m^1.5" in err


def test_every_law_has_one_unit_each():
    stiffness, damping = measured("contact_stiffness"), measured("contact_damping")
    assert stiffness("1e9 N/m^1.5").unit == "N/m^1.5"
    assert stiffness("1e9 N/m**1.5").unit == "N/m^1.5"
    assert damping("3 N·s/m^2.5").unit == damping("3 N.s/m^2.5").unit == "Ns/m^2.5"


def test_the_fields_show_and_read_the_unit_of_the_law():
    setting = setting_of(K="1000")
    stiffness, damper = shown_field("K", setting), shown_field("D", setting)
    assert (stiffness.unit, damper.unit) == ("N/m^1.5", "N·s/m^2.5")
    assert stiffness.factor == pytest.approx(98696.0 * (1.07e-3) ** -0.5)
    for text in ("3.0172e9 N/m^1.5", "3017.2 MN/m^1.5", "95412.3 N/mm^1.5", "3.0172e9"):
        typed = float(plain_texts({"K": {"typed": text}}, setting)["K"])
        assert typed == pytest.approx(1000, rel=1e-4), text
    assert shown_field("K", setting._replace(law="jankowski")).unit == "N/m^1.5"
    assert shown_field("D", setting._replace(law="jankowski")).unit == "N·s/m^1.25"
    assert shown_field("K", setting._replace(law="impact", exponent=2.2)).unit == "N/m^2.2"
    assert shown_field("D", setting._replace(law="impact", exponent=2.2)).unit == "N·s/m"
    plain = setting._replace(units="none")
    assert shown_field("K", plain).natural == "k₁/A^0.5"


def test_sentences_and_files_have_the_unit_of_the_law():
    setting = setting_of(K="1000")
    assert re.search(r"K = 3\.017e9 N/m\^1\.5", shown_text(equation("K", 1000), setting.scale))
    columns = columns_in_units({"K": [1000.0]}, setting.scale)
    assert list(columns) == ["K [N/m^1.5]"]


def test_the_input_of_adams_is_in_units_of_its_law():
    """K δ^2.2: the force that IMPACT makes of a penetration of 0.1 mm is that of the law, in both unit systems."""
    code = codes()["adams"]
    for system, mm in (("si", 1e-3), ("mm-t-s", 1.0)):
        setting = setting_of(K="1000", D="5", units=system, law="impact", exponent="2.2", penetration="0.01")
        (line,) = [
            line for line in code.words_for(setting.system, 1.0, setting.penalty, setting.scale) if "IMPACT" in line
        ]
        k, n, c, depth = (float(text) for text in re.findall(r"[-0-9.e]+(?=[,)])", line))
        assert n == 2.2
        assert depth == pytest.approx(0.01 * 1.07 * mm)
        force = 98696.0 * 1.07e-3 * 1000 * (0.1 / 1.07) ** 2.2
        assert k * (0.1 * mm) ** n == pytest.approx(force, rel=1e-5)
        assert c * mm == pytest.approx(2 * 5 * 25 * math.sqrt(98696 / 25) * 1e-3, rel=1e-5)


def test_a_suggestion_for_a_code_has_the_units_of_its_law():
    """Adams' IMPACT has K in N/m^2.2, whatever law is set on the page."""
    setting = SETTING._replace(units="si", omega1=20.0, m1=3.0, amplitude=2.5)
    found = found_for(make_question(SETTING, {"tolerance": "5"}, codes()["adams"].schemes()))
    content = suggestion_content(OfSchemes(**vars(found), others=()), setting)
    stiffness = 10500 * 3 * 20**2 * 2.5e-3**-1.2
    assert f"K = {written(stiffness)} N/m^2.2" in content["lines"][0]
