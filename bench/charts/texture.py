"""Pictures: bytes against foreground quality, by codec, by cropping and by what fills the background.

Quality is that of whole pictures as a reader gets them, against the capture's: PSNR of luma over the pixels of the silhouettes
(foreground), over all pixels of the pictures (whole), and SSIM over windows whose centre is in a silhouette, with grey outside of it.
"""

import json
import math
import shutil

import numpy as np
import view_quality
from PIL import Image
from real_capture import luma

from . import drawing, experiment, numbers, system

FRAMES = 6
SIZES = "480x270", "960x540"
MODES = {
    "full": ("--crop", "none", "--tile-fill", "keep"),
    "cropped, flat": ("--tile-fill", "flat"),
    "cropped, smooth": ("--tile-fill", "smooth"),
}
# The codec's own numbers, from fine to coarse.
NUMBERS = {
    "jpeg": (92, 80, 60, 35),
    "h264": (18, 24, 30, 36),
    "hevc": (18, 24, 30, 36),
    "vp9": (20, 30, 40, 50),
    "av1": (20, 30, 40, 50),
}
NAMES = {"jpeg": "JPEG", "h264": "H.264", "hevc": "HEVC", "vp9": "VP9", "av1": "AV1"}
GREY = 128.0


def clip(size, frames=FRAMES):
    return experiment.capture(
        f"pictures-{size}", "--rig", "small", "--size", size, "--meshes", "tracked", "--frames", frames
    )


def bounds(mask):
    """The box around a silhouette with room for the windows of SSIM."""
    rows, columns = np.flatnonzero(mask.any(1)), np.flatnonzero(mask.any(0))
    return slice(max(0, rows[0] - 6), rows[-1] + 7), slice(max(0, columns[0] - 6), columns[-1] + 7)


def quality(source, stream):
    """Of all pictures of a stream against those of its capture."""
    folder = experiment.WORK / "decoded" / stream.stem
    experiment.run("fvvdemux", stream, "-o", folder, "--meshes", "none", "--force")
    read, decoded = (json.loads((f / "capture.json").read_text()) for f in (source, folder))
    squares, pixels, whole, ssims = 0.0, 0, [], []
    for before, after in zip(read["cameras"], decoded["cameras"]):
        for frame in range(decoded["frames"]["count"]):
            truth, drawn = (
                luma(source / (before["pictures"] % frame)),
                luma(folder / (after["pictures"] % frame)),
            )
            mask = np.asarray(Image.open(source / (before["masks"] % frame)).convert("L")) > 128
            error = (truth - drawn) ** 2
            squares, pixels = squares + error[mask].sum(), pixels + mask.sum()
            whole.append(error.mean())
            box = bounds(mask)
            foreground = (np.where(mask, picture, GREY)[box] for picture in (truth, drawn))
            ssims.append(view_quality.ssim(*foreground, mask[box]))
    shutil.rmtree(folder)
    return {
        "psnr_foreground_db": 10 * math.log10(255**2 / (squares / pixels)),
        "psnr_whole_db": 10 * math.log10(255**2 / np.mean(whole)),
        "ssim_foreground": float(np.mean(ssims)),
    }


def row(source, codec, mode, number):
    made = experiment.packed(source, "--no-meshes", "--codec", codec, "--quality", number, *MODES[mode])
    found = experiment.kept("pictures", [source, made.path], lambda: quality(source, made.path))
    return {
        "quality": number,
        "bytes_per_frame": experiment.video_bytes(made.summary) / made.summary["frames"],
        "mux_s": made.seconds,
    } | found


def measure(quick):
    if quick:
        source = system.clip("tracked", system.QUICK_FRAMES)
        return {mode: row(source, "h264", mode, 24) for mode in ("full", "cropped, flat")}
    out = {"frames": FRAMES, "sizes": {}}
    for size in SIZES:
        source = clip(size)
        out["sizes"][size] = {
            codec: {
                mode: [row(source, codec, mode, number) for number in NUMBERS[codec]]
                for mode in (MODES if codec != "jpeg" else ["full"])
            }
            for codec in NUMBERS
        }
    out["bd_rate_percent"] = {
        size: {
            codec: {mode: against(found, "h264", "full", codec, mode) for mode in modes}
            for codec, modes in found.items()
        }
        for size, found in out["sizes"].items()
    }
    return out


def curve(found, codec, mode):
    return [(r["bytes_per_frame"], r["psnr_foreground_db"]) for r in found[codec][mode]]


def against(found, codec, mode, other_codec, other_mode):
    return numbers.bd_rate(curve(found, codec, mode), curve(found, other_codec, other_mode))


