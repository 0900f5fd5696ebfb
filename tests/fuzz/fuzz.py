"""./run fuzz: builds the fuzz targets with clang, runs them two at a time, and measures the coverage of their corpora."""

import argparse
import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
BUILD = ROOT / "build/fuzz"
CORPUS = ROOT / "build/fuzz-corpus"  # what runs found; kept between runs
SEEDS = ROOT / "build/fuzz-seeds"
TOTALS = ROOT / "build/fuzz-totals.json"  # executions of all runs so far
CRASHES = HERE / "crashes"
# Time and memory that an input may take under sanitizers, which are some 5 and 3 times slower and larger than a release build.
# libFuzzer goes by the clock: --input-seconds is for machines that do other work.
SECONDS_PER_INPUT = 10
MEBIBYTES = 2048
LONGEST = 8 << 10
# Targets that start a process for each input would measure the start; these have programs of their own.
SCRIPTS = {
    "python": [sys.executable, HERE / "fuzz_bindings.py"],
    "javascript": ["node", HERE / "fuzz_decoder.mjs"],
}


def clang():
    """clang and clang++ with the same number, preferably the newest."""
    for number in ["", *(f"-{n}" for n in range(22, 12, -1))]:
        if shutil.which("clang" + number) and shutil.which("clang++" + number):
            return "clang" + number, "clang++" + number
    sys.exit("fuzz.py: no clang: install the Debian packages clang-14 and libclang-rt-14-dev")


def llvm(tool):
    number = re.search(r"-\d+$|$", clang()[0]).group()
    found = shutil.which(tool + number) or shutil.which(tool)
    if not found:
        sys.exit(f"fuzz.py: no {tool}{number}: install the Debian package llvm{number}")
    return found


def build(preset, *targets, core=False):
    environment = dict(os.environ)
    environment["CC"], environment["CXX"] = clang()
    log = ROOT / f"build/build-{preset}.log"
    log.parent.mkdir(exist_ok=True)
    print(f"fuzz.py: building ({preset})", flush=True)
    with log.open("w") as out:
        for command in (
            [
                "cmake",
                "--preset",
                preset,
                "-DCMAKE_UNITY_BUILD=OFF",
                *(f"-DFVV_{x}={'OFF' if core else 'ON'}" for x in ("TOOLS", "MEDIA")),
            ],
            ["cmake", "--build", f"build/{preset}", "--target", *targets],
        ):
            if subprocess.run(command, cwd=ROOT, env=environment, stdout=out, stderr=out).returncode:
                out.flush()
                print("\n".join(log.read_text().splitlines()[-40:]), file=sys.stderr)
                sys.exit(f"fuzz.py: the build failed; all of it is in {log}")


def native_targets():
    listed = subprocess.run(
        [BUILD / "tests/fuzz/fuzz_replay", "--list"], capture_output=True, text=True, check=True
    )
    return sorted(listed.stdout.split())


def available_scripts():
    """The scripts that can run here, and the reasons why others cannot."""
    found, missing = [], []
    for name, command in SCRIPTS.items():
        probe = (
            subprocess.run([*command, "--available"], capture_output=True, text=True)
            if shutil.which(command[0])
            else None
        )
        if probe and probe.returncode == 0:
            found.append(name)
        else:
            missing.append(
                f"skipped: {name}: {probe.stdout.strip() if probe else command[0] + ' is missing'}"
            )
    return found, missing


def make_seeds():
    subprocess.run([sys.executable, HERE / "seeds.py", SEEDS], check=True)
    subprocess.run([BUILD / "tests/fuzz/fuzz_seeds", SEEDS], check=True)


