#!/usr/bin/env python3
"""Fills the book's pages: manuals, examples, what the tool says and draws, pictures of the pins.

mdBook runs it with the book as JSON on standard input. `preprocess.py --check` fills every page by itself
and fails where something cannot be filled or a link leads nowhere. PASAPAS names the tool.

    {{#manual FILE}}           a manual, or with `{{#manual FILE # Heading}}` a section of it
    {{#file FILE}}             a file of the repository
    {{#run ARGUMENTS}}         `pasapas ARGUMENTS` and what it says
    {{#wrong ARGUMENTS}}       the same where the exit code is 1: the input is wrong
    {{#plot ARGUMENTS}}        the picture that `pasapas sim ARGUMENTS --plot` draws
    {{#pins CHIP COLUMN}}      the pins of MSP430G2553 or MSP430F5529 as that column of the firmware's table names them
    {{#chain}}                 the shift registers and their wires to both
"""
import base64
import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

from pins import chain, header, headers, registers

BOOK = pathlib.Path(__file__).resolve().parent
ROOT = BOOK.parents[1]
SOURCE = BOOK / "src"
SCRIPTS = SOURCE / "scripts"
DIRECTIVE = re.compile(r"^\{\{#(\w+) ?(.*?)\}\}$", re.M)
LINK = re.compile(r"(\[[^\]\n]*\])\(([^)\s]+)\)")
LANGUAGES = {"bas": "basic", "rhai": "rhai", "toml": "toml"}


def pasapas(arguments, code=0):
    """What the tool says; the exit code must be this one."""
    tool, words = os.environ.get("PASAPAS", "pasapas"), shlex.split(arguments)
    # The book's own scripts are told by their bare names, as a reader has them.
    folder = SCRIPTS if any((SCRIPTS / word).is_file() for word in words) else ROOT
    told = subprocess.run([tool, *words], cwd=folder, capture_output=True, text=True, timeout=120)
    if told.returncode != code:
        raise ValueError(f"pasapas {arguments}: exit code {told.returncode}\n{told.stdout}{told.stderr}")
    return told.stdout + told.stderr


def fenced(language, text):
    return f"```{language}\n{text.rstrip()}\n```"


def section(text, heading):
    """The part of a page below a heading, up to the next one that is as high."""
    lines, found, level, code = text.splitlines(), [], 0, False
    for line in lines:
        code ^= line.startswith("```")
        mark = re.match(r"(#+) (.*)", line) if not code else None
        if not level:
            level = len(mark[1]) if mark and mark[2] == heading else 0
        elif mark and len(mark[1]) <= level:
            break
        else:
            found.append(line)
    if not level:
        raise ValueError(f"there is no heading {heading}")
    return "\n".join(found).strip()


def plot(arguments):
    with tempfile.TemporaryDirectory() as folder:
        picture = pathlib.Path(folder) / "plot.svg"
        pasapas(f"sim {arguments} --plot {shlex.quote(str(picture))}")
        return image(picture.read_bytes(), f"What pasapas sim {arguments} draws")


def image(svg, words):
    return f'<img alt="{words}" src="data:image/svg+xml;base64,{base64.b64encode(svg).decode()}">'


def pin_table(chip):
    """The table of a chip's pins in the firmware's manual."""
    return section((ROOT / "firmware/README.md").read_text(), chip).split("\n#")[0]


