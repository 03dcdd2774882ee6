"""The switch of units: every column, label and number compared with the non-dimensional one."""

import csv
import io
import math
from dataclasses import replace

import numpy as np
import pytest
from vibroscope.app.explorer.compute import compute_runs
from vibroscope.app.explorer.explanation import describe
from vibroscope.app.explorer.present import present, quantity_of
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.formats import as_csv, as_toml
from vibroscope.app.export.scripts import as_command
from vibroscope.app.export.tables import figure_table
from vibroscope.app.page.controls.controls import Controls
from vibroscope.app.runtime.cache import Cache
from vibroscope.engine import Units
from vibroscope.engine.system_file import parse_system

PLAIN = Setting()
PHYSICAL = PLAIN._replace(units="mm-t-s", omega1=20.0, m1=3.0, amplitude=2.5)
UNITS = Units(20.0, 3.0, 2.5, "mm-t-s")
CACHE = Cache(48)


def columns_of(setting):
    return present(compute_runs(setting, cache=CACHE))


def test_every_column_is_the_plain_one_times_its_unit():
    period = 2 * math.pi / PLAIN.eta / 20.0  # seconds
    factors = {  # by hand
        "time": period,
        "displacement": 2.5,
        "velocity": 2.5 * 20.0,
        "force": 3.0 * 2.5e-3 * 20.0**2,
        "impulse": 3.0 * 2.5e-3 * 20.0,
        None: 1.0,
    }
    plain, physical = columns_of(PLAIN), columns_of(PHYSICAL)
    assert plain.keys() == physical.keys()
    for source, columns in plain.items():
        for name, column in columns.items():
            np.testing.assert_allclose(physical[source][name], factors[quantity_of(name)] * column, rtol=3e-7)
            assert physical[source][name].dtype == np.float32


@pytest.mark.parametrize(
    ("column", "quantity"),
    [("penalty_v2", "velocity"), ("v1", "velocity"), ("x2", "displacement"), ("reference1", "displacement")],
)
def test_the_name_of_a_column_gives_its_quantity(column, quantity):
    assert quantity_of(column) == quantity


def test_the_runs_do_not_depend_on_the_units():
    assert compute_runs(PHYSICAL, cache=CACHE).penalty is compute_runs(PLAIN, cache=CACHE).penalty


def shown_of(setting):
    controls = Controls()
    controls.show_setting(setting)
    numbers = controls.shown["numbers"]
    return controls.shown | {"fields": {name: controls.fields[name] | {"text": numbers[name]} for name in numbers}}


def notes_of(setting):
    return shown_of(setting)["notes"]


def test_the_notes_are_what_goes_into_an_fe_input_file():
    notes = notes_of(PHYSICAL)
    assert f"{1e6 * 2 * math.pi / 1.08 / 20 / 2000:.4g} µs" in notes["steps"]
    assert [notes[name].partition(" w")[0] for name in ("K", "D")] == ["K = 2500", "D = 8"]  # those of the model beside
    assert notes_of(PLAIN).keys() == {"steps"}


@pytest.mark.parametrize(
    ("system", "expected"),
    [
        ("none", {"eta": "1.08 ", "K": "2500 ", "D": "8 ", "m1": "3 kg", "amplitude": "2.5 mm", "threshold": "0.002 "}),
        (
            "si",
            {"eta": f"{1.08 * 20 / 2 / math.pi:.6g} Hz", "K": "3000000 N/m", "D": "960 N·s/m"}
            | {"mass1_kg": "3 kg", "base_amplitude_mm": "2.5 mm", "threshold": "0.0001 m/s"}
            | {"stiffness1_N_per_m": "1200 N/m"},
        ),
        (
            "mm-t-s",
            {"K": "3000 N/mm", "D": "0.96 N·s/mm", "mass1_kg": "0.003 t", "threshold": "0.1 mm/s"}
            | {"stiffness1_N_per_m": "1.2 N/mm"},
        ),
    ],
)
def test_the_fields_show_the_numbers_of_an_input_file(system, expected):
    fields = shown_of(PHYSICAL._replace(units=system))["fields"]
    assert {name: f"{fields[name]['text']} {fields[name]['unit']}" for name in expected} == expected


@pytest.mark.parametrize("system", ["none", "si", "mm-t-s"])
@pytest.mark.parametrize("name", ["eta", "K", "D", "threshold", "restitution"])
def test_a_number_that_is_typed_as_it_is_shown_stays(system, name):
    setting = PHYSICAL._replace(units=system, K=12345.0, threshold=0.00217)
    text = shown_of(setting)["fields"][name]["text"]
    typed = read_setting(plain_texts({name: {"typed": text}}, setting), setting)
    assert getattr(typed, name) == pytest.approx(getattr(setting, name), rel=1e-5)


def test_a_move_sends_its_numbers_and_not_what_the_fields_are_called():
    controls, sent = Controls(), []
    controls.show_setting(PLAIN)
    controls.param.watch(sent.append, ["fields", "shown"])
    controls.show_setting(PLAIN._replace(eta=1.5, start_xi2=2.0))
    assert [event.name for event in sent] == ["shown"]
    assert "frequency" not in str(sent[0].new)
    assert sent[0].new["numbers"]["start_xi2"] == "2"
    controls.show_setting(PHYSICAL)
    assert [event.name for event in sent] == ["shown", "fields", "shown"]


def test_joint_damping_that_follows_from_the_dampers_is_shown_and_locked():
    derived = PLAIN._replace(joint_damping="derived")
    assert shown_of(PLAIN)["fields"]["d3"]["locked"] == ""
    field = shown_of(derived)["fields"]["d3"]
    assert float(field["text"]) == pytest.approx(derived.system.derived_joint_damping, rel=1e-3)
    assert "as measured" in field["locked"]


def test_the_files_name_their_units():
    rows = list(csv.reader(io.StringIO(as_csv(figure_table("force", columns_of(PHYSICAL), PHYSICAL.scale)))))
    assert rows[0] == ["series", "time [s]", "force [N]", "impulse [N·s]"]
    assert parse_system_units(as_toml(PHYSICAL)) == UNITS
    assert "--system system.toml --units mm-t-s" in as_command(PHYSICAL)
    assert "N." in describe(compute_runs(PHYSICAL, cache=CACHE)).lines(None)["penalty"]


def test_a_force_that_may_be_a_mean_is_named_so():
    columns = columns_of(PLAIN)
    names = [list(series.columns) for series in figure_table("force", columns, UNITS, located=True)]
    assert names[:2] == [["time [s]", "force [N]"], ["time [s]", "force_or_mean [N]"]]
    assert "force [N]" in figure_table("force", columns, UNITS)[1].columns


def parse_system_units(text):
    return replace(parse_system(text[text.index("[units]") :].encode()).units, system="mm-t-s")
