"""What several tests ask for, found once in a process: equal questions have equal answers."""

from functools import cache

from vibroscope.engine import ComparisonQuestion, compare, recommend, verdict


@cache
def compared(*question, **options):
    """The comparison of a system, an η and a method."""
    return compare(ComparisonQuestion(*question, **options))


@cache
def verdict_of(*question, **options):
    """The verdict on it."""
    return verdict(compared(*question, **options))


@cache
def recommended(question):
    """What is recommended for a question, `tests.recommended.question`."""
    return recommend(question)
