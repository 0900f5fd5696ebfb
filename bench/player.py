"""The reference player in Chromium and Firefox, with WebGL in software: likeness to fvvrender, speed and steadiness (./run bench player)."""

import json
import pathlib
import shutil
import subprocess
import sys

import browser_decoder
import player_renderer

ROOT = pathlib.Path(__file__).resolve().parent.parent
PLAYER = ROOT / "js/player"
# The figures of WHP 235, for its own clip and machines.
SEED = {"fps": "14 to 47", "first": "1.41 s to the first mesh"}


def node(script, *arguments):
    """Runs a script and returns its JSON; its messages go to the terminal."""
    done = subprocess.run(["node", script, *map(str, arguments)], stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"bench: {script.name} failed ({done.returncode})")
    return json.loads(done.stdout)


def missing():
    if not (ROOT / "js/node_modules/esbuild").exists():
        return "no js/node_modules here: npm ci in js"
    for program in "emcmake", "chromium":
        if not shutil.which(program):
            return f"no {program} here"
    return None


def speed(clip):
    found = node(ROOT / "bench/player.mjs", clip)
    figures = {"player.first_picture_ms": found["firstMs"]}
    for way, name in ("depth", "depth_maps"), ("bits", "visibility_bits"):
        figures[f"player.fps_{name}"] = found[way]["playing"]
        figures[f"player.fps_{name}_standing"] = found[way]["still"]
    figures["player.frame_time_over_before"] = max(found[way]["viewerOverPaper"] for way in ("depth", "bits"))
    figures["player.fps_auto"] = found["auto"]["rate"]
    counters = found["bits"]["counters"]
    figures |= {
        "player.draw_calls": counters["drawCalls"],
        "player.samplers": counters["samplers"],
        "player.bytes_per_content_frame": counters["bytesUploadedPerContentFrame"],
        "player.bytes_per_drawn_frame": counters["bytesUploadedPerDrawnFrame"],
        # With depth maps: a layer for each camera, once for each frame of the clip.
        "player.depth_passes_per_content_frame": found["depth"]["counters"]["depthPasses"]
        / found["depth"]["counters"]["contentFrames"],
    }
    fps = [figures[f"player.fps_{name}"] for name in ("depth_maps", "visibility_bits")]
    print(
        f"frames/s at 960x540 by depth maps and by bits: {fps[0]:.1f}, {fps[1]:.1f} (WHP 235: {SEED['fps']})"
    )
    auto = found["auto"]
    print(
        f"at the resolution that the player chooses: {auto['rate']:.1f}, with a surface of {auto['surfaceScale']:g} of the "
        f"picture, and that of {auto['ratio']:g}"
    )
    print(f"first picture over 8 Mbit/s and 40 ms: {found['firstMs']:.0f} ms (WHP 235: {SEED['first']})")
    return figures


def first_seconds(ladder):
    """ladder: a clip that has one. The first picture that is seen, and how like the finest rung it is where the surface is."""
    found = node(ROOT / "bench/player.mjs", "--ladder", ladder)
    print(
        f"first picture that is seen, over 8 Mbit/s and 40 ms: {found['ms']:.0f} ms, of rung {found['rung']}, with an SSIM of "
        f"{found['ssim']:.3f} against the finest; its first frame came after {found['coarseMs']:.0f} ms"
    )
    return {"player.first_good_picture_ms": found["ms"], "player.first_good_ssim": found["ssim"]}


def speed_in_firefox(clip):
    if not player_renderer.has_firefox():
        return {}
    found = node(ROOT / "bench/player.mjs", clip, "firefox")
    fps = [found[way]["playing"] for way in ("depth", "bits")]
    print(f"frames/s in Firefox by depth maps and by bits: {fps[0]:.1f}, {fps[1]:.1f}")
    return {
        "player.firefox_fps_depth_maps": fps[0],
        "player.firefox_fps_visibility_bits": fps[1],
        "player.firefox_bytes_per_content_frame": found["bits"]["counters"]["bytesUploadedPerContentFrame"],
    }


def endurance():
    """The element plays 10,000 frames with 100 seeks and changes of rate; figures come from the drawn pictures."""
    found = node(PLAYER / "test/endurance/measure.mjs")
    for wrong in found["wrong"]:
        print(wrong)
    return {
        "player.endurance_frames": found["frames"],
        "player.wrong_frame_pairs": found["wrongCount"],
        "player.heap_growth_mib": found["heapGrowthMiB"],
        "player.most_open_video_frames": found["mostOpen"],
    }


def sound(minutes=1):
    """Claps: how far the flash on the screen and its click at the audio device are apart, once and in a loop of 4 s.

    What is apart has two causes, which are measured on their own: the clock of playback may differ from what the device
    plays, and a frame may be late on the screen. Without a GPU a busy machine skips refreshes of the screen; figures with
    `regular` are of the claps around which it did not.
    """
    if reason := missing():
        print(f"sound.* is left out: {reason}")
        return {}
    found = node(PLAYER / "test/endurance/sound.mjs", round(60 * minutes))
    figures = {"sound.minutes": minutes}
    for part, prefix in ("once", "sound."), ("loop", "sound.loop_"):
        one = found[part]
        print(
            f"{part}: {one['seen']} of {one['claps']} claps seen, {one['beyondTarget']} more than 20 ms apart; "
            f"{one['regular']['claps']} with regular refreshes; refreshes at {one['refresh']['median']:.1f} ms "
            f"(95 %: {one['refresh']['p95']:.1f} ms); load {one['load']:.1f}"
        )
        figures |= {
            f"{prefix}max_offset_ms": one["offset"]["max"],
            f"{prefix}p95_offset_ms": one["offset"]["p95"],
            f"{prefix}median_offset_ms": one["offset"]["median"],
            f"{prefix}regular_max_offset_ms": one["regular"]["max"],
            f"{prefix}drift_ms": one["drift"],
            f"{prefix}max_clock_error_ms": one["clock"]["max"],
        }
    return {figure: value for figure, value in figures.items() if value is not None}


def measure(clip, ladder):
    """clip: of the paper's shape. ladder: one that has a ladder."""
    reason = missing()
    if reason:
        print(f"player.* is left out: {reason}")
        return {}
    if not (ROOT / "js/decoder/dist/core.wasm.js").exists():
        browser_decoder.run(ROOT / "js/decoder/wasm/build.sh", ROOT / "build/wasm")
    return (
        player_renderer.measure() | speed(clip) | first_seconds(ladder) | speed_in_firefox(clip) | endurance()
    )
