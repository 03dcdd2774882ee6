"""What every command says of bad input: status 2, nothing printed, no file written, and one line that says why."""

import shlex

import pytest
from vibroscope.app.commands import branch

from tests.app.command_line import PHYSICAL, run_command

FILES = {
    "my.toml": PHYSICAL,
    "plain.toml": "[system]\nclearance = 0.1\n",
    "still.toml": "[excitation]\nbase = 0\n",
    "box.toml": "[physical]\nwall = true\nmass1_kg = 2\nfrequency1_Hz = 20\nclearance_mm = 2\nrestitution = 0.5\n",
    "typo.toml": "[system]\nkapa = 2\n",
    "broken.toml": "[system]\nkappa = 2..\n",
    "bare.csv": "0, 0\n1, 4\n2, 0\n",
    "damped.toml": "[system]\nd1 = 2\n",
    "empty.toml": "# a system\n[system]\n",
}
SHORT = {
    "REFERENCE": "--solver reference --eta 1.08",
    "NUMBERS": "--eta 2.76 --K 12000 --D 18 --steps 500",
    "OWN": "--solver newmark --system my.toml --K 584 --D 2 --steps 400",
    "BILINEAR": "--solver exact --eta 2.76 --K 9 --D 1 --law bilinear",
    "AREA": "--eta 3.2 --solver reference --out a",
    "PART": "--K 1e6 --D 3",
    "DROP": "--restitution 0.5 --moreau-jean 0.5",
    "PLATES": "--materials steel,pla --D 1",
}
# Of each command: arguments | words of the line, where more than one stands between " ... "
REFUSED = {
    "simulate": """
        --solver reference | --eta
        --solver reference --eta nan | eta = nan is outside
        --solver reference --eta two | “two” is no number: write it as 12000, 1.08 or 1.2e4, without a unit
        --solver guess --eta 1 | invalid choice: 'guess'
        --solver newmark --eta 1 --K 1 | needs --D, --steps
        --solver newmark --eta 1 --K -1 --D 1 --steps 100 | K = -1.0 is outside
        --solver newmark --eta 1 --K 1 --D 1 --steps 100.5 | not a whole number
        --solver newmark --eta 1 --K 1 --D inf --steps 100 | D = inf is outside
        --solver newmark --eta 1 --K 1 --D 1 --steps 3 | steps = 3.0 is outside
        --solver exact --eta 2,76 --K 12,000 --D 18 | --K: “12,000” can mean 12000 or 12: write 12000 or 12.0 (see
        --solver exact --eta 2.76 --K 1200 --law cut | the exact solver needs --D
        --solver exact --eta 2.76 --K 1200 --law impact --D 1 | penetration is missing
        --solver exact --eta 2.76 --K 1200 --law impact --D 1 --penetration 0 | penetration = 0
        --solver exact --eta 2.76 --K 1200 --law impact --penetration 1 | needs --D
        --solver exact --eta 2.76 --K 1200 --law flores --exponent 0.9 | exponent = 0.9 is outside [1, 10]
        BILINEAR --penetration 1 | stiffening is missing: give the r
        BILINEAR --stiffening 2 | penetration is missing: give the penetration beyond
        BILINEAR --penetration 1 --stiffening 1 | stiffening = 1.0 is outside (1
        BILINEAR --penetration 1 --stiffening inf | stiffening = inf is outside
        --solver exact --eta 2.76 --K 9 --D 1 --law cut --stiffening 2 | --stiffening is no number of the law
        --solver exact --eta 2.76 --K 1200 --law flores --restitution 0 | since its formula divides by it: give D
        --solver newmark --eta 2.76 --steps 9 --D 1 --stiffness-of-step -1 | stiffness_of_step = -1.0 is outside (0,
        REFERENCE --keep 0 | keep = 0
        REFERENCE --periods 1e99 | periods = 1e+99
        REFERENCE --initial 1,2 | four numbers
        REFERENCE --initial a,b,c,d | not a list of numbers
        REFERENCE --initial 1,0,0,0 | gap
        REFERENCE --restitution 2 | restitution = 2.0
        REFERENCE --threshold -1e-9 | threshold = -1e-09
        REFERENCE --treshold 2 | --treshold is no option: do you mean --threshold?
        REFERENCE --colour=2 | simulate: --colour is no option (see
        REFERENCE 'one⏎line' | simulate: one line belongs to no option (see
        REFERENCE --system typo.toml | typo.toml: unknown constant in [system]: 'kapa'; did you mean kappa?
        REFERENCE --system empty.toml | empty.toml: has no entry ... [physical], or in [system]
        REFERENCE --system broken.toml | broken.toml: not valid TOML
        REFERENCE --system damped.toml | damped.toml: d1 = 2.0 is outside [0, 1)
        REFERENCE --system nowhere.toml | nowhere.toml: cannot be read: No such file or directory
        --solver newmark NUMBERS --steady | has a time step
        --solver newmark NUMBERS --integrator euler | invalid choice: 'euler'
        --solver newmark NUMBERS --integrator hht --alpha 0.9 | alpha = 0.9 is outside [-0.333333, 0]
        --solver newmark NUMBERS --integrator bathe --rho 1.2 | rho = 1.2 is outside [0, 1]
        --solver newmark NUMBERS --integrator generalised-alpha --rho -0.1 | rho = -0.1 is outside
        --solver newmark NUMBERS --integrator hht-interpolated --alpha -0.34 | alpha = -0.34 is outside
        --solver newmark NUMBERS --beta nan | beta = nan is outside
        --solver newmark NUMBERS --integrator bathe --alpha 0 | --alpha is no number of ... bathe: it has --rho
        --solver newmark NUMBERS --integrator tr-bdf2 --rho 0 | --rho is no number of ... tr-bdf2: it has no numbers
        --solver newmark NUMBERS --beta 2 | beta = 2.0 is outside
        --solver newmark NUMBERS --status end --located | --located is --status located, and goes with no --status end
        --solver newmark NUMBERS --integrator central-difference --status end | knows the gap before the force
        --solver newmark NUMBERS --status middle | invalid choice: 'middle'
        --solver newmark NUMBERS --without-solution guess | invalid choice: 'guess'
        --solver newmark NUMBERS --penetration 0.02 | --penetration is no number of the law ... give --law
        --solver newmark NUMBERS --law jankowski --exponent 2 | --exponent is no number of the law ... give --law
        --solver newmark NUMBERS --K '1e6 N/m' | --K '1e6 N/m': a unit has no meaning without ... [physical] or [units]
        --solver newmark NUMBERS --eta '10 Hz' --system plain.toml | --eta '10 Hz': a unit has no meaning
        --solver newmark NUMBERS --steps '10 us' | --steps '10 us': a unit has no meaning
        OWN --K '1e6 kg' | --K '1e6 kg': give it in N/m, kN/m, MN/m, N/mm, kN/mm, or without a unit
        OWN --K '54476 lbf/in' | --K '54476 lbf/in': give it in N/m, kN/m, MN/m, N/mm, kN/mm, or without a unit
        OWN --steps '5 mm' | --steps '5 mm': give it in s, ms, us
        OWN --steps '-5 us' | a time step is above 0
        OWN --initial '1 mm,2 mm,0,0' | --initial '2 mm': give it in m/s, cm/s, mm/s, or without a unit
        OWN --initial '1 mm,2 apples,0,0' | --initial '2 apples': give it in m/s, cm/s, mm/s, or without a unit
        OWN --initial '1 mm,0,0,0,5' | initial""",
    "motion": """
        --solver reference --eta -1 | eta = -1
        --solver exact --eta 2.76 | needs --K
        REFERENCE --attractors --starts 0 | starts = 0
        --solver newmark NUMBERS --exponent 1.5 | --exponent is no number of the law ... give --law""",
    "compare": """
        NUMBERS --K -1 | K = -1
        NUMBERS --steps 0 | steps = 0
        NUMBERS --keep 0 | keep = 0
        NUMBERS --eta nan | eta = nan
        --eta 1.08 --K 2500 --D 8 | --steps
        NUMBERS --fit | --measured
        --eta 1.08 --steps 9 --D 8 --measured m.csv --fit restitution | needs --K; ... --fit is of the reference
        NUMBERS --columns time=1 | --columns needs a measurement
        NUMBERS --columns time | is no list of columns: write it as
        NUMBERS --exponent 1.5 | --exponent is no number of the law ... give --law
        --K -5 | K = -5.0 is outside [1e-06, 1e+12]
        --D 18 | a penalty solution needs --eta, --K, --steps; the paper's numbers: --eta 2.76 --K 12000 --steps 8000
        --eta 1.08 --D 18 --steps 99 | needs --K; ... in place of --K --stiffness-of-step
        --system my.toml --K '-1e6 N/m' --D 1 --steps 100 | (-1e6 N/m) is outside [1e-06, 1e+12] ( ... N/m): give
        NUMBERS --stiffness-of-step 0.1 | --stiffness-of-step: not allowed with argument --K""",
    "peaks": """
        NUMBERS --transmissibility t.csv | --eta-range go together
        NUMBERS --system still.toml --transmissibility t.csv --eta-range 1:2:3 | the base, which does not move""",
    "transient": """
        --system box.toml --base-half-sine '30 g' | --base-half-sine has 1 numbers: give A,T
        --system box.toml --base-half-sine '30 N,11 ms' | give it in m/s
        --system box.toml --base-record missing.csv | missing.csv
        --system box.toml --base-record bare.csv | line 1 (no header) ... as time [s], a [m/s2]
        --system box.toml --base-sawtooth '50 g,6 ms' --write s.csv | go together
        --system box.toml --force-half-sine '50 N,6 ms' --body 2 | body 2, which is a wall ... give one on body 1
        --system box.toml --force-sawtooth '5 N,6 ms' --shock-response '1 Hz:2 Hz:3' --write s.csv | motion of the base
        --system box.toml --base-sawtooth '50 g,6 ms' --shock-response 5:500:100 --write s.csv | as '5 Hz:500 Hz:100'
        --system box.toml --base-sawtooth '50 g,6 ms' --shock-response 5 --write s.csv | as '5 Hz:500 Hz:100', or""",
    "impact": """
        --K '0 N/mm' --restitution 0.5 | K = 0.0 (0 N/mm) is outside ... (1e-09 to 1e+09 N/mm): give a contact stiffness
        --restitution 0.5 | --K --permitted-penetration --permitted-force --materials --moreau-jean
        --K 1e5 --D 3 --time-step 0 | --time-step 0: give a step above 0, or leave it out
        --permitted-force '1 kN' --D 3 | give --restitution in place of --D
        --materials steel,wood --radius 1 --law flores --D 1 | unknown material 'wood'; known
        PLATES | --materials needs --radius
        PLATES --radius 1 | give --law hunt-crossley
        --K 1e6 | give --D or --restitution, or --system with a restitution
        PART --mass 0 | mass = 0.0 is outside ... give the reduced mass
        PART --mass -1kg | mass = -1.0 (-1kg) is outside ... give the reduced mass
        PART --speed -.5m/s | closing_speed = -0.5 (-.5m/s) is outside
        PART --restitution 0.5 | not allowed with
        --K 1e6 --restitution 1.5 | restitution = 1.5 is outside [0, 1]
        --K '1e6 kg' --D 3 | give it in N/m
        PART --steps-per-contact 0 | give a number above 0
        PART --time-step 1e-12 | too short to follow: take at least
        PART --over mass=1:2 | neither of steps-per-contact, speed
        PART --over speed=2:1 | 0 < A < B
        PART --over speed | needs a step
        PART --over time | --over time needs a step
        PART --over time=0:1 | time has no range, give time alone
        PART --over steps-per-contact --json | leave --json out
        PART --speed 0 | closing_speed = 0
        PART --eta 2 | give --system, or --speed
        --moreau-jean 0.3 --restitution 0.5 --time-step 1 | theta = 0.3 is outside [0.5, 1]
        DROP | --moreau-jean needs a step
        DROP --law cut | --law goes with a contact spring
        --moreau-jean 0.5 --D 3 --time-step 1 | --D goes with a contact spring""",
    "recommend": """
        | --eta
        --system box.toml --initial '-600 mm,0,0,0' | --initial is no option: ... free vibration ... impact
        --system box.toml --initial -600mm,0,0,0 | --initial is no option: ... free vibration ... impact --system FILE
        --system box.toml | nothing drives the bodies ... free vibration ... impact --system FILE --initial
        --eta 2.76 --tolerance 0 | tolerance = 0
        --eta 2.76 --tolerance nan | tolerance = nan
        --eta 2.76 --tolerance 1.5 | tolerance = 1.5 is outside
        --eta 2.76 --restitution-tolerance 0 | restitution_tolerance = 0.0 is outside
        --eta 2.76 --force-tolerance 11 | force_tolerance = 11.0 is outside
        --eta -1 | eta = -1
        --eta 2.76 --K-max 0 | stiffness_max = 0
        --eta 2.76 --steps-max 100.5 | not a whole number
        --eta 2.76 --steps-max 3 | steps_max = 3.0 is outside
        --eta 2.76 --force-tolerance none | --force-tolerance
        --eta 2.76 --eta-range 1:2:3 | --eta
        --eta 2.76 --one-setting | --eta-range
        --eta 2.76 --stiffness-of-step 0.1 | --stiffness-of-step is no option
        --eta 2.76 --exponent 1.5 | --exponent is no number of the law ... give --law
        --eta-range 1:2 | --eta-range
        --eta-range 1:2:1 | 1
        --eta-range 1:1.1:2 --integrator all | searches at one frequency: give --eta
        --eta-range 1:1.1:2 --one-setting --integrator all | searches at one frequency: give --eta
        --eta-range 1:1.1:2 --code opensees | searches at one frequency: give --eta
        --eta-range 1:1.1:2 --one-setting --code opensees | searches at one frequency: give --eta
        --eta 1.08 --code nothing | unknown code 'nothing'; known: abaqus-standard
        --eta 1.08 --code opensees --integrator hht | leave --integrator out
        --eta 1.08 --code opensees --status end | leave --status out
        --eta 1.08 --code opensees --without-solution keep | leave --without-solution out
        --eta 1.08 --code opensees --law all | leave --law out
        --eta 1.08 --integrator all --alpha 0.5 | alpha = 0.5 is outside
        --eta 1.08 --integrator all --status end --located | goes with no --status end
        --eta 1.08 --integrator all --law all | name one integrator or law
        --eta 1.08 --law all --one-setting | --law all searches at one frequency
        --eta 1.08 --law all --exponent 0.5 | exponent = 0.5 is outside""",
    "codes": """
        excel | known: abaqus-standard
        translate --from cad --to adams | give one of physical
        translate --from adams k --to drake | give it as k=...
        translate --from adams --to drake | --mass '1 kg'
        translate --from mujoco --to adams --mass '2 m' | give it in kg, g, t""",
    "rules": """
        --eta 2.76 --code calculix --status end | leave --status out
        --eta 2.76 thumb | unknown rule 'thumb'
        --eta=-0 | rules: eta =
        --eta=1e-400 | rules: eta =
        --eta 1 --system still.toml | no rule can be judged, since nothing drives the bodies
        ansys-mode NUMBERS --exponent 1.5 | --exponent is no number of the law ... give --law""",
    "serve": """
        --address ... | --address must be an IP address
        --port 65536 | port
        --port -1 | port
        --port http | port
        --port ² | port""",
    "validate": "B9 | unknown case 'B9'; known: B1",
    "sweep": """
        eta --from 1 --to 2 --count 6 --solver newmark --out a | needs --K, --D, --steps
        eta --from 1 --to 2 --count 6 --solver reference --over K --eta 2 --out a | has no K
        eta --from 3 --to 2 --count 6 --solver reference --out a | empty range
        eta --from 2 --to 3 --count 1e12 --solver reference --out a | count of eta
        eta --over d1 --from 1mm --to 2 --count 3 --solver reference --out a | --from '1mm': this number is given
        eta --from 1 --to 2 --count 2 --solver newmark --stiffness-of-step 1 --out a | --stiffness-of-step is no option
        eta --from 1 --to 2 --count 2 --solver newmark --K 9 --D 1 --steps 99 --exponent 2 --out a | --exponent is no
        plane --eta 2 --K 1:2:1e6 --D 1:2:1e6 --steps 100 --out a | sweep fewer values
        plane --eta 2 --K 1:2:3 --D 1:2:3 --out a | needs --steps
        plane --eta 2 --K 1:2 --D 1:2:3 --steps 9 --out a | a:b:n
        plane --eta 2 --K a:b:c --D 1:2:3 --steps 9 --out a | a:b:n
        plane --eta 2 --K 1:2:3:4 --D 1:2:3 --steps 9 --out a | a:b:n
        plane --eta 2 --K 1:2:2 --D 1:2:2 --steps 9 --stiffness-of-step 0.1 --out a | --stiffness-of-step is no option
        step --eta 1.08 --K 500 --D 2 --steps 60 --status located --out a | located steps stand beside
        basin AREA --x xi2:-8:8:8 --y xi2:-8:8:8 | two axes, not 1: give two different ones
        basin AREA --x xi2:8:-8:8 --y v2:-8:8:6 | empty range
        basin AREA --x xi2:-8:8:0 --y v2:-8:8:6 | count of xi2 = 0.0 is outside
        basin AREA --x xi2:-8:-7:4 --y v2:-8:8:6 | every start of this plane penetrates
        basin AREA --x xi2:-8:8:4 --y v2:-8:8:6 --phase 2 | phase = 2.0 is outside
        basin AREA --x phase:0:1s:4 --y v1:-8:8:4 | --x '1s': this number is given without a unit
        basin AREA --x K:1:2:3 --y v2:-8:8:6 | 'K:1:2:3' is no axis: give one of xi1, v1, xi2, v2, phase
        basin-difference nowhere nothing | is no result of a sweep
        check . | is no result of a sweep
        check nowhere.zarr | nowhere.zarr is no result of a sweep
        check my.toml | my.toml is no result of a sweep""",
    "branch": """
        --from 100 --to 200 --solver newmark | 'newmark' has a time step ... no branches: give 'reference', or 'exact'
        --from 100 --to 200 --law limited --solver exact | --law is no option
        --from 100 --to 200 --every-step | --every-step is no option
        --from 100 --to 200 --over K --eta 2.76 | branch: the reference method has no K: give another number or solver
        --from 1 --to 2 --solver exact --eta 1 --D 8 --stiffness-of-step 0.1 | --stiffness-of-step is no option
        --from 1 --to 2 --from-basin nowhere.zarr | nowhere.zarr is no result of a sweep
        --from 1 --to 2 --from-basin my.toml | my.toml is no result of a sweep
        --from 1 --to 2 --eta 1.5 --out . | exists and is no result of such a search
        --from 2 --to 3 --solver exact --K 12e3 --D 18 --along K | needs --along-from and --along-to
        --from 2 --to 3 --solver exact --K 12e3 --D 18 --along K --along-from 4 --along-to 3 | empty range
        --from 2 --to 3 --solver exact --K 9e3 --D 18 --along K --along-from 1 --along-to 3 | begin within the range""",
    "measurement": """
        --seed -1 | seed = -1
        --eta 1.7 | not periodic
        --per-period 2 | per_period = 2
        --system still.toml | nothing drives the bodies""",
    "export": """
        NUMBERS --to mujoco | no decks are written for 'mujoco': give one of opensees ... `vibroscope recommend --code`
        --to abaqus --system my.toml --K 9 --D 1 --steps 99 --out my.toml | --out my.toml: this command has the
        NUMBERS --to calculix --status start | CalculiX cannot express status = 'start'
        NUMBERS --to ansys --located | Ansys Mechanical APDL cannot express status = 'located'
        NUMBERS --to opensees --integrator bathe | OpenSeesPy cannot express integrator = 'bathe'
        NUMBERS --to abaqus --law cut | Abaqus/Standard cannot express law = 'cut'
        NUMBERS --to opensees --periods 0 | periods = 0
        NUMBERS --to opensees --periods 3 --keep 4 | keep = 4
        NUMBERS --to opensees --exponent 1.5 | --exponent is no number of the law ... give --law""",
    "completion": "ksh | bash",
}  # fmt: skip
CASES = [
    (command, *(part.strip() for part in f" {row}".split(" | ")))
    for command, rows in REFUSED.items()
    for row in rows.strip().splitlines()
]


@pytest.mark.parametrize(("command", "arguments", "words"), CASES)
def test_bad_input_is_refused_in_one_line(command, arguments, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(branch, "search_branches", None)  # it is refused before any search
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)
    for short, options in SHORT.items():
        arguments = arguments.replace(short, options)
    asked = [word.replace("⏎", "\n") for word in shlex.split(arguments)]
    status, out, err = run_command(capsys, command, *asked)
    assert (status, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"vibroscope {command}")
    for part in words.split(" ... "):
        assert part in err
    assert {path.name for path in tmp_path.iterdir()} == FILES.keys()