def headlines(results):
    full, cropped = results["full"], results["cropped, flat"]
    return {
        "h264_bytes_per_frame": cropped["bytes_per_frame"],
        "h264_cropped_over_full": cropped["bytes_per_frame"] / full["bytes_per_frame"],
        "h264_foreground_mse": 255**2 / 10 ** (cropped["psnr_foreground_db"] / 10),
    }


def draw(results, folder):
    looks = {"full": ":", "cropped, flat": "-", "cropped, smooth": "--"}
    figure, panels = drawing.sheet(2, 2, 4.8, 3.5)
    for column, (size, found) in enumerate(results["sizes"].items()):
        for axis, what, label in (
            (panels[column], "psnr_foreground_db", "PSNR of the foreground, dB"),
            (panels[2 + column], "ssim_foreground", "SSIM of the foreground"),
        ):
            for number, (codec, modes) in enumerate(found.items()):
                for mode, rows in modes.items():
                    drawing.line(axis, number, [r["bytes_per_frame"] / 1000 for r in rows], [r[what] for r in rows],
                                 NAMES[codec] if mode in ("cropped, flat", "full") and (mode != "full" or codec == "jpeg") else None,
                                 linestyle=looks[mode], markersize=3.5)  # fmt: skip
            drawing.logarithmic(axis, "x")
            axis.set_xlabel("kB per frame, pictures of 7 cameras")
            axis.set_ylabel(label)
            axis.set_title(f"7 cameras of {size}")
        for mode, look in looks.items():
            panels[column].plot([], [], color=drawing.BLACK, linestyle=look, label=mode)
        panels[column].legend(loc="upper left", fontsize=7)
    drawing.save(figure, folder / "texture.svg")


def text(results):
    rates = results["bd_rate_percent"]
    first = rates[SIZES[0]]

    def best(size):
        cells = {(c, m): r for c, modes in rates[size].items() for m, r in modes.items() if r is not None}
        codec, mode = min(cells, key=cells.get)
        return f"{NAMES[codec]} {mode} ({cells[codec, mode]:.0f} %)"

    lines = ["| pictures | codec | full | cropped, flat | cropped, smooth |", "|---|---|---|---|---|"]
    for size, codecs in rates.items():
        for codec, modes in codecs.items():
            cells = (f"{modes[m]:+.0f} %" if modes.get(m) is not None else "-" for m in MODES)
            lines.append(f"| {size} | {NAMES[codec]} | " + " | ".join(cells) + " |")
    table = "\n".join(lines)
    return f"""![PSNR and SSIM of the foreground over kB per frame](texture.svg)

**At the same quality of the foreground, cropping to the silhouettes saves {-first['h264']['cropped, flat']:.0f} % of the bytes of whole pictures with H.264, and
JPEG takes {1 + first['jpeg']['full'] / 100:.1f} times those.** BD-rates against H.264 of whole pictures, over PSNR of the foreground, not extrapolated:

{table}

The fewest bytes have {' and '.join(f'{best(size)} at {size}' for size in rates)}. Foreground means the pixels of the silhouettes; over all pixels cropped pictures are far
worse, because the background is gone on purpose. {results['frames']} frames of the generated clip, whose pictures are sharp and have no
noise; each codec at four of its own numbers, with the settings of fvvmux. Guard bands of 4 pixels and the filled background are part of
the cropped bytes. At the same number of the codec the foreground of H.264 changes by {leak(results):+.2f} dB against whole pictures: that is what rate control, the
borders of tiles and the filled background do together. AV1's curve is of finer qualities than the others', so its BD-rate is of those."""


def leak(results):
    found = results["sizes"][SIZES[0]]["h264"]
    pairs = zip(found["full"], found["cropped, flat"])
    return float(np.mean([b["psnr_foreground_db"] - a["psnr_foreground_db"] for a, b in pairs]))


def defaults(results):
    rates = results["bd_rate_percent"][SIZES[0]]

    def said(codec):
        return ", ".join(f"{m} {percent(r)}" for m, r in rates[codec].items())

    return [
        ("fvvmux --codec", "h264", "; ".join(f"{NAMES[c]} {percent(min(v for v in m.values() if v is not None))}" for c, m in rates.items() if c != "jpeg")
         + " against whole pictures in H.264, each with its best background; H.264 is what every browser decodes"),
        ("fvvmux --crop", "auto", f"H.264: {said('h264')}"),
        ("fvvmux --tile-fill", "auto: flat, smooth for AV1", f"H.264: {said('h264')}; AV1: {said('av1')}"),
        ("guard band", "4 px", f"foreground of H.264 {leak(results):+.2f} dB against whole pictures at the same number: the most that it lets through"),
    ]  # fmt: skip


def percent(value):
    return "-" if value is None else f"{value:+.0f} %"


EXPERIMENTS = (
    experiment.Experiment(
        "texture", "Pictures: codecs and cropping", measure, draw, text, headlines, defaults
    ),
)
