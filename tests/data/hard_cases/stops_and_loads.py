"""Bodies with and without springs, between one stop or two, under pulses and records, for stops_and_loads.json.

Every generator yields (name, case); a case is described in high_precision/bodies.py. The method is in the name. Numbers
are sums of few powers of two, so that what follows from them (a frequency ratio, a damping ratio) is exact as well.
"""

SAMPLES = 16  # of a case that has no periods
LIMIT = 1e-24  # a threshold that cannot be distinguished from its limit 0 in double precision


def _stops(restitutions, penalties):
    """Both methods: [(name, stops)]."""
    yield "reference", [{"restitution": e} for e in restitutions]
    yield "exact", [{"stiffness": stiffness, "damper": damper} for stiffness, damper in penalties]


def _cases(name, case, e, penalty, *, threshold=LIMIT, methods=("reference", "exact")):
    """A case by both methods; e and penalty of each stop. One number of each list stands for all bodies or stops."""
    case = {"spring": [0.0], "damper": [0.0], "constant": [0.0], "clearance": 0.0, "loads": []} | case
    bodies, stops = len(case["mass"]), 2 if "play" in case else 1
    for key in ("spring", "damper", "constant"):
        case[key] = case[key] * (bodies if len(case[key]) == 1 else 1)
    case = {"start": [0.0] * 4, "samples": SAMPLES} | case
    for method, each in _stops(e * (stops if len(e) == 1 else 1), penalty * (stops if len(penalty) == 1 else 1)):
        if method in methods:
            yield (
                f"{name}|{method}",
                case | {"stops": each} | ({"threshold": threshold} if method == "reference" else {}),
            )


def _shaken(amplitude, frequency=1.0, phase=0.0, on="base"):
    return [{"on": on, "form": "harmonic", "amplitude": amplitude, "frequency": frequency, "phase": phase}]


def _for(periods, frequency=1.0):
    return {"periods": periods, "frequency": frequency, "samples": 4 * periods}


def free_ball():
    """A body without a spring on a table: dropped, thrown, shaken, damped."""
    ball = {"mass": [1.0]}
    soft = [(400.0, 4.0)]
    drop = ball | {"constant": [0.75], "clearance": 3.0} | _for(2)
    yield from _cases("ball|dropped", drop, [0.5], soft)
    yield from _cases("ball|dropped, e 0.75", drop, [0.75], [(1024.0, 0.0)])
    yield from _cases("ball|dropped, in a damper", drop | {"damper": [0.25]}, [0.625], soft)
    yield from _cases("ball|thrown up", drop | {"start": [1.0, -2.0, 0.0, 0.0]}, [0.5], soft)
    yield from _cases(
        "ball|thrown without weight", ball | {"clearance": 2.0, "start": [0.0, 0.5, 0.0, 0.0]} | _for(2), [0.75], soft
    )
    table = ball | {"constant": [0.5]} | _for(4)
    for base, e in ((0.25, 0.5), (1.0, 0.5), (2.0, 0.75), (1.0, 0.0)):
        name = f"ball|shaken, {base:g}, e {e:g}"
        yield from _cases(name, table | {"loads": _shaken(base)}, [e], [(900.0, 8.0)])
    yield from _cases(
        "ball|shaken, threshold", table | {"loads": _shaken(2.0, phase=0.5)}, [0.75], [(4096.0, 16.0)], threshold=0.0625
    )
    pushed = table | {"loads": _shaken(1.5, 2.0, on="body 1"), "clearance": 0.5} | _for(5, 2.0)
    yield from _cases("ball|driven by a force", pushed, [0.75], [(400.0, 2.0)])
    weak = ball | {"spring": [2.0**-10], "constant": [8.0], "clearance": 3.0, "damper": [2.0**-6]} | _for(1)
    yield from _cases("ball|on a weak spring", weak, [0.5], [(900.0, 4.0)])


def free_pair():
    """Two bodies of which one or none has a spring."""
    for name, springs in (("no spring", [0.0, 0.0]), ("spring 2", [0.0, 0.5]), ("spring 1", [1.0, 0.0])):
        pair = {"mass": [1.0, 0.5], "spring": springs, "clearance": 0.5}
        flying = pair | {"start": [0.0, 1.0, 0.25, -0.25]} | _for(2)
        yield from _cases(f"pair|{name}, meet", flying, [0.5], [(400.0, 4.0)])
        yield from _cases(
            f"pair|{name}, damped, shaken",
            flying | {"damper": [0.125, 0.25], "loads": _shaken(1.0, 1.5)} | _for(4, 1.5),
            [0.75],
            [(900.0, 2.0)],
        )
        forced = pair | {"loads": _shaken(1.5, on="body 1")} | _for(3)
        yield from _cases(f"pair|{name}, driven by a force", forced, [0.5], [(256.0, 8.0)])
    pressed = {
        "mass": [1.0, 2.0],
        "spring": [0.0, 2.0],
        "clearance": -0.5,
        "damper": [0.25, 0.5],
        "start": [-0.25, 0.0, 0.25, 0.0],
    }
    yield from _cases(
        "pair|one free, joined", pressed | {"loads": _shaken(1.0, 0.75)} | _for(2, 0.75), [0.5], [(900.0, 4.0)]
    )


