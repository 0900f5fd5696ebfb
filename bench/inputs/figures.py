"""Mesh files of registries' packages, and self-made ones, through fvvmux and fvvdemux, against an independent reader.

Each file is equal, different or refused with its reason. A difference is silent where fvvmux ended with 0 and not with 3."""

import collections
import json
import os
import subprocess
import sys

import numpy as np
from PIL import Image

from . import compare, packages, reference, selfmade

LIMIT = 120  # seconds for a file
#: Of the largest side of what a file shows.
ERROR_PART = 1 / 4096
#: Of cameras, in pixels.
MOST_PX = 1e-4


def read_back(folder):
    """(corners, colours) of the OBJ file and the picture that fvvdemux wrote."""
    points, places, own = [], [], []
    corners, at = [], []
    (path,) = (folder / "meshes").glob("*.obj")
    for line in path.read_text().splitlines():
        words = line.split()
        if not words:
            continue
        if words[0] == "v":
            points.append([float(word) for word in words[1:4]])
            own.append([255 * float(word) for word in words[4:7]] if len(words) == 7 else [np.nan] * 3)
        elif words[0] == "vt":
            places.append([float(word) for word in words[1:3]])
        elif words[0] == "f":
            numbers = [word.split("/") for word in words[1:]]
            corners.append([int(one[0]) - 1 for one in numbers])
            at.append([int(one[1]) - 1 if len(one) > 1 and one[1] else -1 for one in numbers])
    corners = np.array(corners, int).reshape(-1, 3)
    picture = next((folder / "atlas").glob("*.png"), None) if (folder / "atlas").exists() else None
    if picture is None:
        colours = np.array(own, float).reshape(-1, 3)[corners].mean(1)
    else:
        with Image.open(picture) as opened:
            colours = reference.sampled(opened, np.array(places)[np.array(at)].mean(1))
    return np.array(points).reshape(-1, 3)[corners], colours


def through(build, path, work, extent):
    """(exit code of fvvmux, what it said, what fvvdemux wrote or None)."""
    stream, folder = work / "one.fvv", work / "one"
    length = extent * ERROR_PART
    command = [
        build / "tools/fvvmux/fvvmux",
        "--meshes",
        path.name,
        "--units",
        "metres",
        "-o",
        stream,
        "--force",
    ]
    command += [
        "--bake-repeats",
        "--keep-geometry",
        "--winding",
        "keep",
        "--step",
        f"{length:.9f}m",
        "--quality",
        "45dB",
    ]
    done = subprocess.run(
        [*map(str, command)], cwd=path.parent, capture_output=True, text=True, timeout=LIMIT
    )
    if done.returncode not in (0, 3):
        return done.returncode, done.stderr.strip(), None
    back = [build / "tools/fvvdemux/fvvdemux", stream, "-o", folder, "--meshes", "obj", "--force"]
    said = subprocess.run([*map(str, back)], capture_output=True, text=True, timeout=LIMIT)
    if said.returncode not in (0, 3):
        return said.returncode, f"fvvdemux: {said.stderr.strip()}", None
    return done.returncode, done.stderr.strip(), read_back(folder)


def judge(build, path, truth, work):
    """(equal, different, warned or refused; the reason)."""
    extent = np.ptp(truth[0].reshape(-1, 3), axis=0).max()
    try:
        code, said, found = through(build, path, work, extent)
    except subprocess.TimeoutExpired:
        return "refused", f"took more than {LIMIT} s"
    if found is None:
        return "refused", said.splitlines()[-1] if said else f"exit code {code}"
    text, pairs = compare.difference(truth, found, 1.5 * extent * ERROR_PART)
    text = text or compare.colour_difference(truth, found, pairs)
    if text is None:
        return "equal", ""
    if code == 3:
        return "warned", f"{text}; {said.splitlines()[0] if said else ''}"
    return "different", text


def candidates(folder):
    """(name of the group, path, what it holds or why it is not counted)."""
    found, missing = packages.fetch(folder / "packages")
    for package, reason in missing:
        print(f"not tried: {package}: {reason}")
    for package, place in found:
        for path in packages.files_of(place):
            try:
                yield package, path, reference.read(path), None
            except reference.NotUsable as error:
                yield package, path, None, str(error)
    for path, truth in selfmade.write(folder / "selfmade"):
        yield "self-made", path, truth, None


def measure(root, build, folder):
    """inputs.public_equal_percent, inputs.silently_wrong, inputs.files, inputs.calibration_formats."""
    folder.mkdir(parents=True, exist_ok=True)
    counts = collections.defaultdict(collections.Counter)
    for group, path, truth, reason in candidates(folder):
        result, said = ("not counted", reason) if truth is None else judge(build, path, truth, folder)
        counts[group][result] += 1
        if result != "equal":
            print(f"{result:12}{path.relative_to(folder)}: {said}", flush=True)
    ends = ("equal", "warned", "different", "refused", "not counted")
    print(f"\n{'files of':42}" + "".join(f"{end:>13}" for end in ends))
    for group, own in counts.items():
        print(f"{group:42}" + "".join(f"{own[end]:>13}" for end in ends))
    public = collections.Counter()
    for group, own in counts.items():
        if group != "self-made":
            public.update(own)
    tried = sum(public[end] for end in ends[:-1])
    (folder / "inputs.json").write_text(json.dumps(counts, indent=1))
    figures = {
        "inputs.public_files": tried,
        "inputs.public_refused": public["refused"],
        "inputs.selfmade_equal": counts["self-made"]["equal"],
        "inputs.selfmade_files": sum(counts["self-made"].values()),
        "inputs.silently_wrong": sum(own["different"] for own in counts.values()),
        "inputs.calibration_formats": calibration_formats(root, build),
    }
    return {"inputs.public_equal_percent": 100 * public["equal"] / tried} | figures if tried else figures


def calibration_formats(root, build):
    """How many of fvvimport's formats give cameras within MOST_PX of that format's own formula (tests/tools/import_formats.py)."""
    script = root / "tests/tools/import_formats.py"
    environment = os.environ | {"FVV_TOOLS_DIR": str(build / "tools")}
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, env=environment)
    if done.returncode:
        sys.exit(f"bench: inputs failed: {done.stderr.strip()}")
    errors = json.loads(done.stdout)["max_error_px_of_format"]
    formats = {name.partition("_")[0] for name in errors}
    return len(formats - {name.partition("_")[0] for name, error in errors.items() if error > MOST_PX})
