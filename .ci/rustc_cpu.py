#!/usr/bin/env python3
"""Measures the compile time of our crates against that of the crates from Cargo.lock, in the same build.

CPU seconds alone differ by a third between machines, and with what else a machine does. The crates of Cargo.lock are
the same everywhere and are compiled side by side with ours, so the ratio of the two tells what our code costs.

As RUSTC_WRAPPER: runs rustc and appends "CPU-SECONDS own|other CRATE" to the file $RUSTC_CPU_LOG.
With `--sum LOG RATIO`: prints both sums and the ten largest units; exit code 1 when ours take more than RATIO times
what the others take.
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
        # cargo names the sources of the workspace's members relative to its root, all others by a full path
        source = next((argument for argument in command if argument.endswith(".rs")), "/")
        whose = "other" if os.path.isabs(source) else "own"
        with open(os.environ["RUSTC_CPU_LOG"], "a") as log:
            log.write(f"{used.ru_utime + used.ru_stime:.2f} {whose} {name}{kind}\n")
    return code


def total(path, bound):
    units = []
    if os.path.exists(path):
        with open(path) as log:
            units = [line.rstrip("\n").split(" ", 2) for line in log]
    units = sorted(((float(cpu), whose, name) for cpu, whose, name in units), reverse=True)
    own, other = (sum(cpu for cpu, whose, _ in units if whose == side) for side in ("own", "other"))
    for cpu, whose, name in units[:10]:
        print(f"  {cpu:6.1f}  {name}{'' if whose == 'own' else ', not ours'}")
    if other == 0:
        print("nothing of Cargo.lock was compiled, so there is nothing to measure by")
        return 0
    print(f"{len(units)} units, ours {own:.0f} CPU s, the others {other:.0f}: {own / other:.2f}, {bound:.2f} allowed")
    if own > bound * other:
        print("above the bound: what of ours is new?", file=sys.stderr)
        return 1
    return 0


if sys.argv[1] == "--sum":
    sys.exit(total(sys.argv[2], float(sys.argv[3])))
sys.exit(wrap(sys.argv[1:]))
