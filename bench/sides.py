"""Our program and its peers, each a process that answers commands with JSON lines."""
import json
import os
import platform
import shutil
import subprocess
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BUILD = ROOT / "target" / "bench"
ROBOTS = ROOT / "robots" / "example-robot-data" / "robots"


class Side:
    """A process that reads one command per line and answers each with one line."""

    def __init__(self, command, **environment):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self.process = subprocess.Popen(command, env={**os.environ, **environment}, **pipes)

    def __call__(self, *words):
        self.process.stdin.write(" ".join(str(w) for w in words) + "\n")
        self.process.stdin.flush()
        line = self.process.stdout.readline()
        if not line:
            raise RuntimeError(f"{self.process.args[0]} ended while it was asked {words}")
        answer = json.loads(line)
        if "error" in answer:
            raise RuntimeError(f"{self.process.args[0]}: {words}: {answer['error']}")
        return answer

    def close(self):
        self.process.stdin.close()
        self.process.wait()


def ours_command():
    """Builds our side and returns the command that starts it."""
    subprocess.run(["cargo", "build", "--release", "-p", "extricate-bench"], cwd=ROOT, check=True)
    return [str(ROOT / "target" / "release" / "extricate-bench"), "serve"]


def peer_commands():
    """Compiles the drivers of coal and fcl; reports and leaves out a peer that is not installed."""
    BUILD.mkdir(parents=True, exist_ok=True)
    flags = {"fcl": ["-lfcl", "-lccd"]}
    prefix = coal_prefix()
    if prefix:
        flags["coal"] = [f"-I{prefix}/include", f"-L{prefix}/lib", "-lcoal", f"-Wl,-rpath,{prefix}/lib"]
    found = {}
    for name, extra in flags.items():
        out = BUILD / f"pairs-{name}"
        command = ["g++", "-O3", "-std=c++17", "-w", f"-DPEER_{name.upper()}", str(ROOT / "bench" / "peer_pairs.cpp")]
        done = subprocess.run([*command, "-I/usr/include/eigen3", *extra, "-o", str(out)], capture_output=True, text=True) \
            if shutil.which("g++") else None
        if done is not None and done.returncode == 0:
            found[name] = [str(out)]
        else:
            first = (done.stderr.splitlines() or ["?"])[0] if done else "there is no g++"
            print(f"{name}: not installed ({first})")
    return found


def coal_prefix():
    """Returns the folder in which pip put coal's library and headers."""
    try:
        import coal
    except ImportError:
        return None
    return next((p for p in Path(coal.__file__).resolve().parents if p.name == "cmeel.prefix"), None)


def machine():
    """Describes the machine without its name: cores and the widest vector instructions."""
    try:
        flags = next(l for l in open("/proc/cpuinfo") if l.startswith(("flags", "Features"))).split()
    except (OSError, StopIteration):
        flags = []
    wide = next((name for flag, name in [("avx512f", "AVX-512 "), ("avx2", "AVX2 ")] if flag in flags), "")
    return f"{os.cpu_count()} cores, {wide}{platform.machine().replace('_', '-')}"


class others_during:
    """Measures the load of other programs while the block runs."""

    def __enter__(self):
        self.busy, self.began = busy_seconds(), time.perf_counter()
        return self

    def __exit__(self, *_):
        self.busy, self.wall = busy_seconds() - self.busy, time.perf_counter() - self.began

    def cores(self, ours):
        """Returns the mean load in cores; `ours` are the processor seconds of the block itself."""
        return max(0.0, (self.busy - ours) / self.wall)


def busy_seconds():
    """Returns the processor seconds that the machine has been busy so far."""
    user, nice, system = (int(word) for word in open("/proc/stat").readline().split()[1:4])
    return (user + nice + system) / 100
