#!/usr/bin/env python3
"""Builds the page that needs no tool: compiler, simulator and player as WebAssembly, with the examples.

build.py OUT

OUT becomes a folder for any static web server: `python3 -m http.server -d OUT`. The page is the workbench's
without what needs a board; its files are taken from there. Needs a compiler with the target
wasm32-unknown-unknown (`rustup target add`), or, with RUSTC=/usr/bin/rustc CARGO=/usr/bin/cargo, Debian's
rustc-web, cargo-web, rust-web-src and lld-22.
"""
import gzip
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
BENCH = ROOT / "host/src/workbench/page"
SHARED = ["assist.js", "blocks.js", "document.js", "dom.js", "drag.js", "editor.js", "insert.js", "language.js", "lexer.js", "path.js", "pulses.js",
          "strokes.js", "style.css", "tabs.js", "timeline.js", "trial.js", "values.js"]
# Programs of other systems that are shown beside the scripts.
FOREIGN = ["import/contour.nc", "import/dil14.isel", "import/drill.drl", "import/plate.pal"]
# What a visitor waits for, as servers send it, bytes.
MOST = 2_000_000
TARGET = "wasm32-unknown-unknown"


def build():
    """The module."""
    environment = os.environ | {"CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS": "-Clink-arg=-zstack-size=8388608"}
    command = [os.environ.get("CARGO", "cargo"), "build", "--quiet", "--locked", "--profile", "web", "-p", "web",
               "--target", TARGET]
    if os.environ.get("RUSTC"):
        command.append("-Zbuild-std=std,panic_abort")
        environment |= {"RUSTC_BOOTSTRAP": "1", "CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER": "wasm-ld-22"}
    target = ROOT / "target/web"
    subprocess.run([*command, "--target-dir", target], cwd=ROOT, env=environment, check=True)
    return (target / TARGET / "web/web.wasm").read_bytes()


def page():
    """The workbench's page without board, helm and password, with addresses beside it."""
    text = (BENCH / "index.html").read_text()
    cuts = [r'\s*<section id="(run|machine|pattern)".*?</section>(?=\n)', r'\s*<button role="tab" data-tab="(run|machine|pattern)".*?</button>\n',
            r'\s*<button id="(quit|helm|stop)".*?</button>(?=\n)', r'\s*<span class="status">.*?</span></span>(?=\n)',
            r'\s*<p id="(split|conflict)".*?</p>(?=\n)']
    for cut, count in zip(cuts, (3, 3, 3, 1, 2)):
        text, found = re.subn(cut, "", text, flags=re.S)
        if found != count:
            sys.exit(f"the workbench's page has {found} of {cut}, not {count}")
    return text.replace('"/style.css"', '"style.css"').replace('"/app.js"', '"site.js"')


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    out = pathlib.Path(sys.argv[1])
    module = build()
    shutil.rmtree(out, ignore_errors=True)
    (out / "examples/import").mkdir(parents=True)
    (out / "pasapas.wasm").write_bytes(module)
    (out / "index.html").write_text(page())
    for name in SHARED:
        shutil.copy(BENCH / name, out)
    for file in (ROOT / "host/web/page").iterdir():
        shutil.copy(file, out)
    scripts = sorted(file.name for file in (ROOT / "examples").glob("*.bas")) + FOREIGN
    worlds = [world for world in (str(pathlib.Path(name).with_suffix(".rhai")) for name in scripts)
              if (ROOT / "examples" / world).is_file()]
    for name in scripts + worlds:
        shutil.copy(ROOT / "examples" / name, out / "examples" / name)
    (out / "examples.js").write_text(
        f"export const examples = {json.dumps(scripts)};\nexport const worlds = {json.dumps(worlds)};\n")
    size = sum(len(gzip.compress(file.read_bytes(), mtime=0)) for file in out.iterdir() if file.is_file())
    print(f"the page has {size} bytes, compressed as servers send it; the module has {len(module)}")
    if size > MOST:
        sys.exit(f"that is more than {MOST}")


main()
