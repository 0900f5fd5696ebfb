"""Time of the browser's decoder in Node, and its compressed size (./run bench js). As a program it prints the stages of a
file of Draco meshes: browser_decoder.py FILE."""

import json
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
DECODER = ROOT / "js/decoder"


def run(*command, **options):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, **options)
    if done.returncode != 0:
        sys.exit(f"bench: {command[0]} failed ({done.returncode}): {done.stderr.strip()}")
    return done.stdout


def node(what, path):
    return json.loads(run("node", ROOT / "bench/decoder.mjs", what, path))


PROCESSES = 9
STAGES = {
    "check": "check of the bitstream",
    "draco": "Draco",
    "copies": "copies between the two instances",
    "core": "in the core: header, rules of the mesh, metres",
    "arrays": "arrays for the caller",
}


def first_call(path, what="first"):
    """Medians of new processes."""
    runs = [node(what, path) for _ in range(PROCESSES)]
    return {name: statistics.median(run[name] for run in runs) for name in runs[0]}


def print_stages(path):
    """What loading, the first key frame of a process and later ones consist of: medians of new processes."""
    runs = [node("stages", path) for _ in range(PROCESSES)]

    def median(what, name):
        return statistics.median(run[what][name] for run in runs)

    print(f"{'load, ms':<48}{'unpack':>9}{'compile':>9}{'instance':>9}{'warm-up':>9}")
    for what, module in ("core", "core"), ("codec", "Draco"):
        parts = [median(what, name) for name in ("unpack", "compile", "instantiate", "warm_up")]
        print(f"{module:<48}" + "".join(f"{part:9.1f}" for part in parts))
    print(f"{'key frame, ms':<48}{'first':>9}{'fresh':>9}{'later':>9}")
    for name, text in {**STAGES, "all": "all"}.items():
        print(f"{text:<48}" + "".join(f"{median(what, name):9.2f}" for what in ("first", "fresh", "key")))
    print(
        "first: in a new process; fresh: with optimised code in a new instance, whose memory is new; later: median"
    )


def measure(draco, fast, delta):
    """Milliseconds a frame, without normals. first_call: of the first mesh in a fresh process, the median of several for
    the worst of three profiles, in which the thread waits for a core for first_call_waiting; loading the modules is a
    figure of its own."""
    if not shutil.which("emcmake") or not shutil.which("node"):
        print("js.* and wasm.* are left out: no emcmake or no node here")
        return {}
    sizes = run(DECODER / "wasm/build.sh", ROOT / "build/wasm").splitlines()
    core = next(line for line in sizes if "core.wasm.js" in line)
    first = [first_call(path) for path in (draco, fast, delta)]
    print_stages(draco)
    figures = {
        "js.core_brotli_bytes": int(core.split("brotli ")[1].split(";")[0]),
        "wasm.first_call_ms": max(f["first_ms"] for f in first),
        "wasm.first_call_waiting_ms": max(first, key=lambda f: f["first_ms"])["first_waiting_ms"],
        "wasm.load_and_first_ms": max(f["load_and_first_ms"] for f in first),
        "wasm.key_ms": node("warm", draco)["key_ms"],
        "wasm.fast_key_ms": node("warm", fast)["key_ms"],
        "wasm.delta_ms": node("warm", delta)["delta_ms"],
    }
    if not (ROOT / "js/node_modules/draco3d").exists():
        print("wasm.draco3d_ms is left out: no js/node_modules here: npm ci in js")
    else:
        both = node("beside", draco)
        figures["wasm.key_ms"] = both["key_ms"]
        figures["wasm.draco3d_ms"] = both["draco3d_ms"]
        figures["wasm.key_per_draco3d"] = both["ratio"]
        figures["wasm.draco3d_first_call_ms"] = first_call(draco, "draco3d")["first_ms"]
    return figures


def first_frames(h264, jpeg):
    """The first frame of the clip over 8 Mbit/s and 40 ms (first_frame.mjs): milliseconds to mesh and encoded picture in
    Node, and to the decoded picture in Chromium."""
    figures = {}
    for name, path in (("first_frame", h264), ("first_frame_jpeg", jpeg)):
        found = json.loads(run("node", ROOT / "bench/network/first_frame.mjs", path))
        figures[f"net.{name}_requests"] = found["requests"]
        figures[f"net.{name}_bytes"] = round(1000 * found["kilobytes"])
        figures[f"net.{name}_encoded_ms"] = found["ms"]
        if "picture_ms" in found:
            figures[f"net.{name}_ms"] = found["picture_ms"]
    return figures


def views(streams):
    """Bytes, requests and time of viewpoints over 8 Mbit/s and 40 ms (view.mjs). streams: by --video-tracks. Figures are those
    of the default share, in percent of the bytes and of the time with all tracks, and requests per second of
    playback."""
    if not shutil.which("node") or not (DECODER / "dist/core.wasm.js").exists():
        print("view.* is left out: no node, or js/decoder was not built (./run bench js)")
        return {}
    figures = {}
    print(f"{'tracks':>8}{'share':>7}{'selected':>10}{'bytes':>10}{'requests':>10}{'first, ms':>10}{'all, ms':>10}"
          f"{'requests of a second loop':>27}")  # fmt: skip
    for name, path in streams.items():
        found = json.loads(run("node", ROOT / "bench/view.mjs", path))
        whole = found["all"]
        for row in [{**whole, "share": "all"}, *found["views"]]:
            print(f"{name:>8}{row['share']:>7}{row['tracks']:10.1f}{row['bytes']:10.0f}{row['requests']:10.0f}"
                  f"{row['firstMs']:10.0f}{row['ms']:10.0f}{row['requestsAgain']:27.0f}")  # fmt: skip
            if row["share"] == 0.95:
                figures[f"view.{name}_time_percent"] = 100 * row["ms"] / whole["ms"]
                figures[f"view.{name}_bytes_percent"] = 100 * row["bytes"] / whole["bytes"]
                figures[f"view.{name}_requests_per_s"] = row["requests"] / found["seconds"]
    return figures


