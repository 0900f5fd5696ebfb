"""What fvvmux saves by its default goal, --view-loss 0.1dB, against 42 dB and 0.15 pixels, and what is lost in views from places without a camera of the stream.

The sets are the clip of the paper's shape (hulls, 7 cameras at 480x270), the same scene with exact meshes by the rig small, and the first two seconds of the demo's
game (13 cameras, scale 0.75, flat tiles). The truth is filmed by fvvsynth --rig arc, as in the charts: PSNR inside silhouettes, of
five frames and two places. The frame of wd2_human20, where FVV_DATA has it, counts by bytes and by cameras that are drawn from the others. Time is processor time of 250 frames of the
small rig: what the choice takes, beside a stream for which options set the same.

./run bench spend prints the figures.
"""

import view_quality
from charts import experiment, views
from muxing import DEMO_OPTIONS

GOAL = "--view-loss", "0.1dB"  # the default
FRAMES = 50
LOOKED_AT = 4, 14, 24, 34, 44
PLACES = 13, 26  # degrees along the arc
GAME = "--scene", "game"
LONG = 250  # frames


def sets(clip_arguments):
    """Of each set arguments of fvvmux, and the arc that films the same."""
    practice = views.Arc(FRAMES, PLACES)
    game = views.Arc(FRAMES, PLACES, scene="game")
    small = experiment.capture("spend-small", "--rig", "small", "--frames", FRAMES)
    court = experiment.capture("spend-game", *GAME, "--frames", FRAMES, "--pictures", "jpeg", "--environment")
    return {
        "clip": (*clip_arguments, practice),
        "tracked": (small, practice),
        "game": (court, *DEMO_OPTIONS, game),
    }


def measure(clip_arguments):
    """clip_arguments: of fvvmux, the capture first, without a quality."""
    figures, losses = {}, []
    print(f"{'set':10}{'bytes':>10}{'chosen':>10}{'PSNR dB':>9}{'chosen':>9}{'SSIM':>8}{'chosen':>8}  what")
    for name, (capture, *options, arc) in sets(clip_arguments).items():
        before = experiment.packed(capture, *options)
        after = experiment.packed(capture, *options, *GOAL)
        seen = [views.measure(one.path, arc, frames=LOOKED_AT) for one in (before, after)]
        bytes_of = [one.summary["bytes"] for one in (before, after)]
        figures[f"spend.{name}_saving_percent"] = 100 * (1 - bytes_of[1] / bytes_of[0])
        losses.append(seen[0]["psnr_inside_db"] - seen[1]["psnr_inside_db"])
        if name == "clip":
            figures["spend.clip_bytes_at_equal_view"] = bytes_of[1]
        found = after.summary["view_loss"]
        print(
            f"{name:10}{bytes_of[0]:10}{bytes_of[1]:10}"
            + "".join(f"{one['psnr_inside_db']:9.2f}" for one in seen)
            + "".join(f"{one['ssim_inside']:8.4f}" for one in seen)
            + f"  {found['picture_psnr']:g} dB, {found['max_error']:g} px, {found['blend']} {found['threshold']:g}, best {found['best']}",
            flush=True,
        )
    figures["spend.worst_loss_db"] = max(losses)
    if real := view_quality.wd2_capture():
        before, after = (experiment.packed(real.parent, *view_quality.WINDING, *goal) for goal in ((), GOAL))
        bytes_of = [one.summary["bytes"] for one in (before, after)]
        figures["spend.wd2_saving_percent"] = 100 * (1 - bytes_of[1] / bytes_of[0])
        found = after.summary["view_loss"]
        print(
            f"{'wd2':10}{bytes_of[0]:10}{bytes_of[1]:10}"
            + "".join(f"{found[one]['psnr']:9.2f}" for one in ("without", "chosen"))
        )
    long = experiment.capture("spend-long", "--rig", "small", "--frames", LONG)
    without, chosen = experiment.packed(long), experiment.packed(long, *GOAL)
    found = chosen.summary["view_loss"]
    texturing = ("--texture-threshold", found["threshold"], "--texture-best", found["best"])
    surface = ("--max-error", found["max_error"], "--step", f"{found['step']}m")
    weights = "weight" if chosen.summary["visibility"].get("bytes") else "none"
    given = experiment.packed(
        long, "--quality", f"{found['picture_psnr']}dB", *surface, "--visibility", weights, *texturing
    )
    # Against the same options: finer meshes take longer to encode, however they were chosen.
    figures["spend.time_over_without"] = (chosen.seconds - given.seconds) / without.seconds
    print(
        f"{LONG} frames: {without.seconds:.1f} s, chosen {chosen.seconds:.1f} s, given {given.seconds:.1f} s"
    )
    return figures
