# SPDX-License-Identifier: Apache-2.0
"""What a figure was taken on: processor, driver, compiler, commit, date, and whether other work used the machine."""
import datetime
import os
import pathlib
import re
import resource
import subprocess
import time

LOADED_CORES = 0.15  # a run counts as "loaded" when other work uses more cores than this; an idle Debian uses about 0.02


def output_of(command, folder=None):
    """The command's output in one line, or "" where it fails."""
    try:
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return ""


def processor():
    text = pathlib.Path("/proc/cpuinfo").read_text() if os.path.exists("/proc/cpuinfo") else ""
    name = re.search(r"model name\s*:\s*(.*)", text)
    wide = "AVX-512" if " avx512f" in text else "AVX2" if " avx2" in text else "SSE or less"
    return {"name": name.group(1) if name else "unknown", "cores": os.cpu_count(), "vectors": wide}


def driver():
    """The Vulkan driver. The device itself is named in each row by the bench."""
    nvidia = output_of(["nvidia-smi", "--query-gpu=driver_version", "--format=csv,noheader"])
    if nvidia:
        return f"NVIDIA {nvidia}"
    version = output_of(["dpkg-query", "-W", "-f", "${Version}", "mesa-vulkan-drivers"])
    return f"Mesa {version}" if version else "unknown"


def is_software(device):
    """Whether a Vulkan device of this name is a driver on the CPU."""
    return "llvmpipe" in device or "SwiftShader" in device


def configured(build, name):
    """A value of the build folder's CMake cache, or None."""
    cache = build / "CMakeCache.txt"
    found = re.search(rf"^{name}:\w+=(.*)$", cache.read_text(encoding="utf-8"), re.M) if cache.exists() else None
    return found.group(1) if found else None


def compiler(build):
    path = configured(build, "CMAKE_CXX_COMPILER")
    return output_of([path, "--version"]).splitlines()[0] if path else "unknown"


def describe(build):
    """The commit is that of the tree that the programs are built from."""
    tree = configured(build, "CMAKE_HOME_DIRECTORY")
    return {
        "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d"),
        "commit": output_of(["git", "rev-parse", "--short=10", "HEAD"], tree) or "unknown",
        "changed": bool(output_of(["git", "status", "--porcelain", "--", ".", ":!docs"], tree)),
        "compiler": compiler(build),
        "processor": processor(),
        "driver": driver(),
    }


def busy_seconds():
    """Seconds that all cores together were busy since the machine started."""
    with open("/proc/stat", encoding="ascii") as file:
        user, nice, system, _, _, irq, softirq, steal = (int(v) for v in file.readline().split()[1:9])
    return (user + nice + system + irq + softirq + steal) / os.sysconf("SC_CLK_TCK")


def own_seconds():
    return sum(sum(resource.getrusage(who)[:2]) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))


class OtherWork:
    """Measures how many cores other programs use, from here until stop(). Programs that this one started must have ended by then."""

    def __init__(self):
        self.start = time.monotonic(), busy_seconds(), own_seconds()

    def stop(self):
        began, busy, own = self.start
        seconds = max(time.monotonic() - began, 1e-3)
        cores = max(0.0, (busy_seconds() - busy - (own_seconds() - own)) / seconds)
        return {"seconds": round(seconds, 1), "other_work_cores": round(cores, 2), "loaded": cores > LOADED_CORES}
