#!/usr/bin/env python3
"""Packs a built tool: an archive for a platform and, for Linux, a Debian package.

pack.py OUT --target TRIPLE --binary FILE --pages FOLDER [--book FOLDER]

FOLDER is what `cargo run --example pages` writes: man pages and completions; that of --book is the
rendered book, which becomes the folder `manual`. The README comes with the pages that it links to, at
the same places; a link to what a package does not hold becomes plain text. OUT gets
pasapas-VERSION-TRIPLE.tar.xz (.zip for Windows), and pasapas_VERSION_ARCH.deb. Needs cargo, and
dpkg-deb for the Debian package.
"""
import argparse
import gzip
import pathlib
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
import tomllib
import zipfile

ROOT = pathlib.Path(__file__).resolve().parents[2]
VERSION = tomllib.loads((ROOT / "Cargo.toml").read_text())["workspace"]["package"]["version"]
ARCHITECTURES = {"x86_64": "amd64", "aarch64": "arm64"}
# Times inside an archive: the same inputs give the same bytes.
TIME = 1577836800


# Pages for users: those that the README links to, and those that these link to.
PAGES = ["README.md", "lang/README.md", "firmware/README.md", "firmware/lower/README.md", "host/dist/README.md",
         "host/cell.md", "host/editors.md", "host/engrave.md", "host/gateway.md", "host/grbl.md", "host/level.md", "host/paste.md", "host/place.md", "host/profiles.md",
         "host/workbench.md", "host/worlds.md"]
LINK = re.compile(r"(!?)\[([^]\[]*)\]\(([^)\s]+)\)")


def page(path, held):
    """A page as bytes, without links to files that are not among those `held`."""
    folder = pathlib.PurePosixPath(path).parent

    def link(found):
        picture, words, target = found.groups()
        place = target.split("#")[0]
        if not place or re.match(r"[a-z]+:", place):
            return found[0]
        whole = []
        for part in (folder / place).parts:
            whole = whole[:-1] if part == ".." else whole + [part]
        return found[0] if "/".join(whole) in held else words

    return LINK.sub(link, (ROOT / path).read_text()).encode()


def archive_files(binary, pages, licences, book=None):
    """What an archive holds: path inside it, then the file or its bytes."""
    files = {binary.name: binary, "LICENCES.txt": licences, "70-pasapas.rules": ROOT / "host/dist/70-pasapas.rules"}
    files |= {name: ROOT / name for name in ("LICENSE-MIT", "LICENSE-APACHE", "host/workbench.webp")}
    files["CHANGELOG.md"] = ROOT / "CHANGELOG.md"
    folders = [("examples", ROOT / "examples"), ("man", pages / "man"), ("completions", pages / "completions")]
    for top, folder in folders + ([("manual", book)] if book else []):
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                files[f"{top}/{file.relative_to(folder).as_posix()}"] = file
    held = files.keys() | set(PAGES)
    return files | {path: page(path, held) for path in PAGES}


def content(file):
    return file if isinstance(file, bytes) else file.read_bytes()


def archive(out, name, files, binary):
    mode = lambda path: 0o755 if path == binary else 0o644
    if binary.endswith(".exe"):
        with zipfile.ZipFile(out / f"{name}.zip", "w", zipfile.ZIP_DEFLATED) as packed:
            for path, file in files.items():
                entry = zipfile.ZipInfo(f"{name}/{path}", (2020, 1, 1, 0, 0, 0))
                entry.external_attr, entry.compress_type = mode(path) << 16, zipfile.ZIP_DEFLATED
                packed.writestr(entry, content(file))
        return
    with tarfile.open(out / f"{name}.tar.xz", "w:xz") as packed:
        for path, file in files.items():
            with tempfile.TemporaryFile() as data:
                entry = tarfile.TarInfo(f"{name}/{path}")
                entry.size, entry.mode, entry.mtime = data.write(content(file)), mode(path), TIME
                data.seek(0)
                packed.addfile(entry, data)


