"""The documents fit the code: each path, name, link, option and command that they mention exists."""

import json
import re
import shlex
from importlib.metadata import version as version_of
from pathlib import Path

import pytest
from vibroscope.app.commands.cli import build_parser, main

ROOT = Path(__file__).parents[1]
FOLDERS = ("app", "assets", "benchmarks", "deploy", "docs", "engine", "requirements", "tests", "tools")
FILES = [path for path in ROOT.iterdir() if path.is_file()]
FILES += [path for folder in FOLDERS for path in (ROOT / folder).rglob("*") if "__pycache__" not in path.parts]
PATHS = [f"/{path.relative_to(ROOT).as_posix()}" for path in FILES] + [f"/{folder}" for folder in FOLDERS]
SOURCES = [path for path in FILES if path.suffix in (".py", ".js", ".css", ".html", ".toml", ".sh", ".conf", ".yaml")]
CODE = {f"/{path.relative_to(ROOT).as_posix()}": path.read_text() for path in SOURCES}
WORDS = {word for text in CODE.values() for word in re.findall(r"\w+", text)}

DOCUMENTS = {path.relative_to(ROOT).as_posix(): path for path in (ROOT / "README.md", *(ROOT / "docs").rglob("*.md"))}
SUFFIX = re.compile(r"\.(py|md|toml|js|html|css|npz|csv|sh|json|yaml)$")
NO_PATH = re.compile(r"[\s(<>=?]|^[./]|:/|[A-Z]{4}|path/to")  # a command, an address, a name that the reader puts in
ELSEWHERE = {"status/manifest/", "tls/fullchain.pem", "tls/privkey.pem"}  # in a store; given by whoever serves
COMPOSED = {"v2_section", "VIBROSCOPE_METRICS_TOKEN"}  # by the code, of a name and a word
OTHERS = {"GeneralizedAlpha"}  # names of other codes


@pytest.fixture(params=DOCUMENTS)
def document(request):
    return DOCUMENTS[request.param]


def lines_of(document, shown):
    """The lines of a document that it shows as typed, or the others."""
    return [line for line in document.read_text().split("\n") if line.startswith("    ") == shown]


def quoted(document):
    """What stands between backquotes in the running text."""
    return set(re.findall(r"`([^`]+)`", "\n".join(lines_of(document, shown=False))))


def places(name):
    """Files and folders whose path ends so."""
    return [path for path in PATHS if path.endswith("/" + name.rstrip("/"))]


def test_every_path_exists(document):
    found = [text for text in quoted(document) - ELSEWHERE if not NO_PATH.search(text) and "::" not in text]
    missing = [text for text in found if ("/" in text or SUFFIX.search(text)) and not places(text)]
    assert not missing


def test_every_test_and_function_stands_in_the_file_that_is_named(document):
    missing = []
    for text in quoted(document):
        file, _, name = text.partition("::")
        if name and not NO_PATH.search(text):
            holders = places(file) if file else CODE
            pattern = re.compile(rf"(def|class) {name.split('.')[-1]}\b")
            missing += [text] if not any(pattern.search(CODE[path]) for path in holders) else []
    assert not missing


def test_every_name_occurs_in_the_code(document):
    names = [text for text in quoted(document) - COMPOSED - OTHERS if re.fullmatch(r"[A-Za-z_][\w.]*(\(.*\))?", text)]
    missing = [text for text in names if not set(re.findall(r"\w+", text.partition("(")[0])) <= WORDS]
    assert not [text for text in missing if not places(text)]


def test_every_path_and_name_of_the_glossary_exists():
    test_every_path_exists(ROOT / "assets/glossary.toml")
    test_every_name_occurs_in_the_code(ROOT / "assets/glossary.toml")


def test_every_option_is_one_of_a_command_or_script(document):
    texts = [text for text in quoted(document) if not text.startswith("docker ")]
    options = {word for text in texts for word in re.findall(r"(?<!\S)--[\w-]+", text)} - options_of(build_parser())
    assert not [option for option in options if not any(f'"{option}"' in text for text in CODE.values())]


def options_of(parser):
    """The options of a parser and of the commands below it."""
    below = [each for action in parser._actions if isinstance(action.choices, dict) for each in action.choices.values()]
    own = {option for action in parser._actions for option in action.option_strings}
    return own.union(*map(options_of, below))


