"""fvvrender: pictures of a generated scene against those of its cameras, and the command line."""

import hashlib
import json

import numpy as np
import pytest
from conftest import figures, read_json, run
from pictures import read_exr
from PIL import Image
from real_capture import luma

CAMERAS = 10
UNLIKE = 0.6  # stops


def drawn(stream, out, *arguments):
    return figures("fvvrender", stream, "-o", out, *arguments)


@pytest.fixture(scope="module")
def scene(tmp_path_factory):
    """Two frames of the small rig, with exact meshes and pictures of high quality: folder of the capture, stream."""
    root = tmp_path_factory.mktemp("render")
    size = ["--cameras", CAMERAS, "--size", "320x180"]
    run("fvvsynth", "-o", root / "capture", "--rig", "small", "--frames", 2, "--depth", *size)
    stream = root / "scene.fvv"
    run("fvvmux", root / "capture", "-o", stream, "--codec", "h264", "--quality", 10, "--keep-geometry")
    return root / "capture", stream


def psnr(a, b, mask):
    return 10 * np.log10(255**2 / ((a - b)[mask] ** 2).mean())


def truth(capture, camera, frame, name="cam"):
    """Luma, and the silhouette without its outline, whose pixels show background too."""
    folder = capture / f"{name}{camera}"
    mask = np.asarray(Image.open(folder / f"mask_{frame:04d}.png").convert("L")) > 127
    core = mask.copy()
    for axis in 0, 1:
        for shift in -1, 1:
            core &= np.roll(mask, shift, axis)
    return luma(folder / f"{frame:04d}.png"), core


def test_a_camera_drawn_from_itself_gives_its_picture(scene, tmp_path):
    capture, stream = scene
    for frame in 0, 1:
        out = tmp_path / f"{frame}.png"
        reported = drawn(stream, out, "--frame", frame, "--camera", 4, "--sources", 4)
        picture, core = truth(capture, 4, frame)
        assert (reported["width"], reported["height"]) == (320, 180)
        assert reported["sources"] == [4]
        seen = core & (np.asarray(Image.open(out).convert("RGB")) != 128).any(2)  # grey: grazing faces
        assert seen.sum() > 0.75 * core.sum()
        # The same pixels, except for the codec and the lattice.
        assert psnr(luma(out), picture, seen) > 34


def test_pictures_from_the_other_cameras_are_like_that_of_the_one_left_out(scene, tmp_path):
    capture, stream = scene
    found = []
    for camera in range(CAMERAS):
        out = tmp_path / f"{camera}.png"
        reported = drawn(stream, out, "--camera", camera, "--leave-one-out", "--samples", 3)
        assert reported["sources"] == [c for c in range(CAMERAS) if c != camera]
        picture, core = truth(capture, camera, 0)
        seen = core & (np.asarray(Image.open(out).convert("RGB")) != 128).any(2)
        assert seen.sum() > 0.9 * core.sum()
        found.append(psnr(luma(out), picture, seen))
        assert found[-1] > 20
    assert np.mean(found) > 24


