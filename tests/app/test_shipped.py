"""The result that the page opens with while the solvers are being compiled: up to date, and read back as it was."""

import re
from dataclasses import asdict

import numpy as np
import pytest
from vibroscope.app.explorer import shipped
from vibroscope.app.explorer.presets import opening_setting
from vibroscope.engine import CompileProgress

SETTING = opening_setting()


@pytest.fixture(scope="module")
def computed():
    return shipped.compute(SETTING)


def flat(result):
    """All arrays by name."""
    arrays = {f"{source}.{name}": column for source, all_ in result.columns.items() for name, column in all_.items()}
    return arrays | result.explanation.series


def words(result):
    """All texts and numbers, without the digits, whose last ones depend on the machine."""
    fields = asdict(result.description) | asdict(result.explanation)
    return re.sub(r"\d", "", str({name: value for name, value in fields.items() if name not in ("series", "parts")}))


def test_the_shipped_result_is_up_to_date(computed):
    """`make diagram` renews it."""
    found = shipped.load(shipped.PATH, SETTING)
    assert found is not None, "assets/opening.npz is of another engine or opening scene: run `make diagram`"
    assert words(found) == words(computed), "run `make diagram`"
    assert list(found.explanation.parts) == list(computed.explanation.parts)
    then, now = flat(found), flat(computed)
    assert list(then) == list(now)
    for name, column in now.items():  # a motion that does not repeat is another sample on another machine
        for extent in (np.min, np.max):
            if column.size:
                np.testing.assert_allclose(extent(then[name]), extent(column), rtol=0.05, atol=0.02, err_msg=name)


def test_a_result_is_read_back_as_it_was_written(computed, tmp_path):
    path = tmp_path / "opening.npz"
    shipped.save(path, SETTING, computed)
    found = shipped.load(path, SETTING)
    assert found.description == computed.description
    for name, value in asdict(computed.explanation).items():
        if name != "series":
            assert getattr(found.explanation, name) == value
    for name, column in flat(computed).items():
        np.testing.assert_array_equal(flat(found)[name], column)
        assert flat(found)[name].dtype == column.dtype


def test_a_result_of_another_setting_or_engine_and_a_damaged_file_are_not_shown(computed, tmp_path, monkeypatch):
    path = tmp_path / "opening.npz"
    assert shipped.load(path, SETTING) is None
    shipped.save(path, SETTING, computed)
    assert shipped.load(path, SETTING._replace(K=123.0)) is None
    with monkeypatch.context() as patch:
        patch.setattr(shipped, "engine_digest", lambda: "another")
        assert shipped.load(path, SETTING) is None
    path.write_bytes(path.read_bytes()[:-3000])
    assert shipped.load(path, SETTING) is None


def test_it_is_shown_only_while_the_solvers_are_compiled_and_only_for_its_own_setting(monkeypatch):
    assert shipped.shipped_result(SETTING) is None
    monkeypatch.setattr(shipped.compilation, "progress", CompileProgress(0.2, "reference"))
    assert shipped.shipped_result(SETTING) is not None
    assert shipped.shipped_result(SETTING._replace(eta=2.0)) is None