def free_weight():
    """A free body that a constant force pulls to a sprung one: a ball on a table, a hammer on an anvil."""
    table = {"mass": [1.0, 0.25], "spring": [1.0, 0.0], "damper": [0.125, 0.0], "constant": [0.0, -0.125]}
    hammer = {"mass": [1.0, 0.5], "spring": [0.0, 2.0], "damper": [0.0625, 0.25], "constant": [0.75, 0.0]}
    soft = [(400.0, 4.0)]
    dropped = table | {"start": [0.0, 0.0, 1.0, 0.0]} | _for(3)
    yield from _cases("weight|ball dropped on a sprung table", dropped, [0.5], soft)
    shaken = table | {"start": [0.0, 0.0, 0.5, 0.25], "loads": _shaken(1.0, 1.5)} | _for(3, 1.5)
    yield from _cases("weight|ball on a shaken sprung table", shaken, [0.75], [(256.0, 0.0)])
    falling = table | {"damper": [0.125, 0.125], "start": [0.0, 0.0, 2.0, 0.5], "loads": _shaken(0.5)} | _for(2)
    yield from _cases("weight|ball in a damper, threshold", falling, [0.5], soft, threshold=0.125)
    blow = hammer | {"clearance": 0.5, "loads": _shaken(1.5, 0.75, on="body 1")} | _for(2, 0.75)
    yield from _cases("weight|hammer on a sprung anvil", blow, [0.25], [(900.0, 6.0)])
    resting = hammer | {"start": [0.75, 0.0, 0.75, 0.0], "loads": _shaken(1.0)} | _for(2)
    yield from _cases("weight|hammer at rest on a shaken anvil", resting, [0.0], soft)
    thrown = table | {"constant": [0.5, 0.125], "start": [0.0, 0.0, 0.25, -1.0]} | _for(1)
    yield from _cases("weight|balloon thrown at a table", thrown, [0.5], soft)
    caged = table | {"clearance": 0.25, "play": 0.75, "loads": _shaken(1.0, 1.25)} | _for(2, 1.25)
    yield from _cases("weight|ball in a sprung cage", caged, [0.75, 0.5], [(400.0, 4.0), (900.0, 2.0)])
    struck = table | {"start": [-0.125, 0.0, -0.125, 0.0], "end": 6.0}
    shock = {"form": "half-sine", "peak": 2.0, "duration": 1.5, "on": "base"}
    yield from _cases("weight|ball on a struck table", struck | {"loads": [shock]}, [0.5], soft)


def free_weights():
    """Two bodies without springs under constant forces: thrown at each other, pressed together, falling."""
    pair, soft = {"mass": [1.0, 0.5], "spring": [0.0], "clearance": 0.5}, [(400.0, 4.0)]
    towards = pair | {"constant": [0.25, -0.125]} | _for(2)
    yield from _cases("weights|pressed together", towards, [0.5], soft)
    damped = towards | {"damper": [0.25, 0.0625], "loads": _shaken(1.0, 1.5, on="body 1")} | _for(4, 1.5)
    yield from _cases("weights|pressed together, damped, driven", damped, [0.75], [(900.0, 2.0)])
    yield from _cases("weights|pressed together, threshold", damped, [0.5], soft, threshold=0.125)
    falling = pair | {"constant": [-0.5, -0.5], "start": [0.0, 0.0, 0.25, -0.25]} | _for(2)
    yield from _cases("weights|falling, one faster", falling, [0.75], soft)
    alike = pair | {"constant": [-0.5, -0.25], "start": [0.0, 0.5, 0.0, -0.25]}
    yield from _cases("weights|falling alike", alike | _for(1), [0.5], soft)
    yield from _cases("weights|falling alike in dampers", alike | {"damper": [0.25, 0.25]} | _for(2), [0.75], soft)
    anvil = {"mass": [1.0, 4.0], "spring": [0.0], "damper": [0.0, 0.5], "constant": [0.75, 0.0], "clearance": 1.0}
    blow = anvil | {"loads": _shaken(1.5, 0.75, on="body 1")} | _for(2, 0.75)
    yield from _cases("weights|hammer on a free plate", blow, [0.25], [(900.0, 6.0)])
    held = anvil | {"clearance": 0.0, "loads": _shaken(6.0, on="body 2")} | _for(2)
    yield from _cases("weights|held together and torn apart", held, [0.0], [(256.0, 16.0)])
    caged = pair | {"constant": [-0.25, 0.25], "play": 1.25, "loads": _shaken(0.5, 1.25, on="body 2")} | _for(3, 1.25)
    yield from _cases("weights|ball in a free cage", caged, [0.75, 0.5], [(400.0, 4.0), (900.0, 2.0)])
    struck = towards | {"damper": [0.125, 0.25], "end": 6.0}
    del struck["periods"], struck["frequency"]
    shock = {"form": "half-sine", "peak": 2.0, "duration": 1.5, "on": "body 1"}
    yield from _cases("weights|struck", struck | {"loads": [shock], "samples": SAMPLES}, [0.5], soft)


