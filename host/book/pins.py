"""Draws the pins of the chips and their LaunchPads from the tables of the firmware's manual."""
import re
from xml.sax.saxutils import escape

# Pins of the 20-pin package (SLAS735, "Device pinout"), counted around it.
PACKAGE = ["VCC", "P1.0", "P1.1", "P1.2", "P1.3", "P1.4", "P1.5", "P2.0", "P2.1", "P2.2",
           "P2.3", "P2.4", "P2.5", "P1.6", "P1.7", "RST", "TEST", "P2.7", "P2.6", "GND"]
FIXED = {"VCC": "3.3 V", "GND": "ground", "RST": "programmer, reset", "TEST": "programmer"}
COLOURS = [("kept", "#8b949e"), ("STEP", "#1f6feb"), ("DIR", "#0a8f5b"), ("UART", "#7a4fd0"), ("Stop", "#c0262d"), ("Start", "#0a8f5b"),
           ("output", "#b35900"), ("latch", "#b35900"), ("SPI", "#7a4fd0")]


def cells(table, column):
    """The first cell of each row, and that of the column."""
    rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines() if line.startswith("|")]
    columns = [re.sub(r"`| wiring| \(default\)", "", cell) for cell in rows[0]]
    if column not in columns[1:]:
        raise ValueError(f"the table has the columns {columns[1:]}")
    at = columns.index(column)
    # A picture has no links.
    rows = [[re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", cell) for cell in row] for row in rows]
    return [(row[0], row[1] if row[at] == "the same" else row[at]) for row in rows[2:]]


def functions(table, column):
    """What each pin does. A row names several pins at once: `STEP X, Y, Z` are STEP X, STEP Y, STEP Z."""
    found = {}
    for where, words in cells(table, column):
        pins = where.split(", ")
        parts = words.split(", ") if len(pins) > 1 else [words]
        if len(parts) != len(pins):
            raise ValueError(f"{where}: {len(pins)} pins, but `{words}`")
        first = parts[0].rsplit(" ", 1)[0]
        found |= {pin: part if n == 0 else f"{first} {part}" for n, (pin, part) in enumerate(zip(pins, parts))}
    return found


def colour_of(words):
    return next((colour for start, colour in COLOURS if start in words), "#46536b")


def header(table, column):
    """The chip from above, pin 1 at the top on the left."""
    found = FIXED | functions(table, column)
    missing = [pin for pin in PACKAGE if pin not in found]
    if missing:
        raise ValueError(f"the table does not name {missing}")
    lines = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 760 340" width="760" font-family="sans-serif" font-size="14">',
             '<rect width="760" height="340" fill="#fbfcfe"/>',
             '<rect x="310" y="20" width="140" height="300" rx="6" fill="#23272e"/>',
             '<path d="M368 20a12 12 0 0 0 24 0" fill="#fbfcfe"/>',
             '<text transform="rotate(90 380 170)" x="380" y="175" fill="#fff" text-anchor="middle">MSP430G2553</text>']
    for n, pin in enumerate(PACKAGE):
        left = n < 10
        y = 40 + 29 * (n if left else 19 - n)
        words = found[pin]
        colour = colour_of(words)
        x, edge, anchor = (290, 316, "end") if left else (470, 444, "start")
        lines.append(f'<rect x="{x if left else 450}" y="{y - 7}" width="20" height="14" fill="{colour}"/>')
        lines.append(f'<text x="{300 if left else 460}" y="{y + 4}" fill="#fff" font-size="10" text-anchor="middle">{n + 1}</text>')
        lines.append(f'<text x="{edge}" y="{y + 5}" fill="#fff" font-size="11" text-anchor="{"start" if left else "end"}">{pin}</text>')
        lines.append(f'<text x="{x - 8 if left else x + 8}" y="{y + 5}" fill="{colour}" text-anchor="{anchor}">{escape(words)}</text>')
    return "\n".join([*lines, "</svg>"])


# Supply at the headers of a LaunchPad with 40 pins (SLAU533, "BoosterPack pinout").
SUPPLY = {1: "3.3 V", 21: "5 V", 22: "ground", 20: "ground"}


def places(table, column):
    """What each pin of a LaunchPad's headers does: `P1.2, P1.3 (35, 36)` with `STEP X, Y` or one word for both."""
    found = dict(SUPPLY)
    for where, words in cells(table, column):
        pins, _, at = where.rstrip(")").partition(" (")
        pins, at = pins.split(", "), at.split(", ")
        if not words or not at[0]:
            continue
        parts = words.split(", ")
        first = parts[0].rsplit(" ", 1)[0]
        for n, (pin, place) in enumerate(zip(pins, at, strict=True)):
            each = words if len(parts) != len(pins) or len(pins) == 1 or " and " in words else parts[0] if n == 0 else f"{first} {parts[n]}"
            if place.isdigit():
                found[int(place)] = f"{pin} {each}"
    return found


def headers(table, column):
    """The four headers of a LaunchPad with 40 pins, from above, its USB at the top."""
    found = places(table, column)
    lines = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 980 340" width="980" font-family="sans-serif" font-size="13">',
             '<rect width="980" height="340" fill="#fbfcfe"/>',
             '<rect x="350" y="16" width="280" height="312" rx="6" fill="#23272e"/>',
             '<rect x="460" y="6" width="60" height="26" fill="#8b949e"/>',
             '<text x="490" y="24" fill="#fff" font-size="12" text-anchor="middle">USB</text>',
             '<text x="490" y="176" fill="#fff" text-anchor="middle">MSP-EXP430F5529LP</text>']
    for row in range(10):
        y = 40 + 29 * row
        for side, (outer, inner) in (("end", (1 + row, 21 + row)), ("start", (20 - row, 40 - row))):
            told = [(pin, found[pin]) for pin in (outer, inner) if pin in found]
            told = [words if len(told) == 1 else f"{pin}: {words}" for pin, words in told]
            for pin, x in ((outer, 360 if side == "end" else 596), (inner, 388 if side == "end" else 568)):
                words = found.get(pin)
                lines.append(f'<rect x="{x}" y="{y - 9}" width="24" height="18" fill="{colour_of(words) if words else "#555c66"}"/>')
                lines.append(f'<text x="{x + 12}" y="{y + 4}" fill="#fff" font-size="11" text-anchor="middle">{pin}</text>')
            x = 342 if side == "end" else 638
            words = " \u00b7 ".join(told)
            lines.append(f'<text x="{x}" y="{y + 4}" fill="{colour_of(words)}" text-anchor="{side}">{escape(words)}</text>')
    return "\n".join([*lines, "</svg>"])


