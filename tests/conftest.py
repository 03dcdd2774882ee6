"""Options that all tests share."""

import os

import hypothesis

# The same examples in every run, so that what passed passes again; VIBROSCOPE_FUZZ=1 looks for new ones.
# No example has a deadline: a busy machine is no fault of the code.
hypothesis.settings.register_profile("repeatable", derandomize=True, deadline=None)
if not os.environ.get("VIBROSCOPE_FUZZ"):
    hypothesis.settings.load_profile("repeatable")


def pytest_addoption(parser):
    parser.addoption(
        "--renew-snapshots",
        action="store_true",
        help="write what the page shows now as what it should show (look at the difference before you commit it)",
    )
