"""Systems of one's own, thousands of them: files in either form, what the panel System is sent, and links.

Each is refused in one line, or is a system whose numbers are finite, that is shown without nan, and that reads back.
"""

import pytest
from vibroscope.app.explorer.errors import Refused
from vibroscope.app.explorer.link import print_address
from vibroscope.app.explorer.parameters import DRAWING_FIELDS, START_FIELDS, SYSTEM_FIELDS
from vibroscope.app.explorer.physical_fields import PHYSICAL_FIELDS, entered
from vibroscope.app.explorer.presets import scenes, shelf
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.state import Setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.app.export.formats import as_toml, loaded_from_toml
from vibroscope.app.page.address import read_opening
from vibroscope.app.page.controls.controls import Controls
from vibroscope.engine import parse_system, physical_text, system_text
from vibroscope.engine.excitation import HELD
from vibroscope.engine.physical import EITHER, KEYS
from vibroscope.engine.system_file import described_keys

from tests.app.test_sentences import NO_NUMBER
from tests.release.odd import random_text
from tests.release.test_fuzz import all_finite, all_numbers_finite
from tests.release.test_fuzzed_commands import COMMANDS, ended

# Tables that describe a system as they stand; a file changes some of their numbers.
WHOLE = (
    {"mass1_kg": 25, "stiffness1_N_per_m": 1e5, "damping1_ratio": 0.07, "wall": "true", "clearance_mm": 0.5}
    | {"base_acceleration_m_per_s2": 1, "frequency_Hz": 10},
    {"mass1_kg": 2, "frequency1_Hz": 3, "damping1_Ns_per_m": 1, "mass2_kg": 3, "stiffness2_N_per_m": 4e3}
    | {"force1_N": 10, "constant2_N": -5, "frequency_Hz": 4},
    {"mass1_kg": 1, "frequency1_Hz": 1, "mass2_kg": 1, "frequency2_Hz": 2, "base_amplitude_mm": 1, "frequency_Hz": 1},
)
OF_SYSTEM = {table: tuple(described_keys(table)) for table in ("system", "excitation", "units")}
EDGES = ("0", "-0.0", "1", "0.999999", "5e-324", "2.2e-308", "1e-160", "1e-12", "1e9", "1e15", "1e160", "1.7e308")


def odd_number(chance):
    """A number as text: of a size that systems have, of any size, or at an edge."""
    if chance.random() < 0.3:
        return chance.choice(EDGES)
    return f"{chance.choice((1, 1, -1)) * 10 ** chance.uniform(*chance.choice(((-3, 4), (-3, 4), (-320, 308)))):.6g}"


def random_file(chance):
    """A system file: a whole table [physical] with some numbers changed, or some of the other three tables."""
    if chance.random() < 0.6:
        table = dict(chance.choice(WHOLE))
        for _ in range(chance.randint(0, 3)):
            name = chance.choice((*KEYS, "wall"))
            table[name] = chance.choice(("true", "false")) if name == "wall" else odd_number(chance)
            for other in chance.choice((next((forms for forms in EITHER if name in forms), ()), ())):
                if other != name:
                    table.pop(other, None)
        tables = {"physical": table}
    else:
        tables = {name: {} for name in OF_SYSTEM if chance.random() < 0.7}
        for name, table in tables.items():
            for key in chance.sample([*OF_SYSTEM[name]], chance.randint(0, min(4, len(OF_SYSTEM[name])))):
                table[key] = chance.choice(("true", "false")) if key == "wall" else odd_number(chance)
    lines = [(f"[{name}]", *(f"{key} = {value}" for key, value in table.items())) for name, table in tables.items()]
    return "\n".join(line for table in lines for line in table)


def check_refusal(error, given=""):
    """One clear line, in which nan stands only where it was given."""
    text = str(error)
    assert 10 < len(text) < 400, (given, text)
    assert "\n" not in text, given
    assert NO_NUMBER.search(given) or not NO_NUMBER.search(text), (given, text)


def test_files(chance, inputs, report):
    """As the command line and as the page read them; what is accepted is written in both forms and read back."""
    refused = 0
    for _ in range(inputs):
        content = random_file(chance)
        try:
            found = parse_system(content.encode())
        except ValueError as error:
            check_refusal(error)
            refused += 1
            continue
        assert all_finite(found), content
        for text in (system_text(found.system, found.units), physical_text(found.system, found.units, found.eta)):
            assert not NO_NUMBER.search(text), content
        assert parse_system(system_text(found.system, found.units).encode()).system == found.system, content
        try:
            setting = read_setting(loaded_from_toml(content).texts)
        except ValueError as error:  # what the page's own ranges leave out
            check_refusal(error)
        else:
            assert all_numbers_finite(setting)
            assert read_setting(loaded_from_toml(as_toml(setting)).texts) == setting, content
    report(f"{inputs} system files: {refused} refused in one line", inputs=inputs)
    assert 0 < refused < inputs