def two_stops():
    """One body between two walls, or two bodies that are linked with play."""
    free = {"mass": [1.0], "clearance": 1.0, "play": 2.0}
    impact_pair = free | {"loads": _shaken(0.5, 1.5)} | _for(4, 1.5) | {"start": [0.25, 0.5, 0.0, 0.0]}
    soft, unlike = [(900.0, 6.0)], [(400.0, 4.0), (2500.0, 10.0)]
    yield from _cases("two stops|impact pair", impact_pair, [0.75], soft)
    yield from _cases("two stops|impact pair, unlike", impact_pair, [0.5, 0.875], unlike)
    yield from _cases(
        "two stops|impact pair, thrown", free | {"start": [0.0, 1.0, 0.0, 0.0]} | _for(2), [0.75, 0.5], unlike
    )
    wild = free | {"clearance": 0.25, "play": 0.5, "damper": [0.25], "loads": _shaken(2.0, phase=0.75)} | _for(3)
    yield from _cases("two stops|chatter on both sides", wild, [0.5, 0.25], unlike)
    yield from _cases("two stops|sticking, threshold", wild | {"damper": [0.125]}, [0.625], soft, threshold=0.125)
    yield from _cases("two stops|no rebound", wild | {"loads": _shaken(2.0, phase=0.25)}, [0.0], soft)
    backlash = free | {"mass": [1.0], "spring": [0.25], "clearance": 0.125, "play": 0.25, "damper": [0.0625]}
    yield from _cases(
        "two stops|backlash",
        backlash | {"loads": _shaken(0.5, 0.75, on="body 1")} | _for(3, 0.75),
        [0.5],
        [(64.0, 1.0)],
    )
    tube = {"mass": [1.0], "spring": [1.0], "damper": [0.0625], "clearance": 0.5, "play": 1.0}
    for eta in (0.75, 1.0, 1.5):
        case = tube | {"loads": _shaken(0.75, eta)} | _for(4, eta)
        yield from _cases(f"two stops|tube in a loose support, {eta:g}", case, [0.75], [(400.0, 2.0)])
    aside = tube | {"clearance": 0.25, "constant": [0.125], "loads": _shaken(1.0, 1.25, on="body 1")} | _for(4, 1.25)
    yield from _cases("two stops|tube beside its middle", aside, [0.75, 0.5], unlike)
    preload = tube | {"clearance": -0.25, "play": 0.75, "start": [-0.25, 0.0, 0.0, 0.0], "loads": _shaken(1.0, 1.25)}
    yield from _cases("two stops|tube pressed to one side", preload | _for(3, 1.25), [0.5], soft)
    link = {"mass": [1.0, 0.5], "spring": [1.0, 2.0], "damper": [0.03125, 0.0625], "clearance": 0.5, "play": 1.25}
    for eta in (1.0, 2.0):
        case = link | {"loads": _shaken(1.0, eta)} | _for(4, eta)
        yield from _cases(f"two stops|two bodies, {eta:g}", case, [0.75, 0.5], unlike)
    yield from _cases(
        "two stops|two bodies without springs",
        impact_pair | {"mass": [1.0, 0.5], "clearance": 0.75, "loads": _shaken(1.0, 1.5, on="body 1")},
        [0.75],
        soft,
    )