def headings(document):
    """Their anchors."""
    titles = re.findall(r"^#+ (.*)$", document.read_text(), re.MULTILINE)
    return {re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-") for title in titles}


def test_every_link_leads_somewhere(document):
    links = re.findall(r"\]\(([^)]+)\)", "\n".join(lines_of(document, shown=False)))
    for file, _, anchor in (link.partition("#") for link in links if "://" not in link):
        target = document.parent / file if file else document
        assert target.exists(), file
        assert not anchor or anchor in headings(target), f"{file}#{anchor}"


def commands(document):
    """The calls of the command line that are shown, as lists of words."""
    shown = [line.strip().partition("     #")[0] for line in lines_of(document, shown=True)]
    joined = "\n".join(shown).replace("\\\n", " ")
    calls = re.findall(r"^\.venv/bin/vibroscope ([^>\n]*)", joined, re.MULTILINE)
    calls += re.findall(r"^\$ vibroscope (.*)", document.read_text(), re.MULTILINE)
    return [shlex.split(call, comments=True) for call in calls]


@pytest.fixture
def own_files(tmp_path, monkeypatch):
    """A working folder with the files that the commands read: assets, and the system that the README shows."""
    text = DOCUMENTS["README.md"].read_text()
    system = re.search(r"((?:    .*\n)+)", text[text.index("    [physical]") :])[1]
    for name in ("my.toml", "mine.toml"):
        (tmp_path / name).write_text(re.sub("^    ", "", system, flags=re.MULTILINE))
    for name in ("two.toml", "pair.toml"):
        (tmp_path / name).symlink_to(ROOT / "docs" / name)
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    monkeypatch.chdir(tmp_path)


SHOWING = {name: commands(path) for name, path in DOCUMENTS.items() if commands(path)}


@pytest.mark.usefixtures("own_files")
@pytest.mark.parametrize("name", SHOWING)
def test_every_command_that_is_shown_has_these_options(name):
    parser = build_parser()
    for words in SHOWING[name]:
        parser.parse_args(words)


def test_commands_of_the_documents_are_found():
    assert {"README.md", "docs/choosing.md", "docs/guide.md", "docs/start.md", "docs/sweeps.md"} <= SHOWING.keys()


def first_column(document):
    """What begins the rows of its tables."""
    return set(re.findall(r"^\| `?([^|`]+?)`? \|", DOCUMENTS[document].read_text(), re.MULTILINE))


def test_the_guide_names_every_view():
    views = [text for path, text in CODE.items() if path.startswith("/app/page/") and path.endswith(".py")]
    titles = {title for text in views for title in re.findall(r'^    title = "(.+)"$', text, re.MULTILINE)}
    rows = {row.rpartition(": ")[2].lower() for row in first_column("docs/guide.md")}
    assert {"explore", "time step"} <= {title.lower().replace("’", "'") for title in titles} <= rows


def test_the_table_of_benchmarks_names_every_script():
    scripts = {path.name for path in (ROOT / "benchmarks").glob("[!_]*.py")}
    assert scripts <= first_column("docs/validation.md")


def test_the_table_of_solutions_counts_them():
    rows = re.findall(r"^\| `(\w+\.json)` \| (\d+) ", DOCUMENTS["docs/validation.md"].read_text(), re.MULTILINE)
    files = {path.name: json.loads(path.read_text())["cases"] for path in (ROOT / "assets" / "truth").glob("*.json")}
    assert {name: int(count) for name, count in rows} == {name: len(cases) for name, cases in files.items()}


def test_no_document_holds_the_number_of_the_version():
    assert not [name for name, path in DOCUMENTS.items() if version_of("vibroscope") in path.read_text()]


def test_the_readme_is_short():
    assert len(DOCUMENTS["README.md"].read_text().splitlines()) <= 150


def python_of(document):
    """The lines of Python that are shown."""
    blocks = re.findall(r"(?:^    .*\n|^\n)+", document.read_text(), re.MULTILINE)
    return [re.sub("^    ", "", block, flags=re.MULTILINE) for block in blocks if "    from vibroscope" in block]


# Starting a process takes longer than most of them: the installed command is tried by `test_cli` and `test_wheel`.
QUICK = "codes", "compare", "export", "measurement", "motion", "rules", "simulate", "system"
CALLS = {" ".join(words): words for name in ("guide", "choosing") for words in commands(DOCUMENTS[f"docs/{name}.md"])}
README = {" ".join(words): words for words in commands(DOCUMENTS["README.md"])}
# A search of up to a minute is a release's: its options are read, and Python's search is run, in any case.
RUN = [call for call, words in CALLS.items() if words[0] in QUICK and call not in README]
RUN += [
    pytest.param(call, marks=[pytest.mark.release] if words[0] == "recommend" else []) for call, words in README.items()
]


@pytest.mark.usefixtures("own_files")
@pytest.mark.parametrize("call", RUN)
def test_what_readme_and_guide_show_runs(call, capsys):
    assert main((CALLS | README)[call]) in (None, 0)
    assert capsys.readouterr().out or "--out" in call


@pytest.mark.usefixtures("own_files")
@pytest.mark.parametrize("text", [text for page in DOCUMENTS.values() for text in python_of(page) if "print" in text])
def test_all_python_that_is_shown_runs(text, capsys):
    exec(text, {})
    assert capsys.readouterr().out


def test_the_guide_says_when_a_step_has_no_solution(capsys):
    text = " ".join(DOCUMENTS["docs/guide.md"].read_text().split())
    main(next(words for words in CALLS.values() if words[0] == "simulate" and words[-1] == "end"))
    period = re.search(r"without `--without-solution` stops in period (\d+)", text)[1]
    assert f"(period {period}) has no solution" in capsys.readouterr().out