def random_setting(chance):
    """Where a visitor of the panel may be: a scene or a system of the shelf, in units or not."""
    chosen = chance.choice((*scenes().values(), *shelf().values()))
    units = {"units": chance.choice(("none", "si", "mm-t-s"))}
    return read_setting({**chosen.texts(), **units}, chance.choice((None, Setting(m1=1e3, omega1=50, amplitude=0.2))))


def typed_number(chance):
    text = chance.choice((odd_number, odd_number, random_text))(chance)
    unit = chance.choice(("", "", "", " N/mm", " kg", " %", " mm", " Hz", " kN", " g"))
    return chance.choice(({"typed": text + unit}, {"typed": text}, text))


def of_panel(chance):
    """What the panel sends: numbers as typed, their forms, another kind of system, or units."""
    if chance.random() < 0.15:
        return {"bodies": chance.choice(("pendulums", "two", "wall", random_text(chance)))}
    if chance.random() < 0.15:
        return {"units": chance.choice(("none", "si", "mm-t-s"))}
    if chance.random() < 0.1:
        return {"stops": chance.choice(("one", "two", random_text(chance)))}
    names = (*PHYSICAL_FIELDS, *PHYSICAL_FIELDS, *SYSTEM_FIELDS[1:], *START_FIELDS, *DRAWING_FIELDS, "eta", "K", "D")
    texts = {chance.choice(names): typed_number(chance) for _ in range(chance.choice((1, 1, 1, 2)))}
    forms = {"held": chance.choice((*HELD, "speed")), "spring1_form": chance.choice(("frequency", "stiffness", None))}
    return texts | chance.choice(({}, forms))


def test_panel(chance, inputs, report):
    """One number after the other, ten from each start; what the controls then show holds no nan."""
    controls, refused, setting = Controls(), 0, Setting()
    for number in range(inputs):
        if number % 10 == 0:
            setting = random_setting(chance)
        texts = of_panel(chance)
        try:
            found = read_setting(entered(plain_texts(texts, setting), setting), setting)
        except Refused as error:
            check_refusal(error, str(texts))
            refused += 1
            continue
        assert all_numbers_finite(found), texts
        setting = found
        controls.show_setting(setting, move=0, update=0, address="", refused={}, undo=False, redo=False, pinned=False)
        shown = (controls.shown, controls.fields, controls.system, controls.spans)
        assert not NO_NUMBER.search(repr(shown)), (texts, shown)
        if number % 7 == 0:
            assert read_opening(print_address(setting)).setting == setting
            assert read_setting(loaded_from_toml(as_toml(setting)).texts) == setting
    report(f"{inputs} entries into the panel System: {refused} refused in one line", inputs=inputs)
    assert 0 < refused < inputs


SYSTEM = ["system", "--from", "physical"]


def test_commands(tmp_path, chance, inputs, capsys, report):
    """Files as the commands take them: converted, and solved for some periods."""
    file, tried, refused = tmp_path / "my.toml", max(60, inputs // 40), 0
    short = [[*words, "--system", file] for words in COMMANDS if words[0] in ("simulate", "compare", "motion")]
    commands = ([*SYSTEM, file], [*SYSTEM, file, "--to", "physical"], ["system", "--system", file], *short)
    for number in range(tried):
        file.write_text(random_file(chance))
        words = commands[number % len(commands)]
        status = ended([str(word) for word in words])
        out, err = capsys.readouterr()
        assert status in (0, 1, 2), (file.read_text(), words)
        assert "Traceback" not in err
        assert not NO_NUMBER.search(out + err), (file.read_text(), words, out, err)
        if status:
            assert err.count("\n") <= 2, err  # a remark may come before
            assert err.splitlines()[-1].startswith("vibroscope "), err
            refused += 1
    report(f"{tried} system files in commands: {refused} refused in one line", inputs=tried)


@pytest.mark.parametrize("words", [["validate"], ["system", "--from"], ["system", "--to"], SYSTEM, ["sweep", "check"]])
def test_odd_words(words, chance, capsys, report):
    """Arguments without a name, or two to a name."""
    for _ in range(200):
        status = ended([*words, *(random_text(chance) for _ in range(chance.randint(1, 2)))])
        error = capsys.readouterr().err
        assert status in (1, 2), (words, error)  # 1: no disk takes a name of that length
        assert error.startswith("vibroscope"), error
        assert error.count("\n") == 1, error
    report(f"vibroscope {' '.join(words)}: 200 odd words, each refused in one line", inputs=200)
