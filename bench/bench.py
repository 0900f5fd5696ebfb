#!/usr/bin/env python3
"""Measures the project's figures in one run, on the generated capture (./run bench [--minutes M] [NAME...]).

NAME is a figure or the part before its dot: synth, mux, demo, memory, house, cli, demux, draco, fast, delta, visibility, container, sweep,
import, inputs, live, calibration, clip, track, codecs, meshonly, serve, picture, spend, js, pick, measure, analysis, view, look, ladder, chaos, settle, player, three, gpu, sound, npm, docs, site, python,
hypothesis, distributed, hull, calibrate, chain, surfaces, conformance, golden, mutants, spec.
Prints a table and writes build/bench.json: one flat object, figure -> number, with the unit in the name. A run of some
figures keeps the others.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import time

import browser_decoder
import codecs_table
import mesh_only
import player
import python_package
import serve
import view_quality
import whp235
from analysis import figures as analysis_figures
from cluster import dask_times
from gpu import figures as gpu_figures
from house import figures as house_figures
from inputs import figures as input_figures
from inputs import triangles
from muxing import DEMO_OPTIONS, Muxing
from network import live as live_stream
from pages import figures as page_figures
from pages import three as three_renderers
from recordings import calibrate, chain, hull, surfaces
from spend import figures as spending
from spend import scenes
from suite import figures as suite_figures
from track.figures import Tracking

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = ROOT / "build/default"
WORK = ROOT / "build/bench"
RESULTS = ROOT / "build/bench.json"
CAPTURE = WORK / "players"
STREAM = WORK / "players.fvv"


def tool(name, *arguments):
    """Runs a tool and returns its standard output; ends this run with its message when it fails."""
    command = [str(BUILD / "tools" / name / name), *map(str, arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {name} failed ({done.returncode}): {done.stderr.strip()}")
    return done.stdout


def fvvbench(what, path=STREAM):
    done = subprocess.run([BUILD / "bench/fvvbench", what, path], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {done.stderr.strip()}")
    return json.loads(done.stdout)


def capture():
    if not (CAPTURE / "capture.json").exists():
        tool("fvvsynth", "-o", CAPTURE, "--rig", "small", "--force")
    return CAPTURE / "capture.json"


def stream():
    if not STREAM.exists():
        tool("fvvmux", capture(), "-o", STREAM, "--keep-geometry")
    return STREAM


def synth():
    """Wall time of the default capture (13 cameras, 50 frames), on as many threads as there are cores."""
    begin = time.perf_counter()
    tool("fvvsynth", "-o", WORK / "synth", "--force")
    return {"synth.seconds": time.perf_counter() - begin}


def muxing():
    return Muxing(BUILD / "tools/fvvmux/fvvmux", tool, WORK)


def mux():
    figures = muxing().speed(capture())
    for preset in "live", "fast", "medium":
        found = python_package.child(BUILD, "rate", capture().parent, preset)
        figures[f"mux.{preset}_memory_frames_per_s"] = found["frames_per_s"]
    return figures


def live():
    figures = live_stream.measure(BUILD, capture(), WORK)
    return {**figures, **live_stream.measure_cameras(BUILD, tool, WORK)}


def memory():
    return muxing().memory()


def house():
    return house_figures.measure(ROOT, BUILD)


def cli():
    """Lines of --help, the most of any tool."""
    names = [p.name for p in (BUILD / "tools").iterdir() if (p / p.name).is_file()]
    return {"cli.help_lines": max(len(tool(name, "--help").splitlines()) for name in names)}


def demux():
    stream()
    return fvvbench("demux")


def draco():
    stream()
    return fvvbench("draco")


def fast():
    """The meshes of the stream as meshoptimizer encodes them, beside Draco and raw."""
    stream()
    return fvvbench("fast")


def tracked_capture():
    folder = WORK / "tracked"
    if not (folder / "capture.json").exists():
        tool("fvvsynth", "-o", folder, "--rig", "small", "--meshes", "tracked", "--cameras", 1, "--force")
    return folder / "capture.json"


def tracked_stream():
    tracked = WORK / "tracked.fvv"
    if not tracked.exists():
        tool("fvvmux", tracked_capture(), "-o", tracked, "--no-pictures", "--step", "1mm", "--keep-geometry",
             "--force")  # fmt: skip
    return tracked


def delta():
    """Motion of 35,000 triangles on a lattice of 1 mm, with every position within 1 mm."""
    return fvvbench("delta", tracked_stream())


def visibility():
    """Visibility weights of the clip's hulls and cameras, whole and decimated, and of wd2_human20, against rays (bench/visibility.cpp).

    visibility.error_percent and figures like it are of the whole hulls; the others have the case in their name.
    """
    hulls = studio(), "--cameras", ",".join(CLIP_CAMERAS), "--frames", "0-9", "--no-pictures"
    rows = {
        "": (*hulls, "--keep-geometry", "--visibility", "weight"),
        "decimated.": (*hulls, "--max-error", 0.3, "--visibility", "weight"),
    }
    moving = WORK / "moving-seven"
    if not (moving / "capture.json").exists():
        tool(
            "fvvsynth",
            "-o",
            moving,
            "--rig",
            "small",
            "--meshes",
            "tracked",
            "--cameras",
            7,
            "--frames",
            12,
            "--force",
        )
    tracked = moving, "--no-pictures", "--step", "1mm", "--keep-geometry", "--visibility", "weight"
    rows |= {"tracked.": tracked}
    wd2 = view_quality.wd2_capture()
    if wd2:
        real = wd2, "--no-pictures", "--keep-geometry", *view_quality.WINDING
        rows["wd2."] = *real, "--visibility", "weight"
    figures = {}
    print(
        f"{'visibility':12}{'bits':>8}{'error %':>10}{'shown':>8}{'hidden':>8}{'map %':>8}"
        f"{'of all %':>10}{'colour %':>10}{'flips %':>9}{'needless %':>11}"
    )
    for name, arguments in rows.items():
        path = WORK / "visibility.fvv"
        done = json.loads(tool("fvvmux", *arguments, "-o", path, "--force", "--json"))["visibility"]
        found = {
            "bytes_per_frame": done["bytes"] / done["frames"],
        }
        found |= fvvbench("visibility", path)
        found["bits_per_face_camera"] = 8 * found["bytes_per_frame"] / found.pop("face_pairs_per_frame")
        print(f"{name[:-1] or 'hulls':12}{found['bits_per_face_camera']:8.3f}{found['error_percent']:10.2f}"
              f"{found['shown_wrongly_percent']:8.2f}{found['hidden_wrongly_percent']:8.2f}"
              f"{found['depth_map_error_percent']:8.2f}"
              f"{found['error_of_all_percent']:10.2f}{found['colour_elsewhere_percent']:10.2f}"
              f"{found.get('flips_percent', 0):9.2f}{found.get('needless_flips_percent', 0):11.3f}")  # fmt: skip
        figures |= {f"visibility.{name}{figure}": value for figure, value in found.items()}
    return figures


def container():
    info = json.loads(tool("fvvinfo", "--json", stream()))["files"][0]
    return {"container.overhead_percent": 100 * info["container_bytes"] / info["bytes"]}


def sweep():
    script = ROOT / "tests/tools/sweep.py"
    small = WORK / "small.fvv"
    tool("fvvmux", capture(), "-o", small, "--force", "--frames", "0..1", "--no-meshes", "--codec", "jpeg",
         "--quality", "1", "--scale", "0.05")  # fmt: skip
    environment = {"FVV_TOOLS_DIR": str(BUILD / "tools"), "PATH": "/usr/bin:/bin"}
    files = [ROOT / "conformance/tiny/tetrahedron.fvv", small]
    done = subprocess.run([sys.executable, script, *files], capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        sys.exit(f"bench: sweep failed: {done.stderr.strip()}")
    result = json.loads(done.stdout)
    return {"sweep.cases": result["cases"], "sweep.silent_wrong": result["silent_wrong"]}


def calibration_import():
    """The largest distance in pixels between imported cameras and the definition of each of five formats."""
    script = ROOT / "tests/tools/import_formats.py"
    environment = {"FVV_TOOLS_DIR": str(BUILD / "tools"), "PATH": "/usr/bin:/bin"}
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        sys.exit(f"bench: import failed: {done.stderr.strip()}")
    return {"import.max_error_px": json.loads(done.stdout)["max_error_px"]}


def inputs():
    """Mesh files of packages of PyPI and npm, and self-made ones, through fvvmux and fvvdemux, beside trimesh."""
    return input_figures.measure(ROOT, BUILD, WORK / "inputs")


def studio():
    """The default capture with hulls for meshes: 13 cameras, of which oval2 pans, tilts and zooms, 50 frames."""
    folder = WORK / "studio"
    if not (folder / "capture.json").exists():
        tool("fvvsynth", "-o", folder, "--rig", "studio", "--meshes", "hull", "--force")
    return folder


def calibration_moving():
    """The largest reprojection error of the camera that moves, in the worst frame of a stream."""
    done = json.loads(
        tool("fvvmux", studio(), "-o", WORK / "moving.fvv", "--force", "--json", "--verify", "--cameras",
             "oval2", "--no-pictures", "--keep-geometry", "--mesh-profile", "fast")
    )  # fmt: skip
    return {
        "calibration.moving_max_error_px": done["verified"]["moving_max_reprojection"],
        "calibration.moving_bytes_per_frame": done["calibration"]["bytes"] / done["frames"],
    }


# Of the studio: they differ in focal length and distortion, all have texture, and none moves.
CLIP_CAMERAS = ("oval0", "oval1", "oval3", "oval4", "oval6", "oval7", "oval8")
CLIP_TILE = (480, 270)  # a sixteenth of HD, as in the paper


CLIP_CODECS = ("jpeg", "h264", "hevc", "vp9", "av1")


def clip_file(quality, codec):
    return WORK / f"clip{quality}-{codec}.fvv"


def clip_arguments(quality, codec="h264"):
    return (studio(), "--codec", codec, "--cameras", ",".join(CLIP_CAMERAS), "--tile", "{}x{}".format(*CLIP_TILE),
            "--quality", f"{quality}dB")  # fmt: skip


def mux_clip(quality, codec, *more):
    """The summary of fvvmux for the clip's stream, clip_file."""
    arguments = *clip_arguments(quality, codec), "-o", clip_file(quality, codec), "--force", "--json"
    return json.loads(tool("fvvmux", *arguments, *more))


