"""The packages of js with the oldest and the newest version of what they expect of a project (peerDependencies), for ./run test dependencies.

Each end is a copy of js in build/dependencies, with the packages of js/node_modules but for those of the ranges, which npm installs beside it.
`--end oldest|newest` runs one end.
"""

import argparse
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from dependencies import markdown, write

ROOT = pathlib.Path(__file__).resolve().parent.parent
JS = ROOT / "js"
WORK = ROOT / "build/dependencies/npm"
ENDS = ("oldest", "newest")
LIMIT = 900  # seconds for a file of tests
#: What uses these packages: pictures of three.js, types and pages of React, samples of the READMEs.
TESTS = {
    "js/three": ["test/three.test.mjs"],
    "js/packing": ["test/packages.test.mjs", "test/samples.test.mjs"],
}
#: Packages that fit the same version of another only: React compares.
BESIDE = {"three": ("@types/three",), "react": ("react-dom",), "@types/react": ("@types/react-dom",)}


def ranges():
    """{name: range} of all packages of js."""
    found = {}
    for manifest in sorted(JS.glob("*/package.json")):
        found.update(json.loads(manifest.read_text()).get("peerDependencies", {}))
    return found


def wanted(end):
    """Arguments of npm install."""
    packages = []
    for name, needed in ranges().items():
        least = re.fullmatch(r">=(\d+)(?:\.(\d+))?(?:\.(\d+))?", needed)
        if not least:
            sys.exit(f"dependencies: {name}: expected a range of the form >=N, found {needed}")
        first = ".".join(part or "0" for part in least.groups())
        # Types are versioned by themselves after the first two numbers.
        types = "~" + ".".join(first.split(".")[:2])
        for one in (name, *BESIDE.get(name, ())):
            oldest = types if one != name and one.startswith("@types/") else first
            packages.append(f"{one}@{oldest if end == 'oldest' else 'latest'}")
    return packages


def install(end):
    """A copy of the repository's js with this end of all ranges. Returns its root, and the versions by name."""
    root = WORK / end
    shutil.rmtree(root, ignore_errors=True)
    shutil.copytree(JS, root / "js", symlinks=True, ignore=shutil.ignore_patterns("node_modules"))
    for entry in ROOT.iterdir():
        if entry.name not in ("js", "build", ".git"):
            (root / entry.name).symlink_to(entry)
    # The copy has no build of its own, and is inside of the one that it uses.
    (root / "build").mkdir()
    (root / "build/default").symlink_to(ROOT / "build/default")
    exchanged = root / "exchanged"
    exchanged.mkdir()
    (exchanged / "package.json").write_text('{"private": true}')
    done = subprocess.run(
        ["npm", "install", "--no-audit", "--no-fund", "--loglevel=error", "--legacy-peer-deps", *wanted(end)],
        cwd=exchanged, capture_output=True, text=True, timeout=600,
    )  # fmt: skip
    if done.returncode:
        sys.exit(f"dependencies: npm install failed: {done.stderr[-2000:]}")
    modules = root / "js/node_modules"
    link(JS / "node_modules", modules)
    replace(modules / ".bin", JS / "node_modules/.bin")
    link(exchanged / "node_modules", modules)
    for workspace in json.loads((JS / "package.json").read_text())["workspaces"]:
        replace(modules / "@fvv" / workspace, root / "js" / workspace)
    names = [name for one in ranges() for name in (one, *BESIDE.get(one, ()))]
    manifests = {name: json.loads((modules / name / "package.json").read_text()) for name in names}
    return root, {name: manifest["version"] for name, manifest in manifests.items()}


def link(source, target):
    """Links the packages of a node_modules into another, over what is there."""
    for entry in source.iterdir():
        if entry.name.startswith("@"):
            link(entry, target / entry.name)
        elif not entry.name.startswith("."):
            replace(target / entry.name, entry)


def replace(place, target):
    place.parent.mkdir(parents=True, exist_ok=True)
    place.unlink(missing_ok=True)
    place.symlink_to(target)


def tried(root):
    """(tests passed, failed with their names) of one end."""
    passed, failed = 0, []
    settings = os.environ | {"FVV_BUILD": str(ROOT / "build/default")}
    for folder, files in TESTS.items():
        for file in files:
            done = subprocess.run(
                ["node", "--test", "--test-reporter=tap", file],
                cwd=root / folder, capture_output=True, text=True, timeout=LIMIT, env=settings,
            )  # fmt: skip
            (root / f"{pathlib.Path(file).stem}.log").write_text(done.stdout + done.stderr)
            passed += sum(map(int, re.findall(r"^# pass (\d+)$", done.stdout, re.M)))
            names = re.findall(r"^ *not ok \d+ - (.*)$", done.stdout, re.M)
            failed += [f"{file}: {name}" for name in names if "# SKIP" not in name]
            if done.returncode and not names:
                failed.append(f"{file} ended with {done.returncode}: {done.stderr[-500:]}")
    return passed, failed


def table(found):
    """The results as Markdown."""
    rows = [
        (f"`{name} {needed}`", [versions[name] for versions, _ in found.values()])
        for name, needed in ranges().items()
    ]
    counts = [f"{passed} passed, {len(failed)} failed" for _, (passed, failed) in found.values()]
    return markdown("by npm", found, [*rows, ("tests", counts)])


def main():
    arguments = argparse.ArgumentParser(description=__doc__)
    arguments.add_argument("--end", choices=ENDS, action="append")
    given = arguments.parse_args()
    found = {}
    for end in given.end or ENDS:
        root, versions = install(end)
        print(f"dependencies: npm, {end}: testing", flush=True)
        found[end] = (versions, tried(root))
        for name in found[end][1][1]:
            print(f"dependencies: npm, {end}: failed: {name}", flush=True)
    print(table(found))
    if len(found) == len(ENDS):
        write(table(found), "npm dependencies")
    return 1 if any(failed for _, (_, failed) in found.values()) else 0


if __name__ == "__main__":
    sys.exit(main())
