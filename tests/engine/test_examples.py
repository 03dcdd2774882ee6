"""The examples in the docstrings of the engine: each runs, and prints what stands there."""

import doctest
import inspect

import pytest
from vibroscope import engine

PUBLIC = {name: inspect.unwrap(getattr(engine, name)) for name in engine.__all__ if callable(getattr(engine, name))}
EXAMPLES = {
    name: test
    for name, value in PUBLIC.items()
    for test in doctest.DocTestFinder(recurse=False).find(value, name, globs={})
    if test.examples
}
# What computes or converts something needs one; classes of results and plain readers of files are used as they come.
NEED_NONE = {
    *("brief_system_text", "physical_entry", "physical_text", "system_of_tables", "system_text", "toml_tables"),
    *(
        "measurement_text",
        "parse_measurement",
        "read_measurement",
        "read_record",
        "read_system",
        "synthetic_measurement",
    ),
    *("cache_root", "compile_kernels", "is_cache_private", "is_compiled"),
    *("diagram", "ship_diagrams", "shipped_diagram"),
    *("design_curve", "recommend_range", "search_attractors", "measured_verdict"),
    *(
        "search_branches",
        "branches_dataset",
        "recommend_schemes",
        "sweep_basin",
        "basin_difference",
    ),  # as those that they are named after
    *("difference_in_kind", "touching"),
    *("end_text", "finite_or_none", "many"),
}


@pytest.mark.parametrize("name", EXAMPLES)
def test_an_example_prints_what_stands_there(name):
    said = []
    runner = doctest.DocTestRunner()
    runner.run(EXAMPLES[name], out=said.append)
    assert not runner.failures, "".join(said)


def test_every_function_whose_use_is_not_obvious_has_an_example():
    functions = {name for name, value in PUBLIC.items() if inspect.isfunction(value)}
    assert functions - EXAMPLES.keys() == NEED_NONE & functions
    assert {"System", "Reference", "ExactPenalty", "Newmark", "TimeStepping", "Units"} <= EXAMPLES.keys()