def tracked_surfaces():
    """Captured and generated meshes that change their faces in every frame, with fvvmux --track and as key frames."""
    clip = {"capture": studio(), "cameras": CLIP_CAMERAS, "arguments": clip_arguments}
    return Tracking(BUILD / "tools", WORK, clip).measure()


def tile_videos(summary):
    """The summaries of the video tracks with cameras' pictures; for a single track fvvmux prints no list."""
    return summary["video"] if isinstance(summary["video"], list) else [summary["video"]]


def clip():
    """The clip of the paper's shape (hulls, 7 cameras at 480x270, 50 frames) by codec, and as WHP 235 encoded it.

    Pictures reach 42 dB over the silhouettes, and 36 dB; tiles are cropped to them. Meshes are the same in every stream.
    clip42 and clip36 are those with H.264.
    """
    folder = studio()
    baseline = whp235.sizes(folder / "capture.json", lambda picture: CLIP_TILE, CLIP_CAMERAS)
    rows = [("WHP 235", baseline["mesh"], baseline["picture"], 0, baseline["calibration"], baseline["all"])]
    figures = {"clip.whp235_bytes": baseline["all"], "clip.whp235_mesh_bytes": baseline["mesh"]}
    for quality in 42, 36:
        for codec in CLIP_CODECS:
            done = mux_clip(quality, codec, *(["--verify"] if codec == "h264" else []))
            videos = tile_videos(done)
            tracks = (
                done["mesh"]["bytes"],
                sum(v["bytes"] for v in videos),
                done["visibility"].get("bytes", 0),
            )
            rows.append((f"{quality} dB {codec}", *tracks, done["container_bytes"], done["bytes"]))
            if quality == 42:
                figures[f"clip.fvv_{codec}_bytes"] = done["bytes"]
            if codec == "h264":
                figures[f"clip{quality}.total_bytes"] = done["bytes"]
                figures[f"clip{quality}.psnr_db"] = done["verified"]["psnr"]
                figures["clip.atlas_pixel_share"] = sum(v["crop"]["pixel_share"] for v in videos)
                figures["clip.fvv_mesh_bytes"] = done["mesh"]["bytes"]
                figures["clip.mesh_bytes_per_frame"] = done["mesh"]["bytes"] / done["frames"]
    # Measured against the capture in both directions, by another tool than the one that chose.
    measured = json.loads(tool("fvvcompare", folder, WORK / "clip42-jpeg.fvv", "--json"))
    figures["clip.mesh_rms_mm"] = 1000 * measured["distance"]["symmetric"]["rms"]
    print(f"{'clip, bytes':12}{'mesh':>12}{'pictures':>12}{'visibility':>12}{'rest':>10}{'all':>12}")
    for row in rows:
        print("{:12}{:12}{:12}{:12}{:10}{:12}".format(*row))
    return figures