def test_floats_are_depth_weights_and_visibility(scene, tmp_path):
    capture, stream = scene
    names = [tmp_path / f"{name}.exr" for name in ("depth", "weights", "visibility", "colour")]
    reported = drawn(stream, tmp_path / "a.png", "--camera", 2, "--depth", names[0], "--weights", names[1],
                    "--visibility", names[2], "--mask", tmp_path / "mask.png")  # fmt: skip
    drawn(stream, names[3], "--camera", 2)
    depth, weights, visibility, colour = (read_exr(name) for name in names)
    depth, surface = depth["Z"], np.isfinite(depth["Z"])
    assert surface.sum() == reported["surface"]["pixels"]
    assert ((np.asarray(Image.open(tmp_path / "mask.png")) > 0) == surface).all()
    # fvvsynth knows the depth; the lattice moves the surface, and its outline by less than a pixel.
    exact = read_exr(next((capture / "cam2").glob("depth*0000.exr")))["Z"]
    both = surface & np.isfinite(exact)
    assert both.sum() > 0.97 * surface.sum()
    assert np.median(np.abs(depth[both] - exact[both])) < 0.002

    assert set(weights) == set(visibility) == {f"camera.{i}" for i in range(CAMERAS)}
    weights = np.array([weights[f"camera.{i}"] for i in range(CAMERAS)])
    visibility = np.array([visibility[f"camera.{i}"] for i in range(CAMERAS)])
    used = (weights > 0).sum(0)
    assert used.max() == 3
    assert np.allclose(weights.sum(0)[used > 0], 1, atol=1e-6)
    assert (visibility[weights > 0] == 1).all()
    assert set(np.unique(visibility)) == {0, 1}
    shares = [(used[surface] == n).mean() for n in range(4)]
    assert np.allclose(shares, reported["share_by_cameras"], atol=1e-9)
    # A camera sees all surface in its own view except what is turned away too far.
    assert 0.75 < visibility[2][surface].mean() < 1

    codes = np.asarray(Image.open(tmp_path / "a.png").convert("RGB"), float) / 255
    light = np.where(codes <= 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    assert np.abs(light - np.stack([colour[c] for c in "RGB"], 2)).max() < 0.005


def test_bits_and_depth_maps_and_rays_nearly_agree(scene, tmp_path):
    _, stream = scene
    pictures = {}
    for how in "bits", "depth", "rays":
        path = tmp_path / f"{how}.exr"
        reported = drawn(
            stream, tmp_path / f"{how}.png", "--camera", 1, "--visible-by", how, "--visibility", path
        )
        assert reported["visible_by"] == how
        assert reported["with_bits"] == (list(range(CAMERAS)) if how == "bits" else [])
        pictures[how] = np.stack(list(read_exr(path).values()))
    for how in "bits", "depth":
        differ = (pictures[how] != pictures["rays"]).sum() / (pictures["rays"] > 0).sum()
        # Most at a cosine of less than 0.25: bits come from the faces around there, and maps have few samples.
        assert 0 < differ < 0.045, how
    # Bits are the default.
    assert drawn(stream, tmp_path / "default.png", "--camera", 1)["visible_by"] == "bits"
    assert (tmp_path / "default.png").read_bytes() == (tmp_path / "bits.png").read_bytes()


def test_without_bits_there_are_depth_maps(scene, tmp_path):
    capture, _ = scene
    stream, out = tmp_path / "s.fvv", tmp_path / "out.png"
    mux = ["fvvmux", capture, "-o", stream, "--codec", "jpeg", "--scale", "0.5", "--force", "--frames", "0-0"]
    run(*mux, "--visibility", "none")
    assert drawn(stream, out, "--camera", 1)["visible_by"] == "depth"
    done = run("fvvrender", stream, "-o", out, "--camera", 1, "--visible-by", "bits", "--force", code=1)
    assert "there are no bits of these cameras" in done.stderr
    # The same with weights; depth maps replace damaged ones.
    run(*mux, "--visibility", "weight")
    assert drawn(stream, out, "--camera", 1, "--force")["visible_by"] == "bits"
    damaged = bytearray(stream.read_bytes())
    damaged[damaged.index(b"VISI") + 80] ^= 1
    stream.write_bytes(damaged)
    done = run("fvvrender", stream, "-o", out, "--camera", 1, "--force", "--json", code=3)
    assert "no visibility of track 5, depth maps take its place" in done.stderr
    assert read_json(done, "fvvrender")["visible_by"] == "depth"


def test_any_number_of_threads_gives_the_same_files(scene, tmp_path):
    _, stream = scene
    digests = set()
    for threads in 1, 2, 5:
        out, weights = tmp_path / f"{threads}.png", tmp_path / f"{threads}.exr"
        drawn(stream, out, "--camera", 0, "--threads", threads, "--weights", weights)
        digests.add(tuple(hashlib.sha256(p.read_bytes()).hexdigest() for p in (out, weights)))
    assert len(digests) == 1


def test_a_pose_draws_what_the_camera_there_draws(scene, tmp_path):
    capture, stream = scene
    camera = json.loads((capture / "capture.json").read_text())["cameras"][3]
    rotation, translation = np.array(camera["rotation"]), np.array(camera["translation"])
    eye, up = -rotation.T @ translation, -rotation[1]
    intrinsics = camera["intrinsics"]
    pose = ",".join(f"{v:.9f}" for v in (*eye, *(eye + rotation[2]), *up))
    depths = [tmp_path / "camera.exr", tmp_path / "pose.exr"]
    drawn(stream, tmp_path / "a.png", "--camera", 3, "--depth", depths[0])
    drawn(stream, tmp_path / "b.png", "--pose", pose, "--focal", intrinsics["fx"], "--size", "320x180",
          "--depth", depths[1])  # fmt: skip
    by_camera, by_pose = (np.isfinite(read_exr(path)["Z"]) for path in depths)
    # Only the principal point differs, by a few pixels.
    dx, dy = round(intrinsics["cx"] - 160), round(intrinsics["cy"] - 90)
    moved = np.roll(by_pose, (dy, dx), (0, 1))
    assert (moved & by_camera).sum() > 0.93 * (moved | by_camera).sum() > 0


@pytest.mark.parametrize(
    "arguments, expected, text",
    [
        (["--camera", 99], 2, "--camera: camera 99 is not in the stream, which has 0, 1, 2"),
        (["--camera", 1, "--frame", 2], 2, "--frame: frame 2 is not in the stream, which has 2"),
        ([], 2, "expected one of --camera and --pose, found neither"),
        (["--camera", 1, "--pose", "0,0,0,1,1,1"], 2, "found both"),
        (["--pose", "0,0,0,1,1,1,0"], 2, "expected 6 numbers, eye and target, or 9 with up, found 7"),
        (["--pose", "1,1,1,1,1,1"], 2, "eye and target are the same point"),
        (["--pose", "0,0,0,0,1,0"], 2, "up points along the line of sight"),
        (["--pose", "0,0,0,1,1,1", "--leave-one-out"], 2, "--leave-one-out: expected with --camera only"),
        (["--camera", 1, "--focal", 100], 2, "--focal: expected with --pose only"),
        (["--camera", 1, "--size", "0x10"], 2, "--size: expected sides of 1 to 16384, found 0x10"),
        (["--camera", 1, "--depth", "d.png"], 2, "--depth: expected a name that ends in .exr, found d.png"),
        (["--camera", 1, "--sources", "1", "--exclude", "1"], 1, "no camera is left to take texture from"),
        (["--camera", 1, "--exclude", "77"], 2, "--exclude: camera 77 is not in the stream"),
        (["--camera", 1, "--background", "0,0,256"], 2, "--background: expected three numbers from 0 to 255"),
        (["--camera", 1, "--samples", 2], 2, "--samples"),
    ],
)
def test_mistakes_are_named_and_nothing_is_written(scene, tmp_path, arguments, expected, text):
    _, stream = scene
    done = run("fvvrender", stream, "-o", tmp_path / "out.png", *arguments, code=expected)
    assert text in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_an_existing_picture_is_kept_unless_forced(scene, tmp_path):
    _, stream = scene
    out = tmp_path / "out.png"
    out.write_text("mine")
    assert "exists" in run("fvvrender", stream, "-o", out, "--camera", 1, code=1).stderr
    assert out.read_text() == "mine"
    drawn(stream, out, "--camera", 1, "--force")
    assert out.read_bytes()[:4] == b"\x89PNG"


def test_what_is_damaged_is_named(scene, tmp_path):
    """A flipped byte in the video, then one in the mesh; with JPEG, frame 1 is whole without the pictures of frame 0."""
    capture, _ = scene
    stream, out = tmp_path / "s.fvv", tmp_path / "out.png"
    run("fvvmux", capture, "-o", stream, "--codec", "jpeg", "--keep-geometry")
    whole = stream.read_bytes()
    damaged = bytearray(whole)
    damaged[whole.index(b"\xff\xd8\xff") + 2000] ^= 1
    stream.write_bytes(damaged)
    done = run("fvvrender", stream, "-o", out, "--camera", 1, code=3)
    assert "frame 0: no picture of camera 3: " in done.stderr
    # What is left are the colours of vertices.
    drawn(stream, tmp_path / "bare.png", "--camera", 1, "--no-pictures")
    assert out.read_bytes() == (tmp_path / "bare.png").read_bytes()
    out.unlink()
    drawn(stream, out, "--camera", 1, "--frame", 1)
    assert out.read_bytes() != (tmp_path / "bare.png").read_bytes()
    out.unlink()
    damaged = bytearray(whole)
    damaged[whole.index(b"MESH") + 1000] ^= 1
    stream.write_bytes(damaged)
    assert "frame 0: " in run("fvvrender", stream, "-o", out, "--camera", 1, code=1).stderr
    assert not out.exists()


def test_faces_that_are_inside_out_are_warned_of(tmp_path):
    """A tetrahedron, wound both ways: warned of once, textured once."""
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]
    faces = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]
    Image.new("RGB", (64, 64), (200, 0, 0)).save(tmp_path / "0000.png")
    camera = {"id": 0, "width": 64, "height": 64, "pictures": "%04d.png",
              "intrinsics": {"fx": 60, "fy": 60, "cx": 32, "cy": 32}, "lens": {"model": "none", "coefficients": []},
              "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [-0.3, -0.3, 4]}  # fmt: skip
    document = {"fvv_capture": 1, "frame_rate": 25, "frames": {"first": 0, "count": 1}, "units": "metres",
                "meshes": {"pattern": "%04d.obj"}, "cameras": [camera]}  # fmt: skip
    (tmp_path / "capture.json").write_text(json.dumps(document))
    for order in 1, -1:
        lines = ["v {} {} {}".format(*c) for c in corners]
        lines += ["f {} {} {}".format(*(i + 1 for i in f[::order])) for f in faces]
        (tmp_path / "0000.obj").write_text("\n".join(lines) + "\n")
        run("fvvmux", tmp_path, "-o", tmp_path / "t.fvv", "--keep-geometry", "--force", "--codec", "jpeg",
             "--winding", "keep")  # fmt: skip
        options = ["--camera", 0, "--json", "--force"]
        done = run("fvvrender", tmp_path / "t.fvv", "-o", tmp_path / "t.png", *options, warns=True)
        assert ("inside out" in done.stderr) == (order < 0)
        reported = read_json(done, "fvvrender")
        assert reported["surface"]["pixels"] > 50
        assert (reported["share_by_cameras"][0] > 0.9) == (order < 0)


# Texturing that a file carries (TEXR): from fvvmux to fvvinfo and fvvrender.

POSE = ("--pose", "1.5,1.6,3.2,0,1,0", "--size", "240x135")


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """The same two frames of a generated scene, without texturing constants and with all of them."""
    folder = tmp_path_factory.mktemp("texturing")
    size = ["--cameras", 3, "--frames", 2, "--size", "160x90"]
    run("fvvsynth", "-o", folder / "capture", "--rig", "small", *size)
    out = folder / "plain.fvv", folder / "explicit.fvv"
    options = ["--codec", "jpeg", "--quality", 85, "--max-error", 0.5]
    run("fvvmux", folder / "capture", "-o", out[0], *options, "--texture-inset", "off")
    explicit = ["--texture-threshold", 0.75, "--texture-best", 1, "--texture-unseen", "255,0,64",
            "--texture-depth-bias", 0, "--texture-depth-slope", 1.25, "--texture-blend", "paper",
            "--texture-inset", "20mm"]  # fmt: skip
    run("fvvmux", folder / "capture", "-o", out[1], *options, *explicit)
    return out


def test_fvvinfo_reports_the_constants(files):
    plain, explicit = (figures("fvvinfo", path)["files"][0] for path in files)
    assert "texturing" not in plain
    assert explicit["texturing"] == {
        "threshold": 0.75, "best": 1, "unseen": [255, 0, 64], "blend": "paper", "depth_bias": 0,
        "depth_slope": 1.25, "inset": 0.02
    }  # fmt: skip
    assert (
        "by the normal (paper), cosines from 0.75, 1 cameras at most, 255,0,64"
        in run("fvvinfo", files[1]).stdout
    )
    assert "looked up 20 mm inside the mesh" in run("fvvinfo", files[1]).stdout


def test_fvvrender_uses_the_constants_of_the_file(files, tmp_path):
    options = (
        "--blend",
        "paper",
        "--threshold",
        0.75,
        "--best",
        1,
        "--unseen",
        "255,0,64",
        "--inset",
        0.02,
        "--visible-by",
        "rays",
    )
    pictures = []
    for number, arguments in enumerate([(files[0],), (files[0], *options), (files[1], "--visible-by", "rays"),
                                        (files[1], "--unseen", "0,255,0", "--visible-by", "rays")]):  # fmt: skip
        out = tmp_path / f"{number}.png"
        run("fvvrender", *arguments, "--no-environment", *POSE, "-o", out)
        pictures.append(np.asarray(Image.open(out)).astype(int))
    plain, requested, explicit, other = pictures
    assert (requested == explicit).all()
    unseen = (explicit == [255, 0, 64]).all(axis=2)
    assert unseen.sum() > 200
    assert not (plain == [255, 0, 64]).all(axis=2).any()
    assert (other[unseen] == [0, 255, 0]).all()


def test_tolerances_of_depth_maps_reach_the_renderer(files, tmp_path):
    """With a bias that lets everything be seen, cameras colour what they do not see, unless rays decide."""
    capture = files[0].parent / "capture"
    explicit = tmp_path / "explicit.fvv"
    run("fvvmux", capture, "-o", explicit, "--codec", "jpeg", "--quality", 85, "--max-error", 0.5,
         "--texture-depth-bias", 10000, "--texture-inset", "off")  # fmt: skip
    differing = {}
    for by in "depth", "rays":
        pictures = []
        for number, path in enumerate((files[0], explicit)):
            out = tmp_path / f"{by}{number}.png"
            run("fvvrender", path, "--no-environment", "--visible-by", by, *POSE, "-o", out)
            pictures.append(np.asarray(Image.open(out)).astype(int))
        differing[by] = (np.abs(pictures[0] - pictures[1]).max(axis=2) > 8).sum()
    assert differing["depth"] > 100 and differing["rays"] == 0


@pytest.mark.parametrize("bad", ["1,2", "1,2,256", "red", "1,2,3,4", "-1,2,3"])
def test_a_malformed_colour_is_refused(files, tmp_path, bad):
    capture = files[0].parent / "capture"
    done = run("fvvmux", capture, "-o", tmp_path / "x.fvv", f"--texture-unseen={bad}", code=2)
    assert "--texture-unseen" in done.stderr


@pytest.fixture(scope="module")
def rigs(tmp_path_factory):
    """The same scene filmed by equal cameras, a degree apart, and by cameras that differ in exposure and white balance."""
    root = tmp_path_factory.mktemp("match")
    for stops in 0, UNLIKE:
        run("fvvsynth", "-o", root / str(stops), "--rig", "arc", "--cameras", CAMERAS, "--frames", 1,
            "--exposure", stops)  # fmt: skip
    return root


def matched(capture, out, *arguments):
    return figures("fvvmux", capture, "-o", out, "--keep-geometry", "--force", *arguments)["match_colours"]


def left_out_error(capture, stream, root):
    """Median difference, of 255, between pictures drawn for cameras that are left out and those of the equal cameras, but for
    what all of them are too bright or too dark in a channel. Errors at edges are large and have other causes."""
    pairs = []
    for camera in 1, 4, 8:
        out = root / "view.png"
        drawn(stream, out, "--camera", camera, "--leave-one-out", "--best", 1, "--force")
        core = truth(capture, camera, 0, "view")[1]
        views = (Image.open(path).convert("RGB") for path in (capture / f"view{camera}/0000.png", out))
        pairs.append([np.asarray(view).astype(float)[core] for view in views])
    wanted, found = (np.concatenate(parts) for parts in zip(*pairs))
    return np.median(abs(found * (np.median(wanted, 0) / np.median(found, 0)) - wanted))


def test_unlike_cameras_are_matched_and_equal_ones_are_left_alone(rigs, tmp_path):
    equal, unlike, stream = rigs / "0", rigs / str(UNLIKE), tmp_path / "a.fvv"
    fine = "--codec", "jpeg", "--quality", 95
    untouched = matched(equal, stream, *fine)
    assert not untouched["applied"] and untouched["difference"] < 0.02
    assert all(abs(gain - 1) < 0.04 for camera in untouched["cameras"] for gain in camera["gains"])
    least = left_out_error(equal, stream, tmp_path)
    off = matched(unlike, stream, *fine, "--match-colours", "off")
    assert off == {"applied": False, "reason": "--match-colours off"}
    worst = left_out_error(equal, stream, tmp_path)
    applied = matched(unlike, stream, *fine)
    assert applied["applied"] and applied["difference"] > 0.1 > 10 * applied["difference_left"]
    assert all(camera["matched"] for camera in applied["cameras"])
    found = left_out_error(equal, stream, tmp_path)
    assert worst > 1.5 * least, (least, found, worst)
    # At least nine tenths of what unlike cameras cost.
    assert found - least < 0.1 * (worst - least), (least, found, worst)
    matched(unlike, stream, "--codec", "vp9", "--bit-depth", 10, "--quality", 4)
    assert left_out_error(equal, stream, tmp_path) - least < 0.1 * (worst - least)


def test_what_is_read_back_is_compared_with_the_matched_pictures(rigs, tmp_path):
    stream = tmp_path / "a.fvv"
    summary = figures("fvvmux", rigs / str(UNLIKE), "-o", stream, "--quality", "40dB", "--verify")
    assert summary["match_colours"]["applied"] and summary["verified"]["psnr"] > 39
    text = run("fvvmux", rigs / str(UNLIKE), "-o", stream, "--quality", "40dB", "--force").stdout
    assert "colours of cameras: two cameras differ by" in text and "camera 3: gains" in text


@pytest.mark.parametrize(
    "arguments, reason",
    [
        (["--no-meshes"], "there are no meshes"),
        (["--cameras", "3"], "there are no two cameras with pictures"),
        (["--codec", "exr"], "pictures in OpenEXR stay as they are"),
    ],
)
def test_what_cannot_be_matched_is_named(rigs, tmp_path, arguments, reason):
    out = ["-o", tmp_path / "a.fvv", "--force"]
    summary = figures("fvvmux", rigs / "0", *out, *arguments)
    assert summary["match_colours"] == {"applied": False, "reason": reason}
    assert reason in run("fvvmux", rigs / "0", *out, "--match-colours", "on", *arguments, code=2).stderr


# The surface that cameras show, inside the mesh.


def squares(capture, stream, out, *arguments):
    """The sum of squared errors of luma of three cameras that are drawn from the others."""
    total = 0
    for camera in 1, 4, 6:
        drawn(stream, out, "--camera", camera, "--leave-one-out", "--force", *arguments)
        wanted, core = truth(capture, camera, 0)
        total += ((luma(out) - wanted)[core] ** 2).sum()
    return total


def test_the_inset_of_a_hull_is_found_and_improves_other_views(tmp_path):
    capture, stream, out = (tmp_path / name for name in ("hull", "a.fvv", "view.png"))
    run("fvvsynth", "-o", capture, "--rig", "small", "--cameras", 8, "--frames", 1, "--meshes", "hull",
        "--size", "640x360")  # fmt: skip
    options = ["--codec", "jpeg", "--quality", 95, "--keep-geometry"]
    found = figures("fvvmux", capture, "-o", stream, *options)["texture_inset"]
    assert found["cameras"] == 8 and found["better"] >= 5 and found["frame"] == 0
    assert 0.0005 < found["length"] < 0.02
    assert found["psnr_best"] > found["psnr_without"] + 0.05
    info = figures("fvvinfo", stream)["files"][0]["texturing"]
    assert info["inset"] == found["length"] and info["best"] == 3 and info["blend"] == "viewer"
    by_stream, without, far = (
        squares(capture, stream, out, *inset) for inset in ((), ("--inset", 0), ("--inset", 0.03))
    )
    assert by_stream < 0.99 * without < without < far
    text = run("fvvmux", capture, "-o", stream, *options, "--force").stdout
    assert "mm: cameras drawn from the others have" in text


@pytest.mark.parametrize(
    "arguments, length, reason",
    [
        (["--texture-inset", "off"], 0, "--texture-inset"),
        (["--texture-inset", "3mm"], 0.003, "--texture-inset"),
        (["--no-meshes"], 0, "there are no meshes"),
        (["--cameras", "3"], 0, "there are no two cameras with pictures"),
        (["--texture-blend", "paper"], 0, "the paper's method has none"),
    ],
)
def test_an_inset_may_be_given_or_needs_what_it_is_found_by(rigs, tmp_path, arguments, length, reason):
    summary = figures("fvvmux", rigs / "0", "-o", tmp_path / "a.fvv", *arguments)
    assert summary["texture_inset"] == {"length": length, "reason": reason}


def test_exact_meshes_have_no_inset(rigs, tmp_path):
    """Nothing is sent then, where no threshold is chosen either."""
    summary = figures("fvvmux", rigs / "0", "-o", tmp_path / "a.fvv", "--view-loss", "none")
    assert summary["texture_inset"]["length"] == 0 and summary["texture_inset"]["cameras"] == CAMERAS
    assert "texturing" not in figures("fvvinfo", tmp_path / "a.fvv")["files"][0]


@pytest.mark.parametrize("bad", ["3px", "-1mm", "none", "0"])
def test_a_malformed_inset_is_refused(rigs, tmp_path, bad):
    done = run("fvvmux", rigs / "0", "-o", tmp_path / "x.fvv", f"--texture-inset={bad}", code=2)
    assert "--texture-inset: expected auto, off or a length above 0 such as 3mm" in done.stderr


def test_a_rung_is_drawn_and_unpacked_as_if_the_stream_had_no_other(scene, tmp_path):
    capture, _ = scene
    stream, parts = tmp_path / "ladder.fvv", tmp_path / "parts"
    packed = figures(
        "fvvmux", capture, "-o", stream, "--ladder", "1,0.7,0.3", "--mesh-ladder", "on", "--segments", parts
    )
    rungs = json.loads((parts / "manifest.json").read_text())["rungs"]
    assert not set.intersection(*(set(rung["tracks"]) for rung in rungs))
    triangles, seen = [], set()
    for number, rung in enumerate(rungs):
        alone = tmp_path / f"{number}.fvv"
        alone.write_bytes(
            b"".join(
                (parts / entry["file"]).read_bytes() for entry in [rung["configuration"], *rung["groups"]]
            )
        )
        results = []
        for path, option in (stream, ["--rung", number]), (alone, []):
            out = tmp_path / f"{path.stem}-{number}"
            drawn(path, f"{out}.png", "--pose", "1.5,1.6,3.2,0,1,0", "--frame", 1, *option)
            run("fvvdemux", path, "-o", out, *option, code=0 if option else 3, warns=True)  # alone: no index
            results.append(
                [(tmp_path / f"{out.name}.png").read_bytes(), (out / "meshes/0001.ply").read_bytes()]
            )
        assert results[0] == results[1]
        seen.update(results[0])
        triangles.append(packed["ladder"][number]["meshes"]["triangles"])
    assert len(seen) == 6 and triangles == sorted(triangles, reverse=True)
