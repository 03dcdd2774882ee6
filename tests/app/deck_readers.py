"""What a deck says, read back from its text: masses, and the forces on the bodies at an instant and a state."""

import math
import re
import sys
from types import ModuleType
from typing import NamedTuple


class Body(NamedTuple):
    mass: float
    stiffness: float
    damping: float
    load: object  # of time
    relaxed: float = 0.0  # displacement at which its spring is relaxed


class Model(NamedTuple):
    bodies: list
    contact: object  # force of penetration and closing speed
    gap: float
    shifts: tuple = (0.0, 0.0)  # displacement minus that of the deck
    second: object = None  # force of the second stop
    second_gap: float = math.inf

    def forces(self, time, x, v):
        """On each body; the second is a wall if there is one body."""
        x = [value - shift for value, shift in zip(x, self.shifts, strict=True)]
        depth, speed = x[0] - x[1] - self.gap, v[0] - v[1]
        push, beyond = self.contact(depth, speed) if depth >= 0 else 0.0, x[1] - x[0] - self.second_gap
        push -= self.second(beyond, -speed) if beyond >= 0 else 0.0
        return [
            body.load(time) - body.stiffness * (x[i] - body.relaxed) - body.damping * v[i] + (push if i else -push)
            for i, body in enumerate(self.bodies)
        ]


def linear(stiffness, damping):
    return lambda depth, speed: stiffness * depth + damping * speed


class FakeOpenSees(ModuleType):
    """Records the calls of a deck; an analysis leaves the bodies where they are, and fails from a step on."""

    def __init__(self, fails=math.inf):
        super().__init__("openseespy.opensees")
        self.calls, self.fails = [], fails

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)

        def call(*arguments):
            self.calls.append((name, *arguments))
            if name == "analyze":
                return -3 if sum(each[0] == name for each in self.calls) >= self.fails else 0
            return 0.25 if name == "nodeDisp" else None

        return call

    def found(self, name):
        return [each[1:] for each in self.calls if each[0] == name]


def run_fake(text, monkeypatch, folder, fails=math.inf):
    fake, package = FakeOpenSees(fails), ModuleType("openseespy")
    package.opensees = fake
    monkeypatch.setitem(sys.modules, "openseespy", package)
    monkeypatch.setitem(sys.modules, "openseespy.opensees", fake)
    try:
        exec(compile(text, "deck", "exec"), {"__file__": str(folder / "deck.py"), "__name__": "deck"})
    except SystemExit as end:
        if end.code:
            raise
    return fake


def read_opensees(text, monkeypatch, folder):
    fake = run_fake(text, monkeypatch, folder)
    masses = dict(fake.found("mass"))
    materials = {each[1]: each for each in fake.found("uniaxialMaterial")}
    series = {}
    for kind, tag, *rest in fake.found("timeSeries"):
        if kind == "Constant":
            series[tag] = lambda t: 1.0
            continue
        period, shift = rest[2], rest[4] if "-shift" in rest else 0.0
        series[tag] = lambda t, period=period, shift=shift: math.sin(2 * math.pi * t / period + shift)
    pattern, loads = None, {1: [], 2: []}
    for name, *arguments in fake.calls:
        if name == "pattern":
            pattern = arguments[2]
        elif name == "load":
            loads[arguments[0]].append((pattern, arguments[1]))
    shift = float(re.search(r"^SHIFT = (\S+)", text, re.MULTILINE)[1])
    bodies = [
        Body(mass, *materials[i][2:4], lambda t, i=i: sum(series[tag](t) * value for tag, value in loads[i]))
        for i, mass in masses.items()
    ]
    _, _, stiffness, damping, gap = materials[3]
    second, second_gap = None, -math.inf
    if 4 in materials:
        assert ("zeroLength", 4, 2, 1, "-mat", 4, "-dir", 1) in fake.found("element")
        _, _, *numbers, second_gap = materials[4]
        second = linear(*numbers)
    return Model(bodies, linear(stiffness, damping), -gap, (-shift, 0.0), second, -second_gap), fake


def keywords(text):
    """Keyword, its parameters, and its lines of numbers, of an input file of Abaqus or CalculiX."""
    found = []
    for line in text.splitlines():
        if line.startswith("**"):
            continue
        if line.startswith("*"):
            name, *parameters = (part.strip() for part in line[1:].split(","))
            found.append((name, dict((*part.split("="), None)[:2] for part in parameters), []))
        elif found:
            found[-1][2].append([part.strip() for part in line.split(",")])
    return found


