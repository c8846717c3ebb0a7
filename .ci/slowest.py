#!/usr/bin/env python3
"""Prints the ten slowest tests of a JUnit report; exit code 1 if one takes longer than the bound (seconds)."""
import sys
import xml.etree.ElementTree as xml

report, bound = sys.argv[1], float(sys.argv[2])
tests = sorted(
    ((float(case.get("time")), f"{suite.get('name')} {case.get('name')}")
     for suite in xml.parse(report).getroot().iter("testsuite") for case in suite.iter("testcase")),
    reverse=True,
)
print(f"{len(tests)} tests; the slowest, in seconds:")
for seconds, name in tests[:10]:
    print(f"  {seconds:6.1f}  {name}")
if tests and tests[0][0] > bound:
    print(f"{tests[0][1]} takes more than {bound:.0f} s: could a smaller case show the same?", file=sys.stderr)
    sys.exit(1)
