"""What all experiments share: running tools, generated captures, packed streams, and results as JSON.

Captures, streams and views are kept in build/charts and used again; they are made again when the tool that made them has
changed. Results of an experiment are one JSON file in docs/evidence/charts/results with the machine, versions, command and date of their
measurement.
"""

import datetime
import functools
import hashlib
import json
import os
import pathlib
import platform
import shutil
import subprocess
import sys
import tempfile
import time
from typing import Callable, NamedTuple

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
TOOLS = pathlib.Path(os.environ.get("FVV_TOOLS_DIR", ROOT / "build/default/tools")).resolve()
WORK = ROOT / "build/charts"
PAGES = ROOT / "docs/evidence/charts"
DATA = pathlib.Path(os.environ.get("FVV_DATA", ROOT.parent / "shared/data"))
LIBRARIES = (
    "libdraco4",
    "libmeshoptimizer2d",
    "libavcodec59",
    "libx264-164",
    "libx265-199",
    "libvpx7",
    "libsvtav1enc1",
)
# For modules of bench and of tests/real.
sys.path[:0] = [str(ROOT / "bench"), str(ROOT / "tests/real")]


class Default(NamedTuple):
    """A row of the table of defaults."""

    option: str  # "fvvmux --quality", or what has no option
    value: object
    verdict: str  # what the chart says about it
    justified: bool = True  # by a rule of the chart, with its figures


class Experiment(NamedTuple):
    """One measurement with its charts. A module of this folder lists its experiments in EXPERIMENTS."""

    name: str  # of its results, docs/evidence/charts/results/NAME.json, and of ./run charts NAME
    title: str  # heading in docs/evidence/charts/README.md
    # measure(quick) returns results for JSON; with quick only what the headlines need, or None.
    measure: Callable
    draw: Callable  # draw(results, folder) writes NAME.svg, or several NAME-x.svg
    # text(results) returns Markdown; its first sentence is bold and says what the chart means. Every figure is of the results.
    text: Callable
    # headlines(results of measure(True)) returns {figure: value}: bytes, errors and ratios, of which less is better.
    headlines: Callable = lambda results: {}
    # defaults(results) returns fields of Default: [(tool and option, default, what the chart says about it, whether that justifies it)].
    defaults: Callable = lambda results: []


class Failed(Exception):
    """A tool that ended with another exit code than 0 or 3; refused: it printed a reason."""

    def __init__(self, command, code, reason):
        super().__init__(f"{command[0]} returned {code}: {reason}")
        self.code, self.reason = code, reason


class Done(NamedTuple):
    output: str
    messages: str
    code: int
    seconds: float  # of processor time: other load on the machine changes it least
    wall: float
    peak_mib: float


def program(name):
    return (TOOLS.parent / "bench" if name in ("fvvbench", "fvvcodecs") else TOOLS / name) / name


def run(name, *arguments):
    """Runs a tool of ours, with its processor time and peak memory."""
    command = [str(program(name)), *map(str, arguments)]
    begin = time.perf_counter()
    with tempfile.TemporaryFile("w+") as out, tempfile.TemporaryFile("w+") as messages:
        child = subprocess.Popen(command, stdout=out, stderr=messages)
        _, status, usage = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - begin
        out.seek(0)
        messages.seek(0)
        text = messages.read()
        if child.returncode not in (0, 3):
            raise Failed([name, *map(str, arguments)], child.returncode, text.strip())
        seconds = usage.ru_utime + usage.ru_stime
        return Done(out.read(), text, child.returncode, seconds, wall, usage.ru_maxrss / 1024)


def answer(name, *arguments):
    """What a tool prints with --json."""
    return json.loads(run(name, *arguments, "--json").output)


