"""Installs what the benchmarks need: the peers in a virtual environment, and the robots."""
import hashlib
import os
import subprocess
import sys
import venv

from sides import ROBOTS, ROOT

ENVIRONMENT = ROOT / "target" / "peers"
REQUIREMENTS = ROOT / "bench" / "requirements.txt"
# Numerical libraries must not start threads of their own: every side gets one core.
ONE_THREAD = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")


def enter_environment():
    """Restarts in the virtual environment, which is made again if it is missing or the requirements have changed."""
    python = ENVIRONMENT / "bin" / "python"
    if sys.prefix == str(ENVIRONMENT) and all(os.environ.get(name) == "1" for name in ONE_THREAD):
        return
    stamp, wanted = ENVIRONMENT / "installed", hashlib.sha256(REQUIREMENTS.read_bytes()).hexdigest()
    if not stamp.exists() or stamp.read_text() != wanted:
        print(f"installing the peers into {ENVIRONMENT}", flush=True)
        if not python.exists():
            venv.create(ENVIRONMENT, with_pip=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "--requirement", REQUIREMENTS], check=True)
        stamp.write_text(wanted)
    os.environ |= dict.fromkeys(ONE_THREAD, "1")
    os.execv(python, [str(python), *sys.argv])


def fetch_robots():
    if not all((ROBOTS / name).is_dir() for name in ("panda_description", "ur_description", "allegro_hand_description")):
        subprocess.run([sys.executable, ROOT / "scripts" / "fetch-robots.py"], check=True)

