#!/usr/bin/env python3
"""Reads what `pasapas bench --format json` prints, passes it on, and fails when a figure is missed.

    pasapas bench motion --format json | .ci/figures.py [KNOWN...]

KNOWN are figures that are known to be missed. One of them that is met fails too, so that the list stays true.
"""

import json
import sys

known = set(sys.argv[1:])
wrong = []
count = 0
for line in sys.stdin:
    print(line, end="")
    figure = json.loads(line)
    name, value, must = figure["figure"], figure["value"], figure["must"]
    met = value >= must if figure["want"] == ">=" else value <= must
    count += 1
    if met == (name in known):
        wrong.append(f"{name} is {value}, must be {figure['want']} {must}: {'met, but listed as missed' if met else 'missed'}")
if not count:
    wrong.append("no figure was printed")
for line in wrong:
    print(line, file=sys.stderr)
sys.exit(bool(wrong))
