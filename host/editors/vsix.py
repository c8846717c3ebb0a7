#!/usr/bin/env python3
"""Packs host/editors/vscode into a VSIX: a zip with a manifest. No other tool is needed.

vsix.py OUT.vsix [--target linux-x64 --binary PATH]

With --binary the tool goes inside, for the platform that --target names (linux-x64, linux-arm64,
win32-x64, darwin-x64, darwin-arm64). The same inputs give the same bytes.
"""
import argparse
import json
import pathlib
import zipfile
from xml.sax.saxutils import escape, quoteattr

TYPES = {
    ".json": "application/json", ".js": "application/javascript", ".md": "text/markdown",
    ".txt": "text/plain", ".vsixmanifest": "text/xml", ".exe": "application/octet-stream",
}
# A zip's times begin here.
TIME = (1980, 1, 1, 0, 0, 0)


def manifest(package, target):
    platform = f" TargetPlatform={quoteattr(target)}" if target else ""
    return f"""<?xml version="1.0" encoding="utf-8"?>
<PackageManifest Version="2.0.0" xmlns="http://schemas.microsoft.com/developer/vsx-schema/2011">
  <Metadata>
    <Identity Language="en-US" Id={quoteattr(package["name"])} Version={quoteattr(package["version"])} Publisher={quoteattr(package["publisher"])}{platform}/>
    <DisplayName>{escape(package["displayName"])}</DisplayName>
    <Description xml:space="preserve">{escape(package["description"])}</Description>
    <Tags>pasapas,basic,stepper,cnc</Tags>
    <Categories>{escape(",".join(package["categories"]))}</Categories>
    <GalleryFlags>Public</GalleryFlags>
    <Properties>
      <Property Id="Microsoft.VisualStudio.Code.Engine" Value={quoteattr(package["engines"]["vscode"])}/>
      <Property Id="Microsoft.VisualStudio.Code.ExtensionKind" Value="workspace"/>
    </Properties>
    <License>extension/LICENSE.txt</License>
  </Metadata>
  <Installation><InstallationTarget Id="Microsoft.VisualStudio.Code"/></Installation>
  <Dependencies/>
  <Assets>
    <Asset Type="Microsoft.VisualStudio.Code.Manifest" Path="extension/package.json" Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.Details" Path="extension/README.md" Addressable="true"/>
    <Asset Type="Microsoft.VisualStudio.Services.Content.License" Path="extension/LICENSE.txt" Addressable="true"/>
  </Assets>
</PackageManifest>
"""


def content_types():
    rows = "".join(f'<Default Extension="{end}" ContentType="{kind}"/>' for end, kind in sorted(TYPES.items()))
    return ('<?xml version="1.0" encoding="utf-8"?>\n'
            f'<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">{rows}</Types>\n')


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out")
    parser.add_argument("--target")
    parser.add_argument("--binary")
    options = parser.parse_args()
    if bool(options.target) != bool(options.binary):
        parser.error("--target and --binary belong together")
    root = pathlib.Path(__file__).resolve().parent / "vscode"
    package = json.loads((root / "package.json").read_text())
    files = {"extension.vsixmanifest": manifest(package, options.target).encode(),
             "[Content_Types].xml": content_types().encode()}
    for file in sorted(root.rglob("*")):
        if file.is_file():
            files[f"extension/{file.relative_to(root).as_posix()}"] = file.read_bytes()
    top = root.parents[2]
    licences = [(top / name).read_text() for name in ("LICENSE-MIT", "LICENSE-APACHE")]
    files["extension/LICENSE.txt"] = "\n\n".join(licences).encode()
    tool = None
    if options.binary:
        tool = "extension/bin/pasapas" + (".exe" if options.target.startswith("win32") else "")
        files[tool] = pathlib.Path(options.binary).read_bytes()
    with zipfile.ZipFile(options.out, "w", zipfile.ZIP_DEFLATED) as packed:
        for name, data in files.items():
            entry = zipfile.ZipInfo(name, TIME)
            entry.external_attr = (0o755 if name == tool else 0o644) << 16
            entry.compress_type = zipfile.ZIP_DEFLATED
            packed.writestr(entry, data)


main()