class Book:
    """The pages by their paths below src, filled."""

    def __init__(self, pages):
        self.pages = pages
        self.manuals = {}
        for path, text in pages.items():
            whole = re.search(r"^\{\{#manual ([^#}]+?)\}\}$", text, re.M)
            if whole:
                self.manuals[whole[1]] = path

    def fill(self, path):
        def one(match):
            kind, what = match[1], match[2].strip()
            try:
                if kind == "manual":
                    file, _, heading = what.partition(" # ")
                    text = (ROOT / file).read_text()
                    return self.own_links(section(text, heading) if heading else text, file, path)
                if kind == "file":
                    return fenced(LANGUAGES.get(what.rsplit(".")[-1], "text"), (ROOT / what).read_text())
                if kind == "run":
                    return fenced("text", f"$ pasapas {what}\n{pasapas(what)}")
                if kind == "wrong":
                    return fenced("text", f"$ pasapas {what}\n{pasapas(what, 1)}")
                if kind == "plot":
                    return plot(what)
                if kind == "pins":
                    chip, column = what.split()
                    draw = header if chip == "MSP430G2553" else headers
                    return image(draw(pin_table(chip), column).encode(), f"Pins of the {chip}, {column} wiring")
                if kind == "chain":
                    tables = {chip: pin_table(chip) for chip in ("MSP430G2553", "MSP430F5529")}
                    return image(registers().encode(), "The shift registers of the chain") + "\n\n" + chain(tables)
            except (OSError, ValueError) as error:
                raise SystemExit(f"{path}: {match[0]}: {error}") from error
            raise SystemExit(f"{path}: {match[0]}: no such directive")
        return DIRECTIVE.sub(one, self.pages[path])

    def own_links(self, text, file, path):
        """Links of a manual lead to the page of the book that holds the other one, or become its name."""
        def one(match):
            name, (target, _, anchor) = match[1], match[2].partition("#")
            if ":" in target:
                return match[0]
            place = os.path.relpath((ROOT / file).parent / target, ROOT) if target else file
            page = self.manuals.get(place)
            if page:
                return f"{name}({page if page != path else ''}{'#' + anchor if anchor else ''})"
            return f"{name[1:-1]} (`{place}`)"
        return outside_code(text, lambda part: LINK.sub(one, part))


def outside_code(text, change):
    """Changes what is not in a fence."""
    parts = re.split(r"(^```.*?^```)", text, flags=re.M | re.S)
    return "".join(part if part.startswith("```") else change(part) for part in parts)


def anchors(text):
    plain = outside_code(text, lambda part: part)
    names = [re.sub(r"[`*]|\[|\]\([^)]*\)|\]", "", line.lstrip("#").strip()) for line in plain.splitlines()
             if re.match(r"#+ ", line)]
    return {re.sub(r"[^\w\- ]", "", name.lower()).strip().replace(" ", "-") for name in names}


def check():
    pages = {file.relative_to(SOURCE).as_posix(): file.read_text() for file in SOURCE.rglob("*.md")}
    summary = pages.pop("SUMMARY.md")
    listed = re.findall(r"\]\(([^)]+)\)", summary)
    if sorted(listed) != sorted(pages):
        sys.exit(f"SUMMARY.md lists {sorted(set(listed) ^ set(pages))} wrongly")
    book = Book(pages)
    filled = {path: book.fill(path) for path in pages}
    wrong, count = [], 0
    for path, text in filled.items():
        for target in (match[2] for part in re.split(r"^```.*?^```", text, flags=re.M | re.S)
                       for match in LINK.finditer(part)):
            count += 1
            page, _, anchor = target.partition("#")
            if ":" in target:
                continue
            there = filled.get(page or path)
            if there is None or anchor and anchor not in anchors(there):
                wrong.append(f"{path}: {target}")
    if wrong:
        sys.exit("these links lead nowhere:\n" + "\n".join(wrong))
    print(f"{len(filled)} pages, {count} links")


def main():
    if sys.argv[1:] == ["--check"]:
        check()
    elif sys.argv[1:2] == ["supports"]:
        sys.exit(sys.argv[2:] != ["html"])
    else:
        _, told = json.load(sys.stdin)
        chapters = [item["Chapter"] for item in told["items"] if "Chapter" in item]
        for chapter in chapters:
            chapters.extend(item["Chapter"] for item in chapter["sub_items"] if "Chapter" in item)
        book = Book({chapter["path"]: chapter["content"] for chapter in chapters if chapter["path"]})
        for chapter in chapters:
            if chapter["path"]:
                chapter["content"] = book.fill(chapter["path"])
        json.dump(told, sys.stdout)


main()