def read_keywords(text):
    """The model of an input file of Abaqus or CalculiX; displacements are counted from the start."""
    blocks = keywords(text)
    nodes = {row[0]: [float(part) for part in row[1:]] for name, _, rows in blocks if name == "NODE" for row in rows}

    def number(keyword, group, line):
        rows = [rows for name, parameters, rows in blocks if name == keyword and parameters.get("ELSET") == group]
        return float(rows[0][line][0]) if rows else 0.0

    def amplitude(i):
        _, parameters, rows = next(each for each in blocks if each[0] == "AMPLITUDE" and each[1]["NAME"] == f"LOAD{i}")
        values = [[float(part) for part in row] for row in rows]
        if parameters.get("DEFINITION") == "PERIODIC":
            (_, omega, begin, mean), (cosine, sine) = values
            return lambda t: mean + cosine * math.cos(omega * (t - begin)) + sine * math.sin(omega * (t - begin))
        return lambda t: min(values, key=lambda pair: abs(pair[0] - t))[1]

    def mass(i):
        lumped = number("MASS", f"MASS{i}", 0)
        if lumped or any(name == "MASS" for name, _, _ in blocks):
            return lumped
        density = next(rows for at, (name, _, rows) in enumerate(blocks) if name == "DENSITY" and is_material(at, i))
        corners = [nodes[str(10 * i + k)] for k in range(1, 9)]
        sides = [max(axis) - min(axis) for axis in zip(*corners, strict=True)]
        return float(density[0][0]) * math.prod(sides)

    def is_material(at, i):
        before = [parameters for name, parameters, _ in blocks[:at] if name == "MATERIAL"]
        return before[-1]["NAME"] == f"BODY{i}"

    loaded = [parameters["AMPLITUDE"] for name, parameters, _ in blocks if name == "CLOAD"]
    bodies = [
        Body(mass(i), number("SPRING", f"SPRING{i}", 1), number("DASHPOT", f"DAMPER{i}", 1), amplitude(i))
        for i in (1, 2)
        if f"LOAD{i}" in loaded
    ]
    slave = [nodes[str(node)] for node in (15, 16, 17, 18)] if "15" in nodes else None
    area = (slave[1][1] - slave[0][1]) * (slave[2][2] - slave[1][2]) if slave else 1.0
    gap = nodes["21"][0] - slave[0][0] if slave else nodes["3"][0] - nodes["2"][0]
    touch = next(
        (rows for name, parameters, rows in blocks if parameters.get("ELSET") == "TOUCH" and name == "SPRING"), None
    )
    if touch:
        (push, deep), (_, begin), *others = [[float(part) for part in row] for row in touch]
        model = Model(bodies, linear(push / (deep - begin), 0.0), -begin)
        if len(others) == 1:
            return model
        (_, end), (pull, far) = others
        return model._replace(second=linear(pull / (far - end), 0.0), second_gap=end)
    stops = zip(
        *(
            [float(rows[0][0]) * area for name, _, rows in blocks if name == keyword]
            for keyword in ("SURFACE BEHAVIOR", "CONTACT DAMPING")
        ),
        strict=True,
    )
    first, *others = [linear(*numbers) for numbers in stops]
    if not others:
        return Model(bodies, first, gap)
    second_gap = nodes["11"][0] - nodes["35"][0] if slave else nodes["2"][0] - nodes["5"][0]
    return Model(bodies, first, gap, second=others[0], second_gap=second_gap)


def read_ansys(text):
    """The model of a file for Mechanical APDL."""
    reals = {
        int(row[0]): [float(part) for part in row[1:]]
        for row in (r.split(",") for r in re.findall(r"(?m)^R,(.*)$", text))
    }
    loads = dict(re.findall(r"(?m)^  LOAD(\d)\(K\+1,1\)=(.*)$", text))
    step, n = float(re.search(r"LOAD1\(K\+1,0\)=K\*(\S+)", text)[1]), int(re.search(r"MOD\(K,(\d+)\)", text)[1])

    def load(i):
        def at(t):
            angle = 2 * math.pi * (round(t / step) % n) / n
            return eval(loads[str(i)], {"COS": math.cos, "SIN": math.sin, "A": angle})

        return at

    bodies = [Body(reals[i][0], *reals[10 + i], load(i)) for i in (1, 2) if i in reals]
    stiffness, damping, _, gap = reals[30]
    model = Model(bodies, linear(stiffness, damping), gap)
    if 31 not in reals:
        return model
    assert "REAL,31\nE,3,2\n" in text
    stiffness, damping, _, second_gap = reals[31]
    return model._replace(second=linear(stiffness, damping), second_gap=second_gap)


def read_modelica(text):
    """The equations of a model, evaluated; returns a function as `Model.forces`, the masses and the starts."""
    body = "\n".join(line for line in text.splitlines() if not line.startswith("//"))
    parameters = {name: float(value) for name, value in re.findall(r"parameter Real (\w+) = (\S+?)[; ]", body)}
    law = re.search(r"force = \(if depth >= 0 then (.*?) else 0\)", body)[1].replace("der(depth)", "(v1 - v2)")
    second = re.search(r"force = .* - \(if depth2 >= 0 then (.*?) else 0\);", body)
    second_depth = re.search(r"  Real depth2 = (.*) \"", body)
    depth = re.search(r"  depth = (.*);", body)[1]
    motions = re.findall(r"  (\S+)\*der\(v(\d)\) \+ (.*) = (.*);", body)
    masses = [float(mass) for mass, *_ in motions]
    words = {"cos": math.cos, "sin": math.sin, "max": max, "min": min} | parameters

    def forces(time, x, v):
        known = words | {"time": time, "xi1": x[0], "xi2": x[1], "v1": v[0], "v2": v[1]}
        known["depth"] = eval(depth, known)
        known["force"] = eval(law, known) if known["depth"] >= 0 else 0.0
        if second:
            known["depth2"] = eval(second_depth[1], known)
            pull = eval(second[1].replace("der(depth2)", "(v2 - v1)"), known)
            known["force"] -= pull if known["depth2"] >= 0 else 0.0
        return [eval(right, known) - eval(left, known) for _, _, left, right in motions]

    return forces, masses
