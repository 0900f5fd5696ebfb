"""Where links break: chunks that never arrive, bandwidth that drops, and a recorder whose clock runs at another speed."""

import hashlib
import json
import shutil
import wave
from fractions import Fraction

import av
import browser_decoder
import numpy as np
import player

from .. import degradations, drawing, experiment, growth

LOSSES = 0.1, 0.3, 1, 3, 10  # percent of chunks
GROUPS = 1, 5, 25, 150  # frames
LOSSY_FRAMES, TRIALS = 150, 5
FALLS = 1, 0.3, 0.1, 0.03  # of the best rung's rate, for the middle third of the clip
FILMED_FRAMES = 500
PPM = 0, 20, 50, 100, 500
SOUND_SECONDS, SOUND_RATE = 60, 48000
CLICK = np.sin(2 * np.pi * 1500 * np.arange(240) / SOUND_RATE) * np.exp(-np.arange(240) / 60)
AUDIBLE_MS = 20


def frames_of(folder):
    """{frame: digest of its mesh and all of its pictures}, of what fvvdemux wrote."""
    found = {}
    for path in sorted([*folder.glob("meshes/*.ply"), *folder.glob("cam*/*.png")]):
        found.setdefault(int(path.stem.split("_")[-1]), []).append(
            path.parent.name + hashlib.sha256(path.read_bytes()).hexdigest()
        )
    return {frame: tuple(parts) for frame, parts in found.items()}


def unpacked(stream, name):
    """Frames that fvvdemux writes, at their times, and its exit code; nothing when it writes nothing."""
    folder = experiment.WORK / name
    try:
        done = experiment.run("fvvdemux", stream, "-o", folder, "--threads", 1, "--force")
    except experiment.Failed as failed:
        if failed.code != 1:
            raise
        return {}, 1
    found = frames_of(folder)
    shutil.rmtree(folder)
    return found, done.code


def lossy_stream(frames, group):
    return experiment.packed(
        growth.long_capture(frames), "--keep-geometry", "--step", "1mm", "--group", group
    ).path


def losses(frames, groups, shares, trials):
    """Frames that are lost with a share of the chunks, and wrong frames: those whose mesh or picture is no frame of the intact stream."""
    series, path = {}, experiment.WORK / "lossy.fvv"
    for group in groups:
        stream = lossy_stream(frames, group)
        intact, _ = unpacked(stream, "intact")
        good, rows = set(intact.values()), []
        for share in shares:
            row = {"percent": share, "chunks_lost": 0, "frames_lost": 0, "wrong": 0, "silent": 0}
            for trial in range(trials):
                random = np.random.default_rng((trial, round(10 * share)))
                damaged, lost = degradations.with_losses(stream.read_bytes(), share / 100, random)
                path.write_bytes(damaged)
                found, code = unpacked(path, "lossy")
                row["chunks_lost"] += lost
                row["frames_lost"] += len(intact) - len(found)
                row["wrong"] += sum(parts not in good for parts in found.values())
                row["silent"] += bool(lost and not code)
            row["frames_lost_percent"] = 100 * row["frames_lost"] / (trials * len(intact))
            rows.append(row)
        series[str(group)] = rows
    chunks = sum(
        kind in degradations.GROUP_TYPES
        for kind, _, _ in degradations.chunks(lossy_stream(frames, groups[0]).read_bytes())
    )
    return {"groups": series, "frames": frames, "trials": trials, "chunks": chunks}


def filmed_stream():
    """A clip with a ladder of two rungs: 100 frames of two cameras at 480x270, again and again."""
    filmed = experiment.capture("filmed", "--rig", "small", "--cameras", 2, "--frames", growth.PERIOD)
    capture = growth.long_capture(FILMED_FRAMES, filmed=filmed)
    options = (
        "--keep-geometry",
        "--mesh-ladder",
        "off",
        "--crop",
        "none",
        "--tile-fill",
        "keep",
        "--visibility",
        "none",
    )
    return experiment.packed(capture, *options, "--quality", "45dB", "--ladder", "1,0.5", "--group", 25).path


def bandwidth():
    """Stalls while the rate of a link falls for a third of the clip: the player's choice of rungs, and the best rung alone."""
    reason = player.missing()
    if reason or not (experiment.ROOT / "js/decoder/dist/core.wasm.js").exists():
        experiment.left_out("drops of bandwidth", reason or "js/decoder was not built")
        return None
    stream = filmed_stream()
    best = experiment.answer("fvvinfo", stream)["files"][0]["rungs"][0]["measured_rate"] / 1e6
    rows = []
    for fall in FALLS:
        rates = f"{1.5 * best:.4g},{fall * best:.4g},{1.5 * best:.4g}"
        found = json.loads(
            browser_decoder.run("node", experiment.ROOT / "bench/network/ladder.mjs", stream, rates)
        )
        row = {"share": fall, "mbit": fall * best}
        for name, played in zip(("auto", "best", "lowest"), found["rows"]):
            row |= {f"{name}_stalled_s": played["stalled_seconds"], f"{name}_wrong": played["wrong_frames"]}
        row["lowest_mbit"] = found["rungs"][-1]["bitRate"] / 1e6
        rows.append(row)
    return {"rows": rows, "best_mbit": best, "seconds": FILMED_FRAMES / 25}


