"""Recommendations over all contact laws: what is asked, which numbers each takes, order, JSON, bad input."""

import json

import pytest
from vibroscope.app.commands import recommend as command
from vibroscope.engine import CONTACT_LAWS
from vibroscope.engine.law_table import numbers_of

from tests.app.test_recommend_schemes import FEW, made, run
from tests.share import every

LAWS = sorted({*every(CONTACT_LAWS), "impact"}, key=CONTACT_LAWS.index)


@pytest.fixture
def asked(monkeypatch):
    """The schemes that the command asks for; nothing is searched."""
    schemes = []
    monkeypatch.setattr(command, "recommend_schemes", lambda _, each, **__: schemes.extend(each) or [*map(made, each)])
    return schemes


@pytest.mark.parametrize(
    ("options", "left_out", "numbers"),
    [
        ([], ["impact", "bilinear"], {}),
        (["--penetration", "0.02"], ["bilinear"], {"penetration": 0.02}),
        (
            ["--penetration", "0.02", "--stiffening", "3", "--exponent", "2", "--integrator", "hht"],
            [],
            {"penetration": 0.02, "stiffening": 3.0, "exponent": 2.0},
        ),
    ],
)
def test_all_laws_are_asked_each_with_the_numbers_that_it_takes(asked, capsys, options, left_out, numbers):
    status, out, err = run(capsys, *FEW, "--law", "all", *options)
    assert status == 0
    assert [each.law for each in asked[:-1]] == [law for law in CONTACT_LAWS if law not in left_out]
    assert [each.located for each in asked] == [False] * (len(asked) - 1) + [True]  # of the first law alone
    for each in asked:
        own = {name: number for name, number in numbers.items() if name in numbers_of(each.law)}
        assert all(getattr(each, name) == number for name, number in own.items())
        assert each.integrator.name == ("hht" if "hht" in options else "newmark")
    assert out.startswith("every law; eta = 1.08")
    assert out.splitlines()[1].split()[:2] == ["law", "status"]
    assert [line.split()[0] for line in out.splitlines()[2 : 2 + len(asked)]] == [each.law for each in asked]
    assert ("law impact is left out: it needs --penetration" in err) == ("impact" in left_out)
    assert ("law bilinear is left out" in err) == bool(left_out)


def test_laws_are_searched_and_the_best_comes_first(capsys, monkeypatch):
    monkeypatch.setattr(command, "CONTACT_LAWS", LAWS)
    status, out, err = run(capsys, *FEW, "--law", "all", "--json")
    found = json.loads(out)["found"]
    met = [each["solves"] for each in found if each["met"]]
    assert status == 0
    laws = sorted(each["law"] for each in found)
    asked = [law for law in LAWS if "penetration" not in numbers_of(law)]
    assert laws == sorted((*asked, "kelvin-voigt"))  # which has two rows
    assert met == sorted(met)
    assert [each["met"] for each in found] == sorted((each["met"] for each in found), reverse=True)
    assert "law impact is left out" in err
