"""Tests of programs that people use fvv in, in environments of their own (./run test rerun, ./run test blender).

Writes the results into docs/evidence/tests.md, and figures into build/bench.json."""

import argparse
import json
import os
import re
import shutil
import statistics
import subprocess
import sys

from dependencies import BUILD, ROOT, markdown, runners, uv, write

WORK = ROOT / "build/hosts"
TESTS = "bindings/python/tests/hosts"
LIMIT = 900  # seconds
RESULTS = ROOT / "build/bench.json"
#: By host the environments of its tests: a title, and what they install.
HOSTS = {
    "rerun": {"rerun": "rerun-sdk"},
    # Both for Python 3.11, that of Blender 4.2 to 5.0.
    "blender": {"oldest": "bpy==4.2.0", "newest": "bpy"},
}
FIGURE = r"^[.F]*(blender\.\w+) ([\d.]+)$"


def environment(host, title, package):
    """A virtual environment with the package; its Python, and the versions in it."""
    folder = WORK / host / title
    uv("venv", "--quiet", "--clear", "--python", sys.executable, folder)
    python = folder / "bin/python"
    # Blender has an FFmpeg of its own.
    needed = [one for one in runners() if host != "blender" or not one.startswith("av=")]
    wheels = ("--only-binary", ":all:")
    uv("pip", "install", "--quiet", "--python", python, *wheels, package, "numpy", *needed)
    listed = json.loads(uv("pip", "list", "--python", python, "--format", "json"))
    return python, {one["name"]: one["version"] for one in listed}


def tried(host, python, pictures):
    """The output of the tests of a host, and whether all passed."""
    package = BUILD / "bindings/python"
    settings = os.environ | {
        "FVV_TOOLS_DIR": str(BUILD / "tools"),
        "FVV_PACKAGE": str(package / "fvv"),
        "FVV_PICTURES": str(pictures),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    if host != "blender":  # which installs the package by itself
        settings["PYTHONPATH"] = str(package)
    pictures.mkdir(parents=True, exist_ok=True)
    done = subprocess.run(
        [python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-s", f"{TESTS}/test_{host}.py"],
        cwd=ROOT, env=settings, capture_output=True, text=True, timeout=LIMIT,
    )  # fmt: skip
    print(done.stdout + done.stderr)
    found = re.search(r"^(\d+ (?:passed|failed)[^\n]*?)(?:, \d+ warnings?)? in [\d.]+s", done.stdout, re.M)
    if not found:
        sys.exit(f"hosts: pytest ended with {done.returncode}")
    return done, found[1]


def figures_of(output):
    """Of figures that are printed more than once: the least quality, the middle time."""
    found = {}
    for name, value in re.findall(FIGURE, output, re.M):
        found.setdefault(name, []).append(float(value))
    return {
        name: min(values) if name.endswith("_db") else statistics.median(values)
        for name, values in found.items()
    }


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("host", choices=HOSTS)
    host = arguments.parse_args().host
    columns, code, figures = [], 0, {}
    for title, package in HOSTS[host].items():
        python, versions = environment(host, title, package)
        done, tests = tried(host, python, WORK / host / "pictures" / title)
        code = code or done.returncode
        figures = figures_of(done.stdout)
        name = re.match(r"[\w-]+", package)[0]
        speed = re.findall(r"(\d[\d.]*) frames per second", done.stdout)
        column = {f"`{name}`": versions[name], "numpy": versions["numpy"], "tests": tests}
        if speed:
            column["frames per second, meshes of 35,000 triangles alone"] = speed[-1]
        columns.append(column | {f"`{one}`": f"{value:.2f}" for one, value in sorted(figures.items())})
        if host == "blender":  # half a gigabyte
            shutil.rmtree(python.parent.parent)
    rows = [(one, [column.get(one, "not measured") for column in columns]) for one in columns[-1]]
    write(markdown(f"with Python {sys.version.split()[0]}", list(HOSTS[host]), rows), part=host)
    if figures:
        known = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
        RESULTS.write_text(json.dumps(known | figures, indent=2, sort_keys=True) + "\n")
    return code


if __name__ == "__main__":
    sys.exit(main())
