"""Tests of programs that people use fvv in, each in an environment of its own with the newest version (./run test rerun).

Writes the result into docs/evidence/tests.md."""

import argparse
import json
import os
import re
import subprocess
import sys

from dependencies import BUILD, ROOT, markdown, runners, uv, write

WORK = ROOT / "build/hosts"
TESTS = "bindings/python/tests/hosts"
LIMIT = 900  # seconds
#: The package of each.
HOSTS = {"rerun": "rerun-sdk"}


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("host", choices=HOSTS)
    host = arguments.parse_args().host
    folder = WORK / host
    uv("venv", "--quiet", "--clear", "--python", sys.executable, folder)
    python = folder / "bin/python"
    needed = [one for one in runners() if not one.startswith("av=")]
    uv(
        "pip",
        "install",
        "--quiet",
        "--python",
        python,
        "--only-binary",
        ":all:",
        HOSTS[host],
        "numpy",
        *needed,
    )
    listed = json.loads(uv("pip", "list", "--python", python, "--format", "json"))
    versions = {one["name"]: one["version"] for one in listed}
    settings = os.environ | {
        "PYTHONPATH": str(BUILD / "bindings/python"),
        "FVV_TOOLS_DIR": str(BUILD / "tools"),
    }
    done = subprocess.run(
        [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-s", f"{TESTS}/test_{host}.py"],
        cwd=ROOT, env=settings, capture_output=True, text=True, timeout=LIMIT,
    )  # fmt: skip
    print(done.stdout + done.stderr)
    found = re.search(r"^(\d+ (?:passed|failed)[^\n]*?) in [\d.]+s", done.stdout, re.M)
    if not found:
        sys.exit(f"hosts: pytest ended with {done.returncode}")
    speed = re.findall(r"(\d[\d.]*) frames per second", done.stdout)
    rows = [
        (f"`{HOSTS[host]}`", [versions[HOSTS[host]]]),
        ("numpy", [versions["numpy"]]),
        ("tests", [found[1]]),
        ("frames per second, meshes of 35,000 triangles alone", speed[-1:] or ["not measured"]),
    ]
    write(markdown(f"with Python {sys.version.split()[0]}", [host], rows), part=host)
    return done.returncode


if __name__ == "__main__":
    sys.exit(main())