def command_of(target, seconds, corpus, input_seconds):
    if target in SCRIPTS:
        # The first folder receives what is found.
        streams = CORPUS / "stream"
        return [
            *SCRIPTS[target],
            f"--seconds={seconds}",
            f"--crashes={CRASHES / target}",
            corpus,
            SEEDS / "stream",
            streams,
        ]
    return [
        BUILD / "tests/fuzz" / target,
        f"-max_total_time={seconds}",
        f"-timeout={input_seconds}",
        f"-rss_limit_mb={MEBIBYTES}",
        f"-max_len={LONGEST}",
        f"-artifact_prefix={CRASHES / target}/",
        "-print_final_stats=1",
        "-use_value_profile=0",
        corpus,
        SEEDS / target,
    ]


def run_target(target, seconds, input_seconds):
    """Runs a target; after a crash again, for what is left of the time."""
    corpus = CORPUS / target
    crashes = CRASHES / target
    for folder in (corpus, SEEDS / target, crashes):
        folder.mkdir(parents=True, exist_ok=True)
    before = {p.name for p in crashes.iterdir()}
    end = time.monotonic() + seconds
    executions = new = 0
    log = ""
    while (left := round(end - time.monotonic())) > 0:
        done = subprocess.run(
            ["nice", *map(str, command_of(target, left, corpus, input_seconds))],
            cwd=ROOT,
            capture_output=True,
            text=True,
            errors="replace",
        )
        output = done.stdout + done.stderr
        log += output
        executions += sum(map(int, re.findall(r"stat::number_of_executed_units:\s*(\d+)", output)))
        new += sum(map(int, re.findall(r"stat::new_units_added:\s*(\d+)", output)))
        if done.returncode == 0:
            break
    # libFuzzer also keeps inputs that were merely slow (slow-unit-...): these are no failures.
    found = sorted({p.name for p in crashes.iterdir() if not p.name.startswith("slow-unit")} - before)
    for slow in crashes.glob("slow-unit-*"):
        slow.unlink()
    if not any(crashes.iterdir()):
        crashes.rmdir()
    (ROOT / "build/fuzz-logs").mkdir(exist_ok=True)
    (ROOT / f"build/fuzz-logs/{target}.log").write_text(log)
    failed = done.returncode != 0
    return {
        "target": target,
        "executions": executions,
        "new": new,
        "crashes": len(found) or int(failed),
        "inputs": found,
    }


def fuzz(options):
    build("fuzz", "fuzz_targets", "fuzz_replay", "fuzz_seeds")
    make_seeds()
    scripts, missing = available_scripts()
    targets = native_targets() + scripts
    if options.target:
        unknown = set(options.target) - set(targets)
        if unknown:
            print("\n".join(missing), file=sys.stderr)
            print(
                f"fuzz.py: no target {', '.join(sorted(unknown))}; these are: {' '.join(targets)}",
                file=sys.stderr,
            )
            return 2
        targets = options.target
    else:
        print("\n".join(missing))
    print(f"{'target':<16} {'executions':>12} {'in all':>12} {'new units':>10} {'crashes':>8}")
    results = []
    totals = json.loads(TOTALS.read_text()) if TOTALS.exists() else {}
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for result in pool.map(lambda t: run_target(t, options.seconds, options.input_seconds), targets):
            results.append(result)
            totals[result["target"]] = totals.get(result["target"], 0) + result["executions"]
            TOTALS.write_text(json.dumps(totals, indent=1))
            total = totals[result["target"]]
            print(
                f"{result['target']:<16} {result['executions']:>12,} {total:>12,} {result['new']:>10,} {result['crashes']:>8}",
                flush=True,
            )
    executions, crashes = sum(r["executions"] for r in results), sum(r["crashes"] for r in results)
    print(f"fuzz.targets {len(results)}, fuzz.executions {executions:,}, fuzz.crashes {crashes}")
    for result in results:
        for name in result["inputs"]:
            print(
                f"{CRASHES.relative_to(ROOT)}/{result['target']}/{name}: build/fuzz-logs/{result['target']}.log"
            )
    (ROOT / "build/fuzz.json").write_text(
        json.dumps(
            {
                "fuzz.targets": len(results),
                "fuzz.executions": executions,
                "fuzz.crashes": crashes,
                "targets": results,
            },
            indent=1,
        )
    )
    return 1 if crashes else 0


