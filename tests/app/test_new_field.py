"""A new number is one entry of the table: setting, link, typed numbers, units and command line have it then."""

import json
import subprocess
import sys

ENTRY = 'Field("impact_time", "t₀", "duration of an impact", 0.5, (0.0, 2.0), quantity="time").option("how long"),'
PROGRAM = f"""
import importlib.util, json, sys
found = importlib.util.find_spec("vibroscope.app.explorer.parameters")
source = found.loader.get_data(found.origin).decode()
head = "_REFERENCE_FIELDS = ("
assert source.count(head) == 1
module = importlib.util.module_from_spec(found)
sys.modules[found.name] = module
exec(source.replace(head, head + {ENTRY!r}), module.__dict__)

from vibroscope.app.commands.numbers import resolve_units
from vibroscope.app.commands.options import add_fields
from vibroscope.app.commands.parser import OneLineParser
from vibroscope.app.explorer.field_units import shown_field
from vibroscope.app.explorer.link import parse_address, print_address
from vibroscope.app.explorer.reading import read_setting
from vibroscope.app.explorer.typed import plain_texts
from vibroscope.engine import parse_system

setting = read_setting({{"units": "si", "omega1": "10", "impact_time": "0.75"}})
again = read_setting(parse_address(print_address(setting)))
typed = read_setting(plain_texts({{"impact_time": {{"typed": "100 ms"}}}}, setting), setting)
parser = OneLineParser()
add_fields(parser, "impact_time")
options = parser.parse_args(["--impact-time", "100 ms"])
options.file, options.eta = parse_system(b"[units]\\nomega1 = 10.0\\n"), 1.0
resolve_units(options)
shown = shown_field("impact_time", setting).measure(0.75)
print(json.dumps([again == setting, shown, typed.impact_time, options.impact_time, parser.format_help()]))
"""


def test_an_entry_is_in_links_units_typed_numbers_and_options():
    done = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    again, shown, typed, given, help_text = json.loads(done.stdout)
    assert again
    assert (shown, typed, given) == ("0.075 s", 1.0, 1.0)
    assert "--impact-time F" in help_text
    assert "how long" in help_text