def clicks(ppm):
    """Sound of a recorder whose clock is slow by some millionths: a click in each second of the scene, later and later."""
    samples = np.zeros(SOUND_SECONDS * SOUND_RATE)
    for second in range(1, SOUND_SECONDS):
        at = round(second * (1 + ppm / 1e6) * SOUND_RATE)
        samples[at : at + len(CLICK)] += 0.5 * CLICK[: len(samples) - at]
    return samples


def write_wave(path, samples):
    with wave.open(str(path), "wb") as out:
        out.setparams((1, 2, SOUND_RATE, len(samples), "NONE", ""))
        out.writeframes((samples * 32767).round().astype("<i2").tobytes())


def decoded_sound(path):
    """Samples of a file of one channel, from time 0 on."""
    samples = np.zeros((SOUND_SECONDS + 1) * SOUND_RATE)
    with av.open(str(path)) as file:
        for frame in file.decode(audio=0):
            at = round(float(frame.pts * frame.time_base) * SOUND_RATE)
            part = frame.to_ndarray().astype(float).reshape(-1)[max(0, -at) :]
            samples[max(0, at) : max(0, at) + len(part)] = part
    return samples


def click_times(samples, guesses):
    """Seconds of the clicks nearest to some times, by correlation, within 50 ms."""
    out = []
    for guess in guesses:
        begin = round((guess - 0.05) * SOUND_RATE)
        part = samples[begin : begin + round(0.1 * SOUND_RATE) + len(CLICK)]
        out.append((begin + int(np.argmax(np.correlate(part, CLICK)))) / SOUND_RATE)
    return np.array(out)


def sound():
    """What a stream makes of it: clicks after encoding with Opus, unpacking and decoding, against the second that they belong to."""
    seconds, rows = np.arange(1, SOUND_SECONDS), []
    for ppm in PPM:

        def edit(description, folder, ppm=ppm):
            write_wave(folder / "clicks.wav", clicks(ppm))
            description["audio"] = [{"file": "clicks.wav"}]

        capture = growth.long_capture(25 * SOUND_SECONDS, f"sound{ppm}-", edit)
        made = experiment.packed(capture, "--no-pictures", "--keep-geometry", "--step", "1mm")
        folder = experiment.WORK / "sound"
        experiment.run("fvvdemux", made.path, "-o", folder, "--pictures", "none", "--force")
        [track] = json.loads((folder / "capture.json").read_text())["audio"]
        shift = float(Fraction(track.get("offset", 0)))  # of the first frame in the file
        found = click_times(decoded_sound(folder / track["file"]), seconds * (1 + ppm / 1e6) + shift) - shift
        off = 1000 * (found - seconds)
        added = 1000 * np.abs(found - seconds * (1 + ppm / 1e6)).max()
        rows.append(
            {
                "ppm": ppm,
                "off_ms": off[4::5].tolist(),
                "seconds": seconds[4::5].tolist(),
                "added_ms": float(added),
            }
        )
    return {"rows": rows}


def measure(quick):
    programs = [experiment.digest_of(experiment.program(name)) for name in ("fvvmux", "fvvdemux")]
    chosen = (50, (25,), (1, 10), 3) if quick else (LOSSY_FRAMES, GROUPS, LOSSES, TRIALS)
    found = experiment.kept("losses", (*programs, *chosen), lambda: losses(*chosen))
    if quick:
        return {"losses": found}
    return {
        "losses": found,
        "bandwidth": bandwidth(),
        "sound": experiment.kept("sounds", (*programs, *PPM), sound),
    }


def draw(results, folder):
    figure, panels = drawing.sheet(3, 1, 3.6, 3.0)
    axis, found = panels[0], results["losses"]
    for number, (group, rows) in enumerate(found["groups"].items()):
        drawing.line(axis, number, [r["percent"] for r in rows], [max(r["frames_lost_percent"], 0.05) for r in rows],
                     f"groups of {group}" if group != "1" else "each frame alone")  # fmt: skip
    drawing.logarithmic(axis, "x", LOSSES)
    drawing.logarithmic(axis, "y", (0.1, 1, 10, 100))
    wrong = sum(r["wrong"] for rows in found["groups"].values() for r in rows)
    axis.set(title=f"Lost chunks ({wrong} wrong frames)", xlabel="chunks lost, %", ylabel="frames lost, %")
    axis.legend(loc="lower right")
    axis = panels[1]
    if found := results["bandwidth"]:
        rows = found["rows"]
        for number, (name, label) in enumerate(
            (("auto", "ladder, chosen"), ("best", "best rung alone"), ("lowest", "lowest rung alone"))
        ):
            drawing.line(
                axis, number, [100 * r["share"] for r in rows], [r[f"{name}_stalled_s"] for r in rows], label
            )
        drawing.logarithmic(axis, "x", [100 * r["share"] for r in rows])
        most = max(r[f"{name}_stalled_s"] for r in rows for name in ("auto", "best", "lowest"))
        axis.set_ylim(-0.03 * most, 1.5 * most + 0.1)
        drawing.mark(axis, 100 * rows[0]["lowest_mbit"] / found["best_mbit"], "rate of the\nlowest rung", 0.4)
        axis.legend(loc="upper right")
    axis.set(
        title="Bandwidth that drops",
        xlabel="rate for a third of the clip, % of the best rung's",
        ylabel="stalled, s",
    )
    axis = panels[2]
    for number, row in enumerate(results["sound"]["rows"]):
        drawing.line(axis, number, row["seconds"], row["off_ms"], f"{row['ppm']} ppm", markersize=3)
    axis.axhline(
        AUDIBLE_MS,
        color=drawing.BLACK,
        linewidth=0.8,
        linestyle="--",
        label=f"{AUDIBLE_MS} ms, the player's target",
    )
    axis.set(title="A recorder's clock", xlabel="seconds", ylabel="sound late, ms")
    axis.set_ylim(-1, 48)
    axis.legend(loc="upper left", ncols=2)
    drawing.save(figure, folder / "stability-link.svg")