def codecs():
    """Mesh codecs by size, error and time; the generated capture and those of FVV_DATA."""
    meshes = sorted((tracked_capture().parent / "meshes").iterdir())
    return {**codecs_table.measure(WORK, {"tracked": (meshes, True)}), **meshonly()}


def meshonly():
    """fvvmux on meshes without cameras: whole real sequences, mixed connectivity, a large mesh."""
    return mesh_only.measure(tool, WORK)


def js():
    """The decoder for browsers on meshes of 35,000 triangles, beside the draco3d package of npm."""
    keys = {}
    for profile in ("draco", "fast"):
        keys[profile] = WORK / f"keys-{profile}.fvv"
        if not keys[profile].exists():
            tool("fvvmux", capture(), "-o", keys[profile], "--mesh-profile", profile, "--no-delta", "--no-pictures",
                 "--keep-geometry", "--frames", "0-11", "--force")  # fmt: skip
    figures = browser_decoder.measure(keys["draco"], keys["fast"], tracked_stream())
    for codec in "h264", "jpeg":
        if figures and not clip_file(42, codec).exists():
            mux_clip(42, codec)
    return (
        figures | browser_decoder.first_frames(clip_file(42, "h264"), clip_file(42, "jpeg"))
        if figures
        else {}
    )


def pick():
    """Rays against a mesh of 35,000 triangles with @fvv/analysis, in Node."""
    return analysis_figures.picks(stream())


