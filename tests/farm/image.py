"""The container image of examples/farm, made by its own Dockerfile without Docker, and a farm of it.

    PYTHONPATH=control/python .venv/bin/python tests/farm/image.py [--keep FOLDER]

buildah runs the steps in a chroot, so it needs root and no daemon, and its "debian:12" is made by mmdebstrap from Debian's archive; both are
Debian packages. Then the image's own entry point runs as the image's own user: two nodes and a door, and a rig alone. Not seen so: a container's
own network and limits, Docker and Kubernetes themselves. CAMRIG_BIN: the build that is packaged. A verdict a line; exit code 1 if one fails.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import camrig  # noqa: E402
from live_parts.bus import Bus, run, wait_until  # noqa: E402
from live_parts.verdicts import Verdicts  # noqa: E402
from ports import free_port  # noqa: E402

_REPOSITORY = Path(__file__).resolve().parents[2]
_TOKEN = "0123456789abcdef"
_CERTIFICATES = "/etc/ssl/certs/ca-certificates.crt"


class Image:
    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._buildah = ["buildah", "--root", str(folder / "store"), "--runroot", str(folder / "run"), "--storage-driver", "vfs"]
        self._containers: list[str] = []

    def buildah(self, *words: str) -> str:
        return subprocess.run([*self._buildah, *words], check=True, stdout=subprocess.PIPE, text=True, cwd=self._folder).stdout.strip()

    def make_base(self) -> None:
        """What an image calls debian:12. Its programs trust whom this machine trusts, or else nothing could be fetched behind a proxy."""
        base = self._folder / "base.tar"
        if not base.exists():
            subprocess.run(["mmdebstrap", "--quiet", "--variant=minbase", "--include=ca-certificates", "--aptopt=Acquire::Check-Valid-Until \"false\"", "bookworm", str(base)], check=True)
        container = self.buildah("from", "scratch")
        self.buildah("add", container, str(base), "/")
        self.buildah("copy", container, _CERTIFICATES, _CERTIFICATES)
        self.buildah("config", "--env", f"PIP_CERT={_CERTIFICATES}", container)
        self.buildah("commit", "--rm", container, "docker.io/library/debian:12")

    def make(self, packages: Path) -> None:
        self.buildah("bud", "--isolation", "chroot", "--pull-never", "-t", "camrig-farm", "-f", str(_REPOSITORY / "examples" / "farm" / "Dockerfile"), str(packages))

    def config(self) -> dict[str, Any]:
        return json.loads(self.buildah("inspect", "--type", "image", "camrig-farm"))["OCIv1"]["config"]

    def container(self) -> str:
        """One that shares a folder with this machine: `shared`."""
        self._containers.append(self.buildah("from", "--pull-never", "camrig-farm"))
        return self._containers[-1]

    def command(self, container: str, *words: str) -> list[str]:
        return [*self._buildah, "run", "--isolation", "chroot", "--volume", f"{self.shared}:/shared", container, "--", *words]

    @property
    def shared(self) -> Path:
        return self._folder / "shared"

    def end(self) -> None:
        for container in self._containers:
            self.buildah("rm", container)


def package(build: Path, to: Path) -> None:
    subprocess.run(["cmake", "--build", str(build), "--target", "wheel"], check=True, stdout=subprocess.DEVNULL)
    subprocess.run(["cpack", "-G", "DEB", "-B", str(to)], check=True, cwd=build, stdout=subprocess.DEVNULL)


def check(image: Image, folder: Path, verdicts: Verdicts) -> None:
    config = image.config()
    verdicts.check("image: it runs camrig farm, and not as root", config.get("Entrypoint") == ["camrig", "farm"] and config.get("User") == "camrig", config)
    one = image.container()
    ran = lambda *words: subprocess.run(image.command(one, *words), capture_output=True, text=True, timeout=120)  # noqa: E731
    verdicts.check("image: camrig runs in it as the user of the image", ran("id", "-u").stdout.strip() == "1000" and ran("camrig", "--version").returncode == 0)
    verdicts.check("image: camrig farm finds its Python packages", all(name in ran("camrig", "farm", "--help").stdout for name in ("node", "door", "record")))
    drivers = ran("sh", "-c", "ls /usr/lib/*/dri /usr/lib/*/libLLVM* 2>/dev/null").stdout.strip()
    verdicts.check("image: Mesa's drivers are not in it", drivers == "", drivers)
    told = ran("/opt/camrig/bin/python", "-c", "import camrig, ray, pyarrow, scipy; rig = camrig.start('minimal', mode='lockstep'); rig.step(seconds=0.1); "
               "print(rig.create_camera('eye', size=(160, 120), fps=10).frame().image.shape)")
    verdicts.check("image: camrig serve shows pictures in it", told.stdout.strip() == "(120, 160, 3)", told.stdout + told.stderr[-500:])
    plan = ran("camrig", "farm", "record", "--help")
    verdicts.check("image: camrig farm record is there for KubeRay", plan.returncode == 0 and ran("ray", "--version").returncode == 0, plan.stderr[-300:])
    _farm(image, folder, verdicts)


def _farm(image: Image, folder: Path, verdicts: Verdicts) -> None:
    (image.shared / "token").write_text(_TOKEN + "\n")
    entry = image.config()["Entrypoint"]
    bus, tcp = Bus(folder, 1), free_port()
    running: list[subprocess.Popen[Any]] = []
    try:
        for number in (1, 2):
            words = ["node", "--name", f"node{number}", "--nats", bus.urls, "--scene", "minimal", "--host", "127.0.0.1", "--token-file", "/shared/token", "--arg=--device=cpu"]
            running.append(run(image.command(image.container(), *entry, *words), folder / f"node{number}.log"))
        words = ["door", "--nats", bus.urls, "--control", "/tmp/farm.sock", "--tcp", f"127.0.0.1:{tcp}", "--token-file", "/shared/token"]
        running.append(run(image.command(image.container(), *entry, *words), folder / "door.log"))

        def nodes() -> list[dict[str, Any]]:
            try:
                return camrig.connect(host="127.0.0.1", port=tcp, token=_TOKEN).call("farm.status")["nodes"]
            except (camrig.CamrigError, OSError):
                return []

        wait_until(lambda: sum(not node["is_behind"] for node in nodes()) == 2, f"two nodes; see {folder}/*.log")
        rig = camrig.connect(host="127.0.0.1", port=tcp, token=_TOKEN)
        shapes = set()
        for number in range(6):
            camera = rig.create_camera(f"eye{number}", size=(160, 120), fps=5)
            shapes.add(camera.frame().image.shape)
        owners = {camera["node"] for camera in rig.call("farm.status")["cameras"]}
        verdicts.check("image: a farm of two nodes and a door of it shows cameras of both", shapes == {(120, 160, 3)} and owners == {"node1", "node2"}, (shapes, owners))
        hashes = {camrig.connect(host="127.0.0.1", port=node["tcp"], token=_TOKEN).call("rig.identity")["mathematics"] for node in nodes()}
        verdicts.check("image: its nodes are of one world", len(hashes) == 1, hashes)
    finally:
        for process in reversed(running):
            process.terminate()
        for process in running:
            try:
                process.wait(20)
            except subprocess.TimeoutExpired:
                process.kill()
        bus.end()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--keep", help="folder for the image, its base and logs")
    options = parser.parse_args()
    for program in ("buildah", "mmdebstrap", "nats-server"):
        if not shutil.which(program):
            sys.exit(f"no {program}: apt install {program}")
    verdicts = Verdicts()
    program = Path(os.environ["CAMRIG_BIN"]).resolve()
    build = next(folder for folder in program.parents if (folder / "CMakeCache.txt").exists())
    with tempfile.TemporaryDirectory(prefix="camrig-image-", ignore_cleanup_errors=True) as temporary:
        folder = Path(options.keep or temporary).resolve()
        image = Image(folder)
        image.shared.mkdir(parents=True, exist_ok=True)
        image.shared.chmod(0o755)
        package(build, folder / "packages")
        image.make_base()
        image.make(folder / "packages")
        try:
            check(image, folder, verdicts)
        finally:
            image.end()
    return 1 if verdicts.failed else 0


if __name__ == "__main__":
    sys.exit(main())