def look(path):
    """What viewers who move are sent of a stream with a track for each camera (look.mjs): cameras of a frame and bytes as means
    of both, and frames on screen with the wrong cameras."""
    if not shutil.which("node") or not (DECODER / "dist/core.wasm.js").exists():
        print("look.* is left out: no node, or js/decoder was not built (./run bench js)")
        return {}
    rows = json.loads(run("node", ROOT / "bench/network/look.mjs", path))
    print(
        f"{'viewer':>8}{'cameras':>9}{'bytes':>11}{'of all':>8}{'requests a second':>19}{'again':>7}{'wrong':>7}"
    )
    for name, row in rows.items():
        print(f"{name:>8}{row['cameras']:9.2f}{row['bytes']:11}{row['bytesOverAll']:8.3f}{row['requestsPerSecond']:19.1f}"
              f"{row['refetched']:7}{row['wrong']:7}")  # fmt: skip
    moving = [row for name, row in rows.items() if name != "all"]
    return {
        "look.cameras_mean": sum(row["cameras"] for row in moving) / len(moving),
        "look.bytes_over_all": sum(row["bytesOverAll"] for row in moving) / len(moving),
        "look.requests_per_s": sum(row["requestsPerSecond"] for row in moving) / len(moving),
        "look.wrong_frames": sum(row["wrong"] for row in moving),
    }


def packages():
    """What publint and attw find in the packages of npm, and the player with its decoder as one file, compressed."""
    if not shutil.which("npm") or not (DECODER / "dist/core.wasm.js").exists():
        print("npm.* is left out: no npm, or js/decoder was not built (./run bench js)")
        return {}
    found = json.loads(run("node", ROOT / "js/packing/packages.mjs"))
    return {"npm.problems": found["problems"], "player.one_file_brotli_bytes": found["oneFileBytes"]}


if __name__ == "__main__":
    print_stages(sys.argv[1])


def chaos(minutes):
    """Films, then a live stream, over a network that fails at random, for some minutes of simulated time each."""
    program = DECODER / "test/chaos/simulate.mjs"
    done = subprocess.run(["node", program, "--minutes", str(minutes)], capture_output=True, text=True)
    if done.returncode not in (0, 1) or not done.stdout:
        sys.exit(f"bench: chaos failed ({done.returncode}): {done.stderr.strip()}")
    parts = json.loads(done.stdout)
    for name, part in parts.items():
        print(f"{name}: {json.dumps(part)}")
    return {
        "chaos.hangs": sum(part["hangs"] for part in parts.values()),
        "chaos.wrong_frames": sum(part["wrong"] for part in parts.values()),
        "chaos.positions_lost": sum(part["lost"] for part in parts.values()),
        "chaos.errors": sum(len(part["errors"]) for part in parts.values()),
        "chaos.late_recoveries": sum(len(part["late"]) for part in parts.values()),
        "chaos.recovery_p95_s": parts["film"]["p95"],
        "chaos.live_recovery_p95_s": parts["live"]["p95"],
        "chaos.return_p95_s": parts["film"]["returnP95"],
        "chaos.live_return_p95_s": parts["live"]["returnP95"],
        "chaos.frames": sum(part["frames"] for part in parts.values()),
    }


def settle(orders):
    """Orders of replies and calls of js/decoder/test/settle.test.mjs, and the sources with which a promise did not settle."""
    environment = {**os.environ, "FVV_ORDERS": str(orders)}
    command = ["node", "--test", "test/settle.test.mjs"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=DECODER, env=environment)
    ends = re.findall(r"^(not ok|ok) \d+ - .*every promise settles$", done.stdout, re.M)
    failed = ends.count("not ok")
    if failed or not ends:
        print(done.stdout)
    return {"settle.orders": orders * len(ends), "settle.unsettled": failed}


def ladder(path):
    """A stream with a ladder over a link whose rate changes (network/ladder.mjs): each rung alone, what the decoder chooses,
    and an oracle. Quality is the logarithm of the bit rate relative to the lowest rung's."""
    if not shutil.which("node") or not (DECODER / "dist/core.wasm.js").exists():
        print("ladder.* is left out: no node, or js/decoder was not built (./run bench js)")
        return {}
    found = json.loads(run("node", ROOT / "bench/network/ladder.mjs", path))
    print(
        f"{'rung':>8}{'stalls':>8}{'stalled, s':>12}{'first, ms':>11}{'MB':>8}{'quality':>9}{'switches':>10}"
    )
    for row in found["rows"]:
        print(f"{row['rung']:>8}{row['stalls']:8}{row['stalled_seconds']:12}{row['first_ms']:11}{row['megabytes']:8}"
              f"{row['mean_utility']:9}{row['switches']:10}")  # fmt: skip
    print(
        f"an oracle reaches {found['oracle']:.3f}; rungs of the groups: {''.join(map(str, found['taken']))}"
    )
    auto = found["rows"][0]
    figures = {
        "ladder.stalls": auto["stalls"],
        "ladder.mean_quality_over_oracle": auto["mean_utility"] / found["oracle"],
        "ladder.switch_gap_frames": auto["wrong_frames"],
        "ladder.first_frame_ms": auto["first_ms"],
    }
    if found["best_fixed"]:
        figures["ladder.mean_quality_over_best_fixed"] = auto["mean_utility"] / found["best_fixed"]
    return figures
