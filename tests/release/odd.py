"""Odd inputs that no page and no person would send: random ones, and a list of known stumbling blocks."""

import asyncio

from vibroscope.app.explorer.link import VIEW_FIELDS
from vibroscope.app.explorer.parameters import FIELDS
from vibroscope.app.explorer.physical_fields import PHYSICAL_FIELDS
from vibroscope.app.explorer.presets import presets
from vibroscope.app.explorer.state import Setting
from vibroscope.app.page.address import THEMES
from vibroscope.app.page.tabs import VIEWS

from tests.browserless import changed, event, mapped, move

NO_NUMBERS = ("nan", "inf", "-inf", "1e999", "²", "", "0x10", "é" * 50, "NaN%", "+")
ODD = (*NO_NUMBERS, "9" * 4000, "\0", "-0", "1e-400", "1_0", "1,5")

# Everything that a component of the page listens to, and everything that a tab offers to zoom or choose.
MESSAGE_KEYS = (
    *(
        "set",
        "scene",
        "undo",
        "redo",
        "reset",
        "pin",
        "unpin",
        "view",
        "theme",
        "take",
        "painted",
        "file",
        "part",
        "end",
    ),
    *("stop", "choose", "suggest", "cancel", "seen", "listens"),  # a study, the search, a claim, the feed
)
FILES = ("toml", "python", "command", "json", "report", "csv:time", "csv:", "png:force?dpi=1e9", "svg:phase1?time=9")
AXES = sorted({name for tab in VIEWS.values() for name in tab.axes})
CHOICES = [(each.name, value) for tab in VIEWS.values() for each in tab.choices for value in each.words or ("3",)]
SELECTORS = {name: list(field.choices) for name, field in FIELDS.items() if field.choices}
LEGENDS = [legend for tab in VIEWS.values() for legend in tab.legends.items()]


def run(steps, seconds=900):
    return asyncio.run(asyncio.wait_for(steps, seconds))


def random_text(chance):
    number = f"{chance.uniform(-1, 1) * 10 ** chance.randint(-3, 6):.{chance.randint(0, 17)}g}"
    noise = "".join(chr(chance.choice((chance.randint(0, 127), chance.randint(0, 0x2FFF)))) for _ in range(5))
    return chance.choice((number, number, chance.choice(ODD), noise, "yes", "derived", "xi1"))


def random_query(chance, pairs=5):
    """Return an address query: numbers, tabs, pins, zooms, choices, mutes and unknown names, some of them twice."""
    names = (*Setting._fields, *VIEW_FIELDS, *VIEW_FIELDS, "bokeh-token", "x")
    chosen = [chance.choice(names) for _ in range(chance.randint(0, pairs))]
    return "&".join(f"{name}={_value(chance, name)}" for name in chosen)


def _value(chance, name):
    if name in SELECTORS and chance.random() < 0.7:
        return chance.choice(SELECTORS[name])
    if name not in VIEW_FIELDS or chance.random() < 0.2:
        return random_text(chance)
    if name == "view":
        return chance.choice([*VIEWS])
    if name == "pin":
        return random_query(chance, 1).replace("&", "%26").replace("=", "%3D")
    if name == "theme":
        return chance.choice(THEMES)
    part = {"zoom": _zoomed, "choice": _chosen, "mute": _muted}[name]
    return ";".join(part(chance) for _ in range(chance.randint(1, 2)))


def _zoomed(chance):
    low = chance.uniform(0, 1)
    ends = chance.choice((f"{low:g},{low + 1:g}", f"{random_text(chance)},{random_text(chance)}"))
    return f"{chance.choice(AXES)}:{ends}"


def _chosen(chance):
    name, value = chance.choice(CHOICES)
    return f"{name}:{chance.choice((value, value, random_text(chance)))}"


def _muted(chance):
    figure, entries = chance.choice(LEGENDS)
    return f"{figure}:{','.join(chance.choice((*entries, *entries, random_text(chance))) for _ in range(2))}"