def depends(binary):
    """The oldest C library that has all that the tool calls; a static one wants none."""
    told = subprocess.run(["objdump", "-T", binary], capture_output=True, text=True)
    versions = [tuple(map(int, version.split("."))) for version in re.findall(r"GLIBC_([0-9.]+)", told.stdout)]
    return f"Depends: libc6 (>= {'.'.join(map(str, max(versions)))})\n" if versions else ""


def debian(out, target, files, binary):
    architecture = ARCHITECTURES[target.split("-")[0]]
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder) / "root"

        def put(path, data, mode=0o644):
            place = root / path
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_bytes(data)
            place.chmod(mode)

        for path, file in files.items():
            name, data = path.split("/")[-1], content(file)
            if path == binary:
                put(f"usr/bin/{name}", data, 0o755)
            elif path.startswith("man/"):
                put(f"usr/share/man/man1/{name}.gz", gzip.compress(data, mtime=0))
            elif path.startswith("manual/"):
                put(f"usr/share/doc/pasapas/html/{path.removeprefix('manual/')}", data)
            elif path in PAGES or path.endswith(".webp"):
                put(f"usr/share/doc/pasapas/{path}", data)
            elif path.startswith("examples/"):
                put(f"usr/share/pasapas/{path}", data)
            elif path == "70-pasapas.rules":
                put(f"usr/lib/udev/rules.d/{name}", data)
            elif name == "CHANGELOG.md":
                put("usr/share/doc/pasapas/changelog.gz", gzip.compress(data, mtime=0))
            elif path == "LICENCES.txt":
                licences = [content(files[name]) for name in ("LICENSE-MIT", "LICENSE-APACHE")]
                put("usr/share/doc/pasapas/copyright", b"\n\n".join([data, *licences]))
            elif name == "pasapas.bash":
                put("usr/share/bash-completion/completions/pasapas", data)
            elif name == "_pasapas":
                put("usr/share/zsh/vendor-completions/_pasapas", data)
            elif name == "pasapas.fish":
                put("usr/share/fish/vendor_completions.d/pasapas.fish", data)
        # A umask of the one who packs must not decide who may read what.
        for place in [root, *root.rglob("*")]:
            if place.is_dir():
                place.chmod(0o755)
        size = sum(file.stat().st_size for file in root.rglob("*") if file.is_file()) // 1024
        put("DEBIAN/control", f"""Package: pasapas
Version: {VERSION}
Architecture: {architecture}
Maintainer: The Pasapas maintainers <maintainers@pasapas.invalid>
Installed-Size: {size}
{depends(files[binary])}Recommends: mspdebug
Section: electronics
Priority: optional
Description: small BASIC for machines that step
 Checks and simulates scripts for stepper machines, brings them to a TI MSP430
 that runs them alone, and watches and drives it by Modbus.
""".encode())
        subprocess.run(["dpkg-deb", "--root-owner-group", "-Zxz", "--build", root,
                        out / f"pasapas_{VERSION}_{architecture}.deb"], check=True, stdout=subprocess.DEVNULL)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--target", required=True)
    parser.add_argument("--binary", type=pathlib.Path, required=True)
    parser.add_argument("--pages", type=pathlib.Path, required=True)
    parser.add_argument("--book", type=pathlib.Path)
    options = parser.parse_args()
    licences = subprocess.run([sys.executable, ROOT / "host/dist/licences.py", options.target],
                              check=True, capture_output=True).stdout
    files = archive_files(options.binary, options.pages, licences, options.book)
    options.out.mkdir(parents=True, exist_ok=True)
    archive(options.out, f"pasapas-{VERSION}-{options.target}", files, options.binary.name)
    if "-linux-" in options.target and shutil.which("dpkg-deb"):
        debian(options.out, options.target, files, options.binary.name)


if __name__ == "__main__":
    main()