def pulses():
    """Base shocks and pushes from rest, and what follows."""
    shapes = {
        "half-sine": {"form": "half-sine", "peak": 2.0, "duration": 1.5},
        "sawtooth": {"form": "sawtooth", "peak": 2.0, "duration": 1.5},
        "trapezoid": {"form": "trapezoid", "peak": 1.5, "rise": 0.25, "hold": 1.0, "fall": 0.5},
    }
    body = {"mass": [1.0], "spring": [1.0], "damper": [0.125], "end": 12.0}
    pair = {"mass": [1.0, 0.5], "spring": [1.0, 2.0], "damper": [0.0625, 0.03125], "clearance": 0.25, "end": 12.0}
    for name, shape in shapes.items():
        shock = {"loads": [shape | {"on": "base"}]}
        towards = {"loads": [shape | {"on": "base", "peak": -shape["peak"]}]}
        pressed = body | {"clearance": -0.125, "start": [-0.125, 0.0, 0.0, 0.0]}
        yield from _cases(f"pulse|{name}, wall", body | {"clearance": 0.5} | towards, [0.5], [(400.0, 4.0)])
        yield from _cases(f"pulse|{name}, pressed to a wall", pressed | shock, [0.75], [(400.0, 4.0)])
        yield from _cases(f"pulse|{name}, two bodies", pair | shock, [0.5], [(900.0, 6.0)])
    yield from _cases(
        "pulse|half-sine on body 1", pair | {"loads": [shapes["half-sine"] | {"on": "body 1"}]}, [0.5], [(900.0, 6.0)]
    )
    yield from _cases(
        "pulse|half-sine, no contact",
        body | {"clearance": 64.0, "loads": [shapes["half-sine"] | {"on": "base"}]},
        [0.5],
        [(900.0, 6.0)],
        methods=["reference"],
    )
    drop = {"mass": [1.0], "constant": [1.0], "loads": [shapes["half-sine"] | {"on": "base", "peak": 4.0}], "end": 12.0}
    yield from _cases("pulse|body on a table", drop, [0.5], [(256.0, 8.0)])
    box = {"mass": [1.0], "spring": [0.25], "damper": [0.125], "clearance": 0.75, "play": 1.5, "end": 12.0}
    for name, shape in shapes.items():
        yield from _cases(
            f"pulse|{name}, two stops",
            box | {"loads": [shape | {"on": "base"}]},
            [0.5, 0.75],
            [(256.0, 2.0), (512.0, 4.0)],
        )
    packed = {
        "mass": [1.0, 0.25],
        "spring": [1.0, 1.0],
        "damper": [0.25, 0.125],
        "constant": [0.5, 0.0],
        "clearance": 0.25,
        "end": 8.0,
    }
    yield from _cases(
        "pulse|packaging",
        packed | {"loads": [shapes["half-sine"] | {"on": "base", "duration": 0.5, "peak": -8.0}]},
        [0.25],
        [(1024.0, 8.0)],
    )


def _record(on):
    """A small earthquake: 24 samples at unequal distances."""
    value = [0, 3, -5, 8, -13, 21, -18, 9, 11, -24, 17, -6, 15, -19, 22, -8, 4, 12, -16, 7, -3, 2, -1, 0]
    steps = [2, 2, 2, 3, 2, 4, 2, 2, 3, 2, 2, 2, 5, 2, 2, 3, 2, 2, 2, 4, 2, 2, 2]
    time = [sum(steps[:k]) / 8 for k in range(len(value))]
    return [{"on": on, "form": "record", "time": time, "value": [x / 4 for x in value]}]


def records():
    """Loads that are linear between samples."""
    wall = {"mass": [1.0], "spring": [1.0], "damper": [0.0625], "end": 12.0}
    pair = {"mass": [1.0, 0.5], "spring": [1.0, 2.0], "damper": [0.0625, 0.03125], "end": 12.0}
    for on in ("base", "body 1"):
        yield from _cases(
            f"record|{on}, wall", wall | {"clearance": 0.125, "loads": _record(on)}, [0.5], [(400.0, 4.0)]
        )
        yield from _cases(
            f"record|{on}, two bodies", pair | {"clearance": 0.125, "loads": _record(on)}, [0.5], [(900.0, 6.0)]
        )
        yield from _cases(
            f"record|{on}, two bodies pressed together",
            pair | {"clearance": -0.25, "start": [-0.125, 0.0, 0.125, 0.0], "loads": _record(on)},
            [0.75],
            [(900.0, 6.0)],
        )
    yield from _cases(
        "record|base, ball on a table",
        wall | {"spring": [0.0], "constant": [1.0], "loads": _record("base")},
        [0.5],
        [(400.0, 4.0)],
    )
    yield from _cases(
        "record|base, two stops",
        wall | {"clearance": 0.125, "play": 0.25, "loads": _record("base")},
        [0.5, 0.75],
        [(400.0, 4.0), (900.0, 2.0)],
    )
    yield from _cases(
        "record|body 2, two stops, two bodies",
        pair | {"clearance": 0.5, "play": 1.0, "loads": _record("body 2")},
        [0.5, 0.75],
        [(400.0, 4.0), (900.0, 2.0)],
    )


GROUPS = (free_ball, free_pair, free_weight, free_weights, two_stops, pulses, records)