# The shift registers' pins for each signal of the chain (data sheets 74HC165 and 74HC595): of every register, or of the
# one that is nearest to the controller.
REGISTERS = [("SPI clock", "clock (2), all", "shift clock (11), all"), ("SPI in", "Q7 (9), nearest", ""),
             ("SPI out", "", "DS (14), nearest"), ("latch", "load (1), all", "store clock (12), all"),
             ("output enable", "", "OE (13), all")]


def chain(tables):
    """The wires of the chain as a table: signal, pin of each board, pins of the registers."""
    boards = {name: (functions(table, "chain") if name == "MSP430G2553" else
                     {words.split(" ", 1)[0]: f"{words.split(' ', 1)[1]} ({at})"
                      for at, words in places(table, "chain").items() if words.startswith("P")})
              for name, table in tables.items()}
    rows = [["signal", *boards, "74HC165", "74HC595"], ["---"] * (len(boards) + 3)]
    for signal, one, other in REGISTERS:
        at = []
        for name, found in boards.items():
            pins = [pin + words[words.rfind(" ("):] * (" (" in words) for pin, words in found.items() if words.startswith(signal)]
            if len(pins) != 1:
                raise ValueError(f"{signal} of the {name}: {pins}")
            at += pins
        rows.append([signal, *at, one, other])
    return "\n".join(f"| {' | '.join(row)} |" for row in rows)


def registers():
    """The four registers in their row, with the contacts of each."""
    lines = ['<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 860 250" width="860" font-family="sans-serif" font-size="13">',
             '<rect width="860" height="250" fill="#fbfcfe"/>',
             '<rect x="20" y="40" width="120" height="170" rx="6" fill="#23272e"/>',
             '<text x="80" y="130" fill="#fff" text-anchor="middle">controller</text>']
    for y, name, first, data, colour in ((50, "74HC165", "inputs", ("Q7 9", "DS 10"), "#7a4fd0"),
                                         (150, "74HC595", "outputs", ("DS 14", "Q7S 9"), "#b35900")):
        for n, x in enumerate((330, 620)):
            lines.append(f'<rect x="{x}" y="{y}" width="170" height="60" rx="6" fill="{colour}"/>')
            lines.append(f'<text x="{x + 85}" y="{y + 25}" fill="#fff" text-anchor="middle">{name}</text>')
            lines.append(f'<text x="{x + 85}" y="{y + 45}" fill="#fff" text-anchor="middle">{first} {8 * n + 1} to {8 * n + 8}</text>')
            begin, end = (140, x) if n == 0 else (500, x)
            near, far = ("SPI in" if first == "inputs" else "SPI out", data[0]) if n == 0 else (data[1], data[0])
            lines.append(f'<path d="M{begin} {y + 30}H{end}" stroke="{colour}" stroke-width="2"/>')
            lines.append(f'<text x="{begin + 4}" y="{y + 24}" fill="{colour}">{near}</text>')
            lines.append(f'<text x="{end - 4}" y="{y + 24}" fill="{colour}" text-anchor="end">{far}</text>')
    lines.append('<text x="235" y="128" fill="#46536b" text-anchor="middle">clock and latch go to all,</text>')
    lines.append('<text x="235" y="143" fill="#46536b" text-anchor="middle">enable to the 74HC595</text>')
    return "\n".join([*lines, "</svg>"])