# Coverage.

PARTS = {
    "libfvv/src": "libfvv, the C library",
    "libfvv/scene": "fvv_scene: captures and imports",
    "libfvv/media": "fvv_media: pictures, video and sound",
    "libfvv/mux": "fvv_mux: the encoder",
    "libfvv/geometry": "fvv_geometry",
    "libfvv/render": "fvv_render",
}


def coverage(options):
    """Runs all inputs of the seeds, corpora and crashes without libFuzzer and counts the lines that they reach."""
    build("fuzz-coverage", "fuzz_replay", core=options.core)
    program = ROOT / "build/fuzz-coverage/tests/fuzz/fuzz_replay"
    raw = ROOT / "build/fuzz-coverage/raw"
    shutil.rmtree(raw, ignore_errors=True)
    raw.mkdir(parents=True)
    if not SEEDS.exists():
        build("fuzz", "fuzz_seeds", core=options.core)
        make_seeds()
    listed = subprocess.run([program, "--list"], capture_output=True, text=True, check=True)

    def replay(target):
        folders = [f / target for f in (SEEDS, CORPUS, CRASHES) if (f / target).is_dir()]
        environment = os.environ | {"LLVM_PROFILE_FILE": str(raw / f"{target}.profraw")}
        done = subprocess.run(
            ["nice", program, target, *folders], env=environment, capture_output=True, text=True
        )
        if done.returncode:
            sys.exit(f"fuzz.py: {target} fails: {done.stderr}")
        print(f"{target:<16} {done.stdout.strip()}", flush=True)

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(replay, listed.stdout.split()))
    profile = raw / "all.profdata"
    subprocess.run(
        [llvm("llvm-profdata"), "merge", "-sparse", "-o", profile, *raw.glob("*.profraw")], check=True
    )
    exported = subprocess.run(
        [llvm("llvm-cov"), "export", "-summary-only", f"-instr-profile={profile}", program],
        capture_output=True,
        check=True,
    )
    files = json.loads(exported.stdout)["data"][0]["files"]
    print(f"{'':<40} {'lines':>8} {'covered':>8}")
    figures = {}
    for part, title in PARTS.items():
        lines = [f["summary"]["lines"] for f in files if f"/{part}/" in f["filename"]]
        count, covered = sum(x["count"] for x in lines), sum(x["covered"] for x in lines)
        if count:
            figures[part] = 100 * covered / count
            print(f"{title:<40} {count:>8,} {figures[part]:>7.1f}%")
    if options.files:
        for f in sorted(files, key=lambda f: f["summary"]["lines"]["percent"]):
            name = f["filename"].rpartition("/libfvv/")[2]
            if f["summary"]["lines"]["count"] and not name.startswith("/"):
                print(
                    "{:6.1f}% of {:4} {}".format(
                        f["summary"]["lines"]["percent"], f["summary"]["lines"]["count"], name
                    )
                )
    print(f"fuzz.line_coverage_percent {figures['libfvv/src']:.1f}")
    return 0


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("seconds", nargs="?", type=int, default=60, help="for each target; default 60")
    parser.add_argument("target", nargs="*", help="targets; default all")
    parser.add_argument(
        "--coverage", action="store_true", help="measure the lines that seeds and corpora reach instead"
    )
    parser.add_argument(
        "--core", action="store_true", help="with --coverage: only libfvv, which builds in a minute"
    )
    parser.add_argument("--files", action="store_true", help="with --coverage: each source file too")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time; default 2")
    parser.add_argument(
        "--input-seconds",
        type=int,
        default=SECONDS_PER_INPUT,
        help=f"time by the clock that an input of a native target may take; default {SECONDS_PER_INPUT}; more on a busy machine",
    )
    options = parser.parse_args()
    return coverage(options) if options.coverage else fuzz(options)


if __name__ == "__main__":
    sys.exit(main())