METHODS = (
    b"GET",
    b"GET",
    b"GET",
    b"HEAD",
    b"POST",
    b"PUT",
    b"DELETE",
    b"OPTIONS",
    b"TRACE",
    b"CONNECT",
    b"BREW",
    b"get",
)
PLACES = (b"/", b"/static/", b"/static/js/bokeh.min.js", b"/static/extensions/panel/", b"/speed/", b"/ws", b"/liveness")
PLACES += (b"/metrics", b"/favicon.ico", b"/components/", b"/autoload.js", b"*", b"", b"http://127.0.0.1/", b"//x/")
STEPS = (b"%00", b"\0", b"%2e%2e/", b"../", b"%2e%2e%2f", b"%5c..", b"%ff", b"\xff\xfe", b"\xc3\xa9", b"%c0%af", b"%")
STEPS += (
    b"%zz",
    b"%u0000",
    b"%0d%0a",
    b"\r",
    b"\t",
    b" ",
    b"a" * 300,
    b"a/" * 2000,
    b"%61" * 30_000,
    b"?%00",
    b"#",
    b";",
)
VERSIONS = (*[b"HTTP/1.1"] * 6, b"HTTP/1.0", b"HTTP/0.9", b"HTTP/2.0", b"HTTP/1.1 x", b"http/1.1", b"")
HEADERS = (
    b"Host",
    b"Range",
    b"If-None-Match",
    b"If-Modified-Since",
    b"Cookie",
    b"Content-Length",
    b"Transfer-Encoding",
)
HEADERS += (b"Upgrade", b"Connection", b"Content-Type", b"Content-Encoding", b"Expect", b"Origin", b"Authorization")
HEADERS += (
    b"Sec-WebSocket-Version",
    b"Sec-WebSocket-Key",
    b"Sec-WebSocket-Protocol",
    b"X-Forwarded-For",
    b"Accept",
    b"",
)
VALUES = (
    b"bytes=0-5",
    b"bytes=9-1",
    b"bytes=-9999999",
    b"chunked",
    b"websocket",
    b"Upgrade",
    b"13",
    b"100-continue",
    b"-1",
)
VALUES += (
    b"0",
    b"99999999999",
    b"1, 2",
    b"\xff",
    b"\0",
    b'W/"',
    b"*",
    b"x" * 70_000,
    b"multipart/form-data; boundary=",
    b"",
)
VALUES += (
    b"bokeh, x.y",
    b"gzip",
    b"Thu, 99 Foo 2026 25:00:00 GMT",
    b"application/x-www-form-urlencoded",
    b"Bearer \xc3\xa9",
)


def random_request(chance, host):
    """Return a request as bytes, which may be invalid HTTP."""
    steps = [chance.choice(STEPS) for _ in range(chance.randint(0, 3))]
    path = chance.choice(PLACES) + b"".join(steps)
    lines = [b" ".join((chance.choice(METHODS), path, chance.choice(VERSIONS)))]
    if chance.random() < 0.9:
        lines.append(b"Host: " + host)
    names = [chance.choice(HEADERS) for _ in range(chance.choice((0, 0, 1, 3)))]
    lines += [name + chance.choice((b": ", b": ", b": ", b":", b" ")) + chance.choice(VALUES) for name in names]
    return b"\r\n".join(lines) + b"\r\n\r\n" + chance.choice((b"", b"", b"0\r\n\r\n", b"zz\r\n", b"\0" * 50))


def random_json(chance, depth=3):
    kinds = [random_text, lambda c: c.uniform(-9, 9), lambda c: None, lambda c: c.choice((True, float("nan"), 10**400))]
    if depth:
        kinds += [
            lambda c: [random_json(c, depth - 1) for _ in range(c.randint(0, 4))],
            lambda c: mapped({c.choice((*Setting._fields, *MESSAGE_KEYS, "move", "x")): random_json(c, depth - 1)}),
            lambda c: {c.choice(("type", "id", "entries", "kind")): random_json(c, depth - 1)},
        ]
    return chance.choice(kinds)(chance)


def random_message(chance):
    """Return a message to a component of the page: a key that one of them knows, with a value that may fit."""
    if chance.random() < 0.3:
        text = random_text(chance)
        name = chance.choice((*Setting._fields, *PHYSICAL_FIELDS))
        return move({name: chance.choice((text, text, mapped({"typed": text})))}, chance.randint(0, 9))
    fitting = {
        "view": chance.choice([*VIEWS]),
        "scene": chance.choice([*presets()]),
        "theme": chance.choice(THEMES),
        "take": chance.choice(FILES),
        "choose": mapped(dict([chance.choice(CHOICES)])),
        "part": mapped({"0": "[setting]\n", "1": f"{chance.choice(('eta', 'K', 'scheme'))} = {random_text(chance)}"}),
        "stop": chance.random() < 0.5,
        "suggest": random_text(chance),
    }
    key = chance.choice(MESSAGE_KEYS)
    value = fitting.get(key) if chance.random() < 0.5 else random_json(chance)
    return mapped({key: value, "move": chance.choice((1, random_json(chance, 1)))})


def forged(chance, model, component, value):
    """Return an event that no page sends, about a model of the document or to a component of the page."""
    kind = chance.randrange(6)
    if kind == 0:
        return _component_message(component, value)
    if kind < 3:
        return _component_message(component, random_message(chance))
    if kind == 3:
        return changed(model, chance.choice(("start", "end", "visible", "data", "shown", "inner_width")), value)
    if kind == 4:
        return event(chance.choice(("tap", "rangesupdate", "data_event")), mapped({"model": {"id": model}, "x": value}))
    return value


def _component_message(component, data):
    return event("data_event", mapped({"model": {"id": component}, "data": data}))


def damaged(chance, content):
    """Return the content with some bytes changed, cut off, doubled or overwritten; sometimes nothing is left."""
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
