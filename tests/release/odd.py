"""Odd values: what no page and no person would send, at random or from a list of what programs stumble over."""

import asyncio

from app.state import Setting
from tests.browserless import changed, event, mapped, move

NO_NUMBERS = ("nan", "inf", "-inf", "1e999", "²", "", "0x10", "é" * 50, "NaN%", "+")
ODD = (*NO_NUMBERS, "9" * 4000, "\0", "-0", "1e-400", "1_0", "1,5")


def run(steps, seconds=900):
    return asyncio.run(asyncio.wait_for(steps, seconds))


def random_text(chance):
    number = f"{chance.uniform(-1, 1) * 10 ** chance.randint(-3, 6):.{chance.randint(0, 17)}g}"
    noise = "".join(chr(chance.choice((chance.randint(0, 127), chance.randint(0, 0x2FFF)))) for _ in range(5))
    return chance.choice((number, number, chance.choice(ODD), noise, "yes", "derived", "xi1"))


def random_json(chance, depth=3):
    kinds = [random_text, lambda c: c.uniform(-9, 9), lambda c: None, lambda c: c.choice((True, float("nan"), 10**400))]
    if depth:
        kinds += [
            lambda c: [random_json(c, depth - 1) for _ in range(c.randint(0, 4))],
            lambda c: mapped({c.choice((*Setting._fields, "set", "move", "x")): random_json(c, depth - 1)}),
            lambda c: {c.choice(("type", "id", "entries", "kind")): random_json(c, depth - 1)},
        ]
    return chance.choice(kinds)(chance)


def forged(chance, client, model, value):
    """One event that no page would send."""
    kind = chance.randrange(5)
    if kind == 0:
        return client.message(value)
    if kind == 1:
        return client.message(move({chance.choice(Setting._fields): random_text(chance)}, chance.randint(0, 9)))
    if kind == 2:
        return changed(model, chance.choice(("start", "end", "data", "shown", "inner_width")), value)
    if kind == 3:
        return event(chance.choice(("tap", "rangesupdate", "data_event")), mapped({"model": {"id": model}, "x": value}))
    return value


def damaged(chance, content):
    """Some bytes changed, cut off, doubled or overwritten; at times nothing is left."""
    content = bytearray(content)
    for _ in range(chance.randint(1, 3)):
        at = chance.randrange(len(content) or 1)
        kind = chance.randrange(5)
        if kind == 0 and content:
            content[at] ^= 1 << chance.randrange(8)
        elif kind == 1:
            del content[at:]
        elif kind == 2:
            content[at:at] = content[at : at + 64]
        elif kind == 3:
            content[at : at + chance.randint(1, 20)] = chance.choice(ODD).encode()[:200] or b"\xff"
        elif chance.random() < 0.1:
            content.clear()
    return bytes(content)
