"""Figures of the house: its size, what is public, how often an option is typed, and how long its tests take."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import time

SUFFIXES = {".c", ".h", ".cpp", ".js", ".mjs", ".ts", ".py", ".sh"}
# A typical option of fvvmux: how many sources name it shows how many places a new option touches.
OPTION = re.compile(r"max[-_]error")


def tracked(root):
    return subprocess.run(
        ["git", "ls-files"], cwd=root, capture_output=True, text=True, check=True
    ).stdout.splitlines()


def sizes(root):
    """Sources that are not generated, the median of their lines, all files, and words of the README."""
    files = tracked(root)
    lines = sorted(
        len((root / f).read_text().splitlines())
        for f in files
        if pathlib.Path(f).suffix in SUFFIXES and (root / f).is_file()
    )
    return {
        "house.sources": len(lines),
        "house.median_lines": lines[len(lines) // 2],
        "house.files": len(files),
        "house.readme_words": len((root / "README.md").read_text().split()),
    }


def option_places(root):
    """Sources of libraries, tools and bindings that name the option; tests, docs and benchmarks do not count."""
    folders = ("libfvv/", "tools/", "bindings/python/")
    found = [
        f
        for f in tracked(root)
        if f.startswith(folders)
        and "/tests/" not in f
        and pathlib.Path(f).suffix in SUFFIXES | {".pyi"}
        and (root / f).is_file()
        and OPTION.search((root / f).read_text())
    ]
    return {"house.option_places": len(found)}


def installed_headers(build):
    """C++ headers that cmake --install writes: those of include/ beside the folder fvv, which are C."""
    with tempfile.TemporaryDirectory() as folder:
        command = ["cmake", "--install", str(build), "--prefix", folder, "--component", "dev"]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"bench: cmake --install failed: {done.stderr.strip()}")
        headers = [p.relative_to(folder).parts for p in pathlib.Path(folder).rglob("*.h")]
    assert headers, "no header was installed"
    return {"house.installed_headers": sum("fvv" not in parts[:-1] for parts in headers)}


def times(root):
    """Seconds of ./run test quick now, after a run that builds; minutes of the last ./run test, if one wrote its stages."""
    command = [root / "run", "--no-install", "test", "quick"]
    for _ in range(2):
        begin = time.perf_counter()
        done = subprocess.run(command, cwd=root, capture_output=True, text=True)
        if done.returncode != 0:
            sys.exit(f"bench: ./run test quick failed: {done.stdout.strip()}")
        seconds = time.perf_counter() - begin
    found = {"house.quick_seconds": seconds}
    stages = root / "build/test-stages.json"
    if stages.exists():
        found["house.test_minutes"] = sum(json.loads(stages.read_text()).values()) / 60
    else:
        print("house.test_minutes is left out: ./run test has not passed in this checkout")
    return found


def measure(root, build):
    return {**sizes(root), **option_places(root), **installed_headers(build), **times(root)}