def view():
    """Bytes of the demo's capture for a viewpoint, with cameras spread over 4 tracks of video, and with a track each."""
    folder = WORK / "synth"
    if not (folder / "capture.json").exists():
        tool("fvvsynth", "-o", folder, "--force")
    streams = {}
    for tracks in "4", "camera":
        streams[tracks] = WORK / f"view-{tracks}.fvv"
        if not streams[tracks].exists():
            tool("fvvmux", folder, "-o", streams[tracks], "--scale", 0.5, "--tile-fill", "flat", "--video-tracks", tracks,
                 "--force")  # fmt: skip
    return browser_decoder.views(streams)


def look():
    """Viewers who walk and who jump in four seconds of 12 cameras with a track of video each, in groups of half a second."""
    folder, path = WORK / "look", WORK / "look.fvv"
    if not (folder / "capture.json").exists():
        rig = ["--rig", "small", "--cameras", 12, "--size", "240x135", "--frames", 100]
        tool("fvvsynth", "-o", folder, *rig, "--force")
    if not path.exists():
        parts = ["--video-tracks", "camera", "--group", 12, "--triangles", 8000]
        tool("fvvmux", folder, "-o", path, *parts, "--force")
    return browser_decoder.look(path)


def ladder_file():
    """A second of the practice scene, packed as the demo packs its game."""
    folder, path = WORK / "second", WORK / "second.fvv"
    if not (folder / "capture.json").exists():
        tool("fvvsynth", "-o", folder, "--scene", "practice", "--frames", 25, "--force")
    if not path.exists():
        tool("fvvmux", folder, "-o", path, *DEMO_OPTIONS, "--ladder", "1,0.75,0.35", "--force")
    return path


def ladder():
    """A minute of a stream with three rungs over a link that falls from 16 to 1 Mbit/s and rises again."""
    folder, path = WORK / "minute", WORK / "minute.fvv"
    if not (folder / "capture.json").exists():
        tool("fvvsynth", "-o", folder, "--rig", "small", "--cameras", 4, "--size", "480x270", "--frames", 1500, "--meshes",
             "tracked", "--force")  # fmt: skip
    if not path.exists():
        tool(
            "fvvmux",
            folder,
            "-o",
            path,
            "--ladder",
            "1,0.5,0.25",
            "--quality",
            "46dB",
            "--group",
            25,
            "--force",
        )
    return browser_decoder.ladder(path)


def chaos():
    """Half an hour of films and of a live stream over a network that fails at random, in simulated time."""
    return browser_decoder.chaos(30)


def settle():
    """Sessions that seek, change the rung, abort and close while replies come in any order: 2,000 of each of five sources."""
    return browser_decoder.settle(2000)


def played():
    """The player, timed with the clip of the paper's shape."""
    if not clip_file(42, "h264").exists():
        mux_clip(42, "h264")
    return player.measure(clip_file(42, "h264"), ladder_file())


def served():
    """fvvserve: replies of a file, and 200 viewers of a live stream, a tenth of whom don't read."""
    return serve.measure(BUILD / "tools/fvvserve/fvvserve", WORK, stream())


def picture():
    """Quality of new viewpoints, and how steady the picture is while the viewer walks."""
    return view_quality.measure()