def text(results):
    found, drops, clocks = results["losses"], results["bandwidth"], results["sound"]["rows"]
    every = [r for rows in found["groups"].values() for r in rows]
    wrong, silent, lost = (sum(r[name] for r in every) for name in ("wrong", "silent", "chunks_lost"))

    def at(group, percent):
        return next(r for r in found["groups"][group] if r["percent"] == percent)["frames_lost_percent"]

    lines = [
        "![Frames lost, stalls and sound over what breaks links](stability-link.svg)",
        "",
        f"**Of {lost:,} lost chunks {silent} went unnoticed and {wrong} frames came out wrong: a reader drops what is not intact, and the length of "
        f"groups decides how much, {at('1', 1):.1f} % of frames with 1 % of chunks lost when each frame is alone, {at('25', 1):.0f} % with the default groups of a second.**",
        "",
        f"- Loss: {found['frames']} frames, {found['trials']} trials each; about {found['chunks'] / found['frames']:.0f} chunks per frame when each is alone. A frame "
        "counts as lost without its mesh or any of its pictures, because `fvvdemux` writes whole frames only. fvv is made for reliable links (TCP, files); "
        "0.05 % in the chart means none.",
    ]
    if drops:
        first, *others = drops["rows"]
        said = "; ".join(
            f"at {100 * r['share']:g} % for {r['auto_stalled_s']:.1f} s, with the best rung alone {r['best_stalled_s']:.1f} s, with the lowest "
            f"{r['lowest_stalled_s']:.1f} s"
            for r in others
        )
        lines.append(
            f"- Bandwidth: a clip of {drops['seconds']:.0f} s over a link with 1.5 times the best rung's {drops['best_mbit']:.1f} Mbit/s, and less in its "
            f"middle third. With `quality: \"auto\"` playback stalls for {first['auto_stalled_s']:.1f} s at 100 % of the best rung's rate; {said}. "
            f"{sum(r['auto_wrong'] for r in drops['rows'])} frames lacked a part. Some 90 kB that are on their way keep the old rate when it rises again, so that "
            "stalls outlast the drop."
        )
        if first["best_stalled_s"] > 1 or first["lowest_stalled_s"] > 1:
            lines.append(
                f"- A fixed rung stalls even where the link is fast enough ({first['best_stalled_s']:.1f} s with the best, {first['lowest_stalled_s']:.1f} s "
                "with the lowest, at 100 %), in some runs and not in others, as if it did not read ahead, which `auto` does."
            )
    late = [r for r in clocks if r["ppm"]]
    lines.append(
        f"- Sound: coding and packing move a click by at most {max(r['added_ms'] for r in clocks):.3f} ms, and do not correct a recorder's clock: "
        f"{late[1]['ppm']} ppm are {late[1]['off_ms'][-1]:.1f} ms after a minute, so {AUDIBLE_MS} ms after {AUDIBLE_MS * 1000 / late[1]['ppm'] / 60:.0f} minutes. "
        "The clock of the player's audio device is another matter (`./run bench sound`, `sound.drift_ms`)."
    )
    return "\n".join(lines)


def headlines(results):
    rows = results["losses"]["groups"]["25"]
    return {"wrong_frames": sum(r["wrong"] for r in rows), "unnoticed_losses": sum(r["silent"] for r in rows)}


def defaults(results):
    rows = {
        g: next(r for r in found if r["percent"] == 1) for g, found in results["losses"]["groups"].items()
    }
    said = ", ".join(f"{rows[g]['frames_lost_percent']:.0f} % in groups of {g}" for g in ("5", "25", "150"))
    return [("fvvmux --group", "1 s", f"frames lost with 1 % of the chunks: {said}")]


EXPERIMENTS = (
    experiment.Experiment("stability-link", "Where links break", measure, draw, text, headlines, defaults),
)
