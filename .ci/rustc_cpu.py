#!/usr/bin/env python3
"""Measures compile time in CPU seconds, which neighbours on the machine do not change.

As RUSTC_WRAPPER: runs rustc and appends "CPU-SECONDS CRATE" to the file $RUSTC_CPU_LOG.
With `--sum LOG BOUND`: prints the sum and the ten largest units; exit code 1 above the bound.
"""
import os
import resource
import subprocess
import sys


def wrap(command):
    code = subprocess.call(command, close_fds=False)  # cargo hands down its job server
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    if "--crate-name" in command:
        name = command[command.index("--crate-name") + 1]
        kind = " (tests)" if "--test" in command else ""
        with open(os.environ["RUSTC_CPU_LOG"], "a") as log:
            log.write(f"{used.ru_utime + used.ru_stime:.2f} {name}{kind}\n")
    return code


def total(path, bound):
    units = []
    if os.path.exists(path):
        with open(path) as log:
            units = [line.rstrip("\n").split(" ", 1) for line in log]
    units = sorted(((float(cpu), name) for cpu, name in units), reverse=True)
    spent = sum(cpu for cpu, _ in units)
    print(f"{len(units)} units, {spent:.0f} CPU s of {bound} allowed")
    for cpu, name in units[:10]:
        print(f"  {cpu:6.1f}  {name}")
    if spent > bound:
        print("above the bound: what of it is new?", file=sys.stderr)
        return 1
    return 0


if sys.argv[1] == "--sum":
    sys.exit(total(sys.argv[2], float(sys.argv[3])))
sys.exit(wrap(sys.argv[1:]))
