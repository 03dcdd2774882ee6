"""Numbers on the command line are read as those that are typed on the page; what a program writes keeps its meaning."""

import argparse

import pytest
from vibroscope.app.commands.numbers import count, number
from vibroscope.app.commands.recommend import eta_range


@pytest.mark.parametrize(
    ("read", "text", "value"),
    [
        (count, "20,000", 20_000),
        (count, "2 000", 2000),
        (count, "2e3", 2000),
        (count, "100.5", 100.5),  # the engine says that it is not whole
        (number, "12 000", 12_000),
        (number, "12'000", 12_000),
        (number, "12,500.25", 12_500.25),
        (number, "12.500,25", 12_500.25),
        (number, "1,08", 1.08),
        (number, "1.125", 1.125),
        (number, "12000.000", 12_000),  # as %.3f writes them
        (number, "12.000", 12),
        (count, "20.000", 20),
        (number, "12.000.000", 12_000_000),
        (number, "-1.5e-3", -0.0015),
        (number, "1_000.5", 1000.5),
        (number, "inf", float("inf")),
    ],
)
def test_what_people_and_programs_write_is_read(read, text, value):
    assert read(text) == value


@pytest.mark.parametrize(
    ("read", "text", "words"),
    [
        (number, "12,000", "“12,000” can mean 12000 or 12: write 12000 or 12.0$"),
        (number, "12 kN/m", "is no number: write it as 12000"),
        (number, "5%", "is no number"),
        (number, "1,2,3", "is no number"),
        (number, "", "is no number"),
    ],
)
def test_what_is_no_number_or_two_is_refused(read, text, words):
    with pytest.raises(argparse.ArgumentTypeError, match=words):
        read(text)


def test_the_numbers_of_a_range_are_read_too():
    assert eta_range("2,6:2.8:3") == (2.6, 2.8, 3)
    with pytest.raises(argparse.ArgumentTypeError, match=r"can mean 1125 or 1\.125"):
        eta_range("1,125:2.8:3")
