"""A small virtual machine with a kernel of its own and this machine's files, read-only: runs one command as root and ends.

qemu emulates it (TCG), so it needs no KVM and no rights, and is 10 to 20 times slower than the machine.
"""

from __future__ import annotations

import pathlib
import shlex
import shutil
import subprocess
import tempfile
import threading
import time

from guest_kernel import GuestKernel

# What the guest needs before it has this machine's files, and what v4l2loopback needs.
_KERNEL_MODULES = ["virtio_pci", "9pnet_virtio", "9p", "videodev", "videobuf2_common"]
# no_timer_check: on a busy machine the emulated timer is late, and the kernel panics for want of it.
_KERNEL_OPTIONS = "console=ttyS0 quiet loglevel=3 panic=-1 oops=panic mitigations=off random.trust_cpu=on no_timer_check"
_RESULT = "vm-result:"

_INIT = """#!/bin/busybox sh
export PATH=/bin
/bin/busybox --install -s /bin
mkdir -p /proc /sys /dev /host
mount -t proc proc /proc
mount -t sysfs sys /sys
mount -t devtmpfs dev /dev
while read -r module; do insmod "/modules/$module" || echo "insmod $module failed"; done < /modules/order
mount -t 9p -o trans=virtio,version=9p2000.L,ro,cache=loose,msize=512000 hostroot /host || poweroff -f
mkdir /checkout
mount --bind "/host{checkout}" /checkout
mount -t tmpfs tmp /host/tmp
mount -t tmpfs run /host/run
mkdir -p "/host{checkout}"
mount --bind /checkout "/host{checkout}"
mkdir -p /host/tmp/modules
cp /loopback/*.ko /host/tmp/modules/
mount --move /proc /host/proc
mount --move /sys /host/sys
mount --move /dev /host/dev
mkdir -p /host/dev/shm /host/dev/pts
mount -t tmpfs shm /host/dev/shm
ip link set lo up
cp /command /host/tmp/command
chroot /host /bin/bash /tmp/command
echo "{result} $?"
poweroff -f
"""


# QEMU 7.2 emulates AVX2 gathers whose indices are in ymm4 as if they had none: what gathers reads the wrong memory.
CPU = "max,-avx2"


class Machine:
    def __init__(self, kernel: GuestKernel, checkout: pathlib.Path, cpus: int = 2, memory_mib: int = 3072):
        """`checkout` is visible in the guest wherever it lies; else its /tmp and /run are empty."""
        self._kernel = kernel
        self._checkout = checkout
        self._cpus = cpus
        self._memory_mib = memory_mib

    def run(self, command: list[str], environment: dict[str, str], timeout_s: float) -> int:
        """Boots, runs the command in this machine's files and gives its exit status; its output goes to ours."""
        with tempfile.TemporaryDirectory(prefix="camrig-vm-") as folder:
            image = self._initramfs(pathlib.Path(folder), command, environment)
            return self._boot(image, timeout_s)

    def _boot(self, image: pathlib.Path, timeout_s: float) -> int:
        started = time.monotonic()
        qemu = subprocess.Popen(
            ["qemu-system-x86_64", "-accel", "tcg,thread=multi", "-cpu", CPU, "-m", str(self._memory_mib),
             "-smp", str(self._cpus), "-nographic", "-no-reboot", "-nodefaults", "-serial", "stdio", "-net", "none",
             "-kernel", self._kernel.vmlinuz, "-initrd", image,
             "-append", _KERNEL_OPTIONS,
             "-device", "virtio-rng-pci",
             "-virtfs", "local,path=/,mount_tag=hostroot,security_model=none,readonly=on,multidevs=remap"],
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        status = None
        watchdog = threading.Timer(timeout_s, qemu.kill)
        watchdog.start()
        try:
            for raw in qemu.stdout:
                line = raw.decode(errors="replace").rstrip()
                if line.startswith(_RESULT):
                    status = int(line.split()[1])
                else:
                    print(line, flush=True)
            qemu.wait()
        finally:
            watchdog.cancel()
            qemu.kill()
            qemu.wait()
        if status is None:
            print(f"tests/vm: the machine ended after {time.monotonic() - started:.0f} s without a result "
                  f"(limit {timeout_s:.0f} s)")
            return 1
        return status

    def _initramfs(self, folder: pathlib.Path, command: list[str], environment: dict[str, str]) -> pathlib.Path:
        root = folder / "root"
        for name in ("bin", "modules", "loopback"):
            (root / name).mkdir(parents=True)
        shutil.copy("/bin/busybox", root / "bin" / "busybox")
        init = root / "init"
        init.write_text(_INIT.replace("{result}", _RESULT).replace("{checkout}", str(self._checkout)))
        init.chmod(0o755)
        exports = "".join(f"export {name}={shlex.quote(value)}\n" for name, value in environment.items())
        (root / "command").write_text(f"{exports}exec {shlex.join(command)}\n")
        (root / "modules" / "order").write_text("".join(f"{file.name}\n" for file in self._module_files(root / "modules")))
        for version, file in self._kernel.modules.values():
            shutil.copy(file, root / "loopback" / f"v4l2loopback-{version}.ko")
        image = folder / "initramfs"
        with image.open("wb") as out:
            files = subprocess.run(["find", "."], cwd=root, capture_output=True, check=True).stdout
            subprocess.run(["cpio", "-o", "-H", "newc", "--quiet"], cwd=root, input=files, stdout=out, check=True)
        return image

    def _module_files(self, target: pathlib.Path) -> list[pathlib.Path]:
        """Copies the modules, each after those that it needs."""
        ordered: dict[str, pathlib.Path] = {}
        for name in _KERNEL_MODULES:
            shown = subprocess.run(["modprobe", "-d", self._kernel.module_tree, "-S", self._kernel.version, "--show-depends", name],
                                   capture_output=True, text=True, check=True).stdout
            for line in shown.splitlines():
                if line.startswith("insmod "):
                    file = pathlib.Path(line.split()[1])
                    ordered.setdefault(file.name, file)
        for file in ordered.values():
            shutil.copy(file, target / file.name)
        return list(ordered.values())
