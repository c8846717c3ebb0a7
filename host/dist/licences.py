#!/usr/bin/env python3
"""Writes the licences of all parts of the tool and of the firmware inside it to standard output.

licences.py TARGET

The list comes from the lock file through `cargo metadata`, the texts from the sources of the parts.
Fails where a part has no licence of the list in deny.toml: somebody must read that one first.
"""
import json
import pathlib
import re
import subprocess
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[2]
ALLOWED = set(tomllib.loads((ROOT / "deny.toml").read_text())["licenses"]["allow"])
# What the compiler adds by itself.
COMPILER = """The Rust standard library, (c) The Rust Project Contributors: MIT OR Apache-2.0.
In the static builds for Linux musl libc, (c) Rich Felker and others: MIT.
In the builds for Windows made with MinGW-w64 its runtime: public domain or ZPL-2.1."""


def metadata(target):
    told = subprocess.run(
        ["cargo", "metadata", "--locked", "--format-version", "1", "--features", "pasapas/gateway",
         "--filter-platform", target, "--filter-platform", "msp430-none-elf"],
        check=True, capture_output=True, text=True)
    return json.loads(told.stdout)


def parts(data):
    """What is linked into the tool or the firmware, not what only builds, expands macros or tests."""
    packages = {package["id"]: package for package in data["packages"]}
    nodes = {node["id"]: node for node in data["resolve"]["nodes"]}
    wait = [id for id, package in packages.items()
            if package["name"] in ("pasapas", "firmware") and id in data["workspace_members"]]
    seen = set()
    while wait:
        id = wait.pop()
        macros = any("proc-macro" in part["kind"] for part in packages[id]["targets"])
        if id in seen or macros:
            continue
        seen.add(id)
        wait += [dep["pkg"] for dep in nodes[id]["deps"] if any(kind["kind"] is None for kind in dep["dep_kinds"])]
    found = [packages[id] for id in seen if packages[id]["source"]]
    return sorted(found, key=lambda package: (package["name"], package["version"]))


def allowed(expression):
    plain = re.sub(r"[()]| WITH LLVM-exception", "", expression.replace("/", " OR "))
    return all(any(name.strip().removesuffix("+") in ALLOWED for name in every.split(" OR ")) for every in plain.split(" AND "))


def texts(package):
    folder = pathlib.Path(package["manifest_path"]).parent
    for file in sorted(folder.iterdir()):
        if file.is_file() and re.match(r"(?i)(licen[cs]e|copying|notice|copyright)", file.name):
            yield "\n".join(line.rstrip() for line in file.read_text(errors="replace").strip().splitlines())


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = parts(metadata(sys.argv[1]))
    wrong = [f"{part['name']}: {part['license']}" for part in found if not allowed(part["license"] or "")]
    if wrong:
        sys.exit("not in the list of licences: " + ", ".join(wrong))
    print("Pasapas is MIT OR Apache-2.0, see LICENSE-MIT and LICENSE-APACHE. It is made with these parts:\n")
    for part in found:
        place = f", source: {part['repository']}" if "MPL" in part["license"] and part["repository"] else ""
        print(f"{part['name']} {part['version']}: {part['license']}{place}")
    print(f"\n{COMPILER}")
    by_text = {}
    for part in found:
        for text in texts(part):
            by_text.setdefault(text, []).append(f"{part['name']} {part['version']}")
    for text, names in by_text.items():
        print(f"\n{'=' * 80}\n{', '.join(names)}\n\n{text}")


main()