def spent():
    """What --view-loss saves, and what views lose by it."""
    shape = "--cameras", ",".join(CLIP_CAMERAS), "--tile", "{}x{}".format(*CLIP_TILE)
    return spending.measure((studio(), *shape)) | scenes.measure()


def python_time():
    """The Python package on the file's meshes, beside libfvv, and on the capture, beside fvvmux."""
    stream()
    return python_package.measure(lambda: fvvbench("read")["python.c_read_ms"], BUILD, WORK, STREAM, CAPTURE)


def hypothesis_examples():
    return {"hypothesis.examples": python_package.examples(BUILD)}


def cluster():
    """Groups as tasks of Dask; an hour of 20 cameras is simulated."""
    return dask_times.measure(tool, BUILD, WORK)


def demo():
    """How evenly triangles are spread over the groups of the stream that ./run demo packs."""
    return triangles.measure(BUILD, ROOT / "build/demo/players.fvv")


PARTS = {
    "synth": synth,
    "mux": mux,
    "live": live,
    "demo": demo,
    "memory": memory,
    "house": house,
    "cli": cli,
    "demux": demux,
    "draco": draco,
    "fast": fast,
    "delta": delta,
    "visibility": visibility,
    "container": container,
    "sweep": sweep,
    "import": calibration_import,
    "inputs": inputs,
    "calibration": calibration_moving,
    "clip": clip,
    "track": tracked_surfaces,
    "codecs": codecs,
    "meshonly": meshonly,
    "serve": served,
    "picture": picture,
    "spend": spent,
    "js": js,
    "pick": pick,
    "analysis": analysis_figures.tools_bytes,
    "measure": lambda: analysis_figures.measured(tool, WORK),
    "view": view,
    "look": look,
    "ladder": ladder,
    "chaos": chaos,
    "settle": settle,
    "player": played,
    "three": three_renderers.measure,
    "gpu": gpu_figures.measure,
    "sound": player.sound,
    "npm": browser_decoder.packages,
    "python": python_time,
    "hypothesis": hypothesis_examples,
    "distributed": cluster,
    "hull": hull.hull,
    "calibrate": calibrate.calibrate,
    "chain": chain.chain,
    "surfaces": surfaces.surfaces,
    "docs": page_figures.samples,
    "conformance": lambda: suite_figures.conformance(ROOT),
    "golden": lambda: suite_figures.golden(ROOT),
    "mutants": lambda: suite_figures.mutants(ROOT),
    "spec": lambda: suite_figures.words(ROOT),
    "site": lambda: page_figures.accessibility(stream()),
}


def part_of(name):
    """The part that measures a figure: the text before its dot, except for figures of the table, packages, clips, wasm and the network."""
    if name in (*codecs_table.FIGURES, codecs_table.TIME_FIGURE):
        return "codecs"
    if name == "player.one_file_brotli_bytes":
        return "npm"
    part = name.split(".")[0]
    return {
        "clip42": "clip",
        "clip36": "clip",
        "wasm": "js",
        "net": "js",
        "wd2": "picture",
        "temple": "picture",
        "generated": "picture",
        "mixed": "meshonly",
        "decimate": "meshonly",
        "dask": "distributed",
        "contents": "conformance",
    }.get(part, part)


def rounded(value):
    """Four decimals, or two digits of a figure that would be 0 otherwise."""
    return round(value, 4) or (float(f"{value:.2g}") if value else value)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("names", nargs="*", metavar="NAME", help="figures or parts: " + ", ".join(PARTS))
    parser.add_argument("--minutes", type=float, default=1, help="how long sound is measured; 1 by default")
    arguments = parser.parse_args()
    if not arguments.minutes >= 0.2:
        parser.error("--minutes: expected 0.2 or more")
    names = arguments.names
    unknown = [name for name in names if part_of(name) not in PARTS]
    if unknown:
        parser.error(f"no such figure: {', '.join(unknown)}")
    WORK.mkdir(parents=True, exist_ok=True)
    figures = json.loads(RESULTS.read_text()) if names and RESULTS.exists() else {}
    print(f"{'figure':32} {'value':>12}")
    parts = PARTS | {"sound": lambda: player.sound(arguments.minutes)}
    for part, measure in parts.items():
        wanted = [name for name in names if part_of(name) == part]
        if names and not wanted:
            continue
        for figure, value in measure().items():
            if names and part not in wanted and figure not in wanted:
                continue
            figures[figure] = rounded(value)
            print(f"{figure:32} {figures[figure]:>12}", flush=True)
    RESULTS.write_text(json.dumps(figures, indent=2) + "\n")
    print(f"written to {RESULTS.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
