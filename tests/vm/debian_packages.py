"""Fetches Debian packages of any suite and unpacks them into a folder, without installing them and without touching the machine's apt."""

from __future__ import annotations

import pathlib
import re
import subprocess

_NO_EXTRAS = ["-o", "Acquire::Languages=none", "-o", "Acquire::IndexTargets::deb::DEP-11::DefaultEnabled=false",
              "-o", "Acquire::IndexTargets::deb::Contents-deb::DefaultEnabled=false"]


def machine_source() -> tuple[str, str]:
    """(URI, key ring) of the Debian source that this machine itself uses."""
    for path in sorted(pathlib.Path("/etc/apt/sources.list.d").glob("*.sources")):
        for stanza in re.split(r"\n\s*\n", path.read_text()):
            fields = dict(re.findall(r"^([A-Za-z-]+):[ \t]*(.*)$", stanza, re.MULTILINE))
            uri = fields.get("URIs", "").split(" ")[0]
            if uri.rstrip("/").endswith("/debian"):
                return uri, fields.get("Signed-By", "")
    for path in [pathlib.Path("/etc/apt/sources.list"), *sorted(pathlib.Path("/etc/apt/sources.list.d").glob("*.list"))]:
        match = path.exists() and re.search(r"^deb (?:\[.*signed-by=(\S+).*\] )?(\S+/debian/?) ", path.read_text(), re.MULTILINE)
        if match:
            return match[2], match[1] or ""
    raise SystemExit("tests/vm: this machine has no Debian source in /etc/apt (looked for a URI that ends with /debian)")


class Suite:
    """One suite of Debian with an apt of its own below `folder`."""

    def __init__(self, name: str, folder: pathlib.Path):
        self.folder = folder / name
        (self.folder / "lists" / "partial").mkdir(parents=True, exist_ok=True)
        (self.folder / "archives" / "partial").mkdir(parents=True, exist_ok=True)
        uri, key = machine_source()
        sources = self.folder / "one.list"
        sources.write_text(f"deb [signed-by={key}] {uri} {name} main\n" if key else f"deb {uri} {name} main\n")
        self._options = ["-o", f"Dir::Etc::sourcelist={sources}", "-o", "Dir::Etc::sourceparts=-",
                         "-o", f"Dir::State::Lists={self.folder}/lists", "-o", f"Dir::Cache={self.folder}",
                         "-o", "APT::Sandbox::User=root", *_NO_EXTRAS]
        self._run("apt-get", "-q", "update")

    def _run(self, program: str, *arguments: str) -> str:
        done = subprocess.run([program, *self._options, *arguments], cwd=self.folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise SystemExit(f"tests/vm: {program} {' '.join(arguments)}: {done.stderr.strip()[-800:]}")
        return done.stdout

    def dependencies(self, package: str) -> list[str]:
        return re.findall(r"^\s*Depends: ([^<\s]+)", self._run("apt-cache", "depends", package), re.MULTILINE)

    def unpack(self, packages: list[str], target: pathlib.Path) -> None:
        self._run("apt-get", "-q", "download", *packages)
        for package in packages:
            (file,) = self.folder.glob(f"{package.split(':')[0]}_*.deb")
            subprocess.run(["dpkg", "-x", file, target], check=True)
            file.unlink()
