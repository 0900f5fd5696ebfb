"""The presets: what each leaves out and measures, what options over them do, and that all of them give whole streams."""

import functools

import pytest
from conftest import figures, run

PRESETS = "live", "fast", "medium", "slow"
FEW = "--frames", "0-2"
pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def clips(tmp_path_factory):
    folder = tmp_path_factory.mktemp("clips")
    small = "--rig", "small", "--cameras", 4, "--size", "320x180", "--frames", 6
    for meshes in "tracked", "hull":
        run("fvvsynth", *small, "--meshes", meshes, "-o", folder / meshes)

    @functools.lru_cache(None)
    def packed(meshes, *options):
        fixed = "--view-loss", "none"  # which presets choose by views is for test_view_loss.py
        return figures(
            "fvvmux", folder / meshes, "-o", folder / "o.fvv", "--force", "--verify", *fixed, *options
        )

    packed.folder = folder
    return packed


@pytest.mark.parametrize("meshes", ["tracked", "hull"])
@pytest.mark.parametrize("preset", PRESETS)
def test_every_preset_reaches_the_quality_and_is_verified(clips, meshes, preset):
    is_tracked = meshes == "hull" and preset == "slow"  # takes two seconds a frame
    found = clips(meshes, "--preset", preset, *(FEW if is_tracked else ()))
    frames = 3 if is_tracked else 6
    assert found["preset"] == preset
    assert found["verified"]["meshes"] == frames
    assert found["verified"]["psnr"] > 41.7
    # What was measured is within the budget, and the report says how much was.
    budget = found["budget"]
    changed = budget["decimated_frames"]
    assert changed == frames
    if preset == "live":
        assert budget["measured_frames"] == 0 and budget["rms"] is None and budget["max_pixels"] is None
    elif is_tracked:
        assert found["mesh"]["tracking"]["by_outlines"] > 0  # the hull's own flicker is no error
    else:
        assert budget["rms_pixels"] <= 0.15
        few = preset == "fast" and meshes == "tracked"
        assert budget["measured_frames"] == (3 if few else changed)
        assert budget["max_pixels"] <= (2.7 if preset == "fast" else 0.9)


def test_medium_is_the_default(clips):
    assert clips("tracked")["preset"] == "medium"
    assert clips("tracked")["bytes"] == clips("tracked", "--preset", "medium")["bytes"]


def test_what_a_preset_leaves_out_is_said(clips):
    for preset in "live", "fast":
        found = clips("tracked", "--preset", preset)
        for what in "visibility", "colours":
            assert "bytes" not in found[what]
            assert found[what]["reason"] == f"as --preset {preset} has it"
    assert clips("tracked")["visibility"]["bytes"] > 0
    message = run(
        "fvvmux", clips.folder / "hull", "-o", clips.folder / "o.fvv", "--force", "--preset", "live"
    )
    assert "6 of 6 frames were not measured, as --preset live has it" in message.stdout


def test_options_hold_over_a_preset(clips):
    found = clips(
        "tracked", "--preset", "live", "--visibility", "weight", "--colours", "on", "--mesh-level", 8
    )
    assert found["visibility"]["bytes"] > 0 and found["colours"]["bytes"] > 0
    assert found["mesh"]["level"] == 8
    assert "tracking" not in clips("hull", "--preset", "slow", "--track", "never", *FEW)["mesh"]
    kept = clips("hull", "--preset", "live", "--keep-geometry")
    assert kept["budget"]["decimated_frames"] == 0


def test_slow_takes_no_more_bytes_than_medium_and_live_not_many_more(clips):
    for meshes in "tracked", "hull":
        medium = clips(meshes, *FEW)["bytes"]
        assert clips(meshes, "--preset", "slow", *FEW)["bytes"] <= medium
        assert clips(meshes, "--preset", "live", *FEW)["bytes"] <= 1.25 * medium
    assert clips("hull", "--preset", "slow", *FEW)["mesh"]["tracking"]["on"]


@pytest.mark.parametrize("preset", ["live", "fast"])
def test_no_piece_of_a_mesh_vanishes_unmeasured(clips, preset):
    """The simplifier alone takes small pieces away, which only a thorough measurement would notice."""
    assert clips("hull", "--preset", preset)["budget"]["vanished_pieces"] == 0


@pytest.mark.parametrize("codec", ["hevc", "vp9", "av1"])
def test_presets_of_other_codecs(clips, codec):
    options = "--codec", codec, "--quality", 20, "--no-meshes", "--frames", "0-2"
    sizes = [clips("tracked", "--preset", preset, *options)["bytes"] for preset in ("live", "medium")]
    assert sizes[0] != sizes[1]


def test_an_unknown_preset_is_named(clips, tmp_path):
    done = run("fvvmux", clips.folder / "hull", "-o", tmp_path / "o.fvv", "--preset", "ultra", code=2)
    assert "live" in done.stderr and "ultra" in done.stderr