@functools.lru_cache(None)
def digest_of(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()[:16]


def short(*what):
    return hashlib.sha256(json.dumps([str(w) for w in what]).encode()).hexdigest()[:12]


def capture(name, *options):
    """The folder of a capture of fvvsynth, made unless it is there."""
    folder = WORK / "captures" / f"{name}-{short(digest_of(program('fvvsynth')), *options)}"
    if not (folder / "capture.json").exists():
        folder.parent.mkdir(parents=True, exist_ok=True)
        run("fvvsynth", "-o", folder, "--force", *options)
    return folder


class Packed(NamedTuple):
    path: pathlib.Path
    summary: dict
    code: int
    messages: str
    seconds: float
    peak_mib: float


def packed(source, *options):
    """A stream of fvvmux with its summary, made unless the same program made it of the same capture before.

    Without --view-loss among the options nothing is chosen by views: charts change one setting at a time.
    """
    if "--view-loss" not in options:
        options = (*options, "--view-loss", "none")
    key = short(
        digest_of(program("fvvmux")), source, digest_of(pathlib.Path(source) / "capture.json"), *options
    )
    path = WORK / "streams" / f"{pathlib.Path(source).name.rsplit('-', 1)[0]}-{key}.fvv"
    kept = path.with_suffix(".json")
    if not kept.exists():
        path.parent.mkdir(parents=True, exist_ok=True)
        done = run("fvvmux", source, "-o", path, "--force", "--json", *options)
        kept.write_text(
            json.dumps([json.loads(done.output), done.code, done.messages, done.seconds, done.peak_mib])
        )
    return Packed(path, *json.loads(kept.read_text()))


def kept(kind, key, make):
    """What make() returns, which JSON can hold; kept in build/charts under key, a list of everything that it depends on."""
    path = WORK / kind / f"{short(*key)}.json"
    if not path.exists():
        made = make()
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(made))
    return json.loads(path.read_text())


def left_out(what, why):
    print(f"charts: left out: {what}: {why}", file=sys.stderr, flush=True)


def changed_capture(source, name, change):
    """A copy of a capture in which change(description, folder) edits capture.json and may write files beside it.

    Files that the description names are those of the source, by absolute paths.
    """
    folder = WORK / "captures" / f"{pathlib.Path(source).name}-{name}"
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    description = json.loads((pathlib.Path(source) / "capture.json").read_text())
    description["meshes"]["pattern"] = str(source / description["meshes"]["pattern"])
    for camera in description["cameras"]:
        for what in ("pictures", "masks"):
            camera[what] = str(source / camera[what])
    change(description, folder)
    (folder / "capture.json").write_text(json.dumps(description, sort_keys=True))
    return folder


def video_bytes(summary):
    """Bytes of the video tracks with cameras' pictures; a single track is no list."""
    video = summary.get("video") or []
    return sum(v["bytes"] for v in (video if isinstance(video, list) else [video]))


def parts(summary):
    """Bytes a frame of a stream by what they are for."""
    frames = summary["frames"]
    total = {
        "meshes": summary["mesh"]["bytes"],
        "pictures": video_bytes(summary),
        "visibility": summary["visibility"].get("bytes", 0),
        "colours": summary["colours"].get("bytes", 0),
    }
    total["rest"] = summary["bytes"] - sum(total.values())
    return {f"{name}_bytes": size / frames for name, size in {**total, "all": summary["bytes"]}.items()}


def processor():
    try:
        lines = pathlib.Path("/proc/cpuinfo").read_text().splitlines()
        return next(line.split(":")[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()


def package(name):
    """The version of a Debian package, or None."""
    if not shutil.which("dpkg-query"):
        return None
    done = subprocess.run(["dpkg-query", "-W", "-f", "${Version}", name], capture_output=True, text=True)
    return done.stdout if done.returncode == 0 and done.stdout else None


def versions():
    found = {"fvv": run("fvvmux", "--version").output.split()[-1], "python": platform.python_version()}
    git = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True)
    if git.returncode == 0:
        found["commit"] = git.stdout.strip()
    return found | {name: version for name in LIBRARIES if (version := package(name))}


def machine():
    memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "memory_gib": round(memory),
        "load": round(os.getloadavg()[0], 1),
    }


def rounded(value):
    """Five digits: enough for every chart, and small files."""
    if isinstance(value, dict):
        return {name: rounded(v) for name, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [rounded(v) for v in value]
    return float(f"{value:.5g}") if isinstance(value, float) else value


def results_file(name):
    return PAGES / "results" / f"{name}.json"


def load(name):
    """The last results of an experiment, or None."""
    path = results_file(name)
    return json.loads(path.read_text()) if path.exists() else None


def store(name, results, seconds):
    """Writes the results of an experiment; returns what load() returns."""
    record = {
        "experiment": name,
        "command": f"./run charts {name}",
        "date": datetime.date.today().isoformat(),
        "seconds": round(seconds),
        "machine": machine(),
        "versions": versions(),
        "results": rounded(results),
    }
    results_file(name).parent.mkdir(parents=True, exist_ok=True)
    results_file(name).write_text(json.dumps(record, indent=1) + "\n")
    return json.loads(results_file(name).read_text())
