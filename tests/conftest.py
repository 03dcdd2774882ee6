"""Options that all tests share."""


def pytest_addoption(parser):
    parser.addoption(
        "--renew-snapshots",
        action="store_true",
        help="write what the page shows now as what it should show (look at the difference before you commit it)",
    )
