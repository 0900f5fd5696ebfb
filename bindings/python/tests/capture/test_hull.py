"""Hulls of generated scenes against their masks and meshes, and of real ones against their masks."""

import json
import struct
import sys

import fvv
import numpy as np
import pytest
import trimesh
from conftest import ROOT, tool
from fvv_capture import hull
from fvv_capture.cameras import read_calibration, recognise
from PIL import Image

sys.path.append(str(ROOT / "bench"))
from recordings import hull as recordings  # noqa: E402

GROUND = ((0, 1, 0), 0.0)


def data(name):
    if not (recordings.DATA / name).exists():
        pytest.skip(f"{name}: not on this machine (FVV_DATA)")


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    """A folder of fvvsynth, its cameras, and the masks of its first frame."""
    folder = tmp_path_factory.mktemp("clip") / "capture"
    tool("fvvsynth", "-o", folder, "--rig", "small", "--size", "640x360", "--frames", 1)
    cameras = read_calibration(folder).cameras
    masks = [np.asarray(Image.open(folder / camera.name / "mask_0000.png")) for camera in cameras]
    return folder, cameras, masks


def options(**more):
    return hull.HullOptions(least_views=4, floor=GROUND, min_share=0.01, **more)


def is_closed(found):
    """Each directed edge has one face on either side."""
    edges = np.concatenate([found.indices[:, [a, (a + 1) % 3]] for a in range(3)]).astype(np.int64)
    forth = edges[:, 0] << 32 | edges[:, 1]
    back = edges[:, 1] << 32 | edges[:, 0]
    return len(np.unique(forth)) == len(forth) and np.array_equal(np.sort(forth), np.sort(back))


def test_the_generated_clip(clip):
    folder, cameras, masks = clip
    found = hull.carve(cameras, masks, options=options(cell=0.02))
    assert is_closed(found)
    assert 15000 < len(found.positions) < 30000
    ious = hull.silhouette_iou(found.positions, found.indices, cameras, masks)
    assert min(ious) >= 0.98
    assert found.positions[:, 1].min() > -0.002
    inside = found.grid.inside()
    volume = inside.sum() * found.grid.cell**3
    corners = found.positions[found.indices.astype(np.int64)]
    exact = np.einsum("ij,ij->i", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(exact, rel=0.03)
    truth = trimesh.load(folder / "meshes/0000.ply")
    assert truth.volume < exact < 2 * truth.volume
    # No vertex of the scene is farther outside the hull than a cell.
    place = np.rint((truth.vertices - found.grid.origin) / found.grid.cell).astype(int)
    around = np.zeros(len(place), bool)
    for step in np.ndindex(3, 3, 3):
        x, y, z = (place + np.array(step) - 1).T
        around |= inside[z, y, x]
    assert around.all()


def test_bounds_hold_the_scene(clip):
    _, cameras, masks = clip
    low, high = hull.bounds(cameras, masks, least_views=4, floor=GROUND)
    found = hull.carve(cameras, masks, (low - 1, high + 1), options(cell=0.04))
    assert (found.positions.min(0) > low - 0.05).all()
    assert (found.positions.max(0) < high + 0.05).all()
    assert (high - low < np.ptp(found.positions, axis=0) * 1.5 + 0.2).all()


def test_missed_silhouettes(clip):
    """A mask with a hole cuts a hole into the hull, unless one camera may be wrong."""
    _, cameras, masks = clip
    box = hull.bounds(cameras, masks, floor=GROUND, least_views=4)
    whole = hull.carve(cameras, masks, box, options(cell=0.03))
    rows, columns = np.nonzero(masks[0])
    cut = masks[0].copy()
    cut[: int(np.median(rows))] = 0
    strict = hull.carve(cameras, [cut, *masks[1:]], box, options(cell=0.03))
    lenient = hull.carve(cameras, [cut, *masks[1:]], box, options(cell=0.03, missed=1))
    count = whole.grid.inside().sum()
    assert strict.grid.inside().sum() < 0.75 * count
    assert lenient.grid.inside().sum() > 0.99 * count
    ious = hull.silhouette_iou(lenient.positions, lenient.indices, cameras[:1], masks[:1])
    assert ious[0] > 0.9


def test_cameras_without_a_mask(clip):
    _, cameras, masks = clip
    some = [None, *masks[1:]]
    found = hull.carve(cameras, some, options=options(cell=0.04))
    ious = hull.silhouette_iou(found.positions, found.indices, cameras, some)
    assert ious[0] is None
    assert min(ious[1:]) > 0.93


def test_smoothing_keeps_the_outlines(clip):
    _, cameras, masks = clip
    rough = hull.carve(cameras, masks, options=options(cell=0.02))
    smooth = hull.carve(cameras, masks, options=options(cell=0.02, smoothing=5))
    assert np.array_equal(rough.indices, smooth.indices)
    moved = np.linalg.norm(rough.positions - smooth.positions, axis=1)
    assert 0.0005 < moved.mean() < moved.max() <= 0.01 + 1e-9
    ious = [np.mean(hull.silhouette_iou(h.positions, h.indices, cameras, masks)) for h in (rough, smooth)]
    assert ious[1] > ious[0] - 0.005


def test_coverage(clip):
    _, cameras, masks = clip
    camera = cameras[0]
    # A square that is parallel to the picture, 2 m away, from the middle of the picture on.
    size = 0.5
    middle = camera.R.T @ np.array([0, 0, 2.0]) + camera.centre
    right, down = camera.R.T @ np.array([size, 0, 0]), camera.R.T @ np.array([0, size, 0])
    square = np.array([middle, middle + right, middle + right + down, middle + down])
    mask = hull.coverage(square, [[0, 1, 2], [0, 2, 3]], camera)
    assert mask.shape == (camera.height, camera.width) and mask.dtype == np.uint8
    u, v = camera.K[:2, 2]
    side = camera.K[0, 0] * size / 2
    rows, columns = np.nonzero(mask)
    assert abs(columns.min() - u) <= 1 and abs(rows.min() - v) <= 1
    assert len(rows) == pytest.approx(side * min(side, camera.height - v), rel=0.03)
    assert hull.silhouette_iou(square, [[0, 1, 2], [0, 2, 3]], [camera], [mask]) == [1.0]
    nothing = np.zeros((0, 3))
    assert not hull.coverage(nothing, nothing, camera).any()
    assert hull.silhouette_iou(nothing, nothing, [camera], [mask & 0]) == [None]


def test_the_grid_is_kept(clip, tmp_path):
    _, cameras, masks = clip
    found = hull.carve(cameras, masks, options=options(cell=0.05))
    found.grid.save(tmp_path / "grid.npz")
    loaded = hull.Grid(**np.load(tmp_path / "grid.npz"))
    assert tuple(loaded.counts) == found.grid.counts
    assert np.array_equal(loaded.inside(), found.grid.inside())
    point, axis = np.divmod(loaded.edges.astype(np.int64), 3)
    nx, ny, _ = loaded.counts
    place = np.stack([point % nx, point // nx % ny, point // (nx * ny)], 1).astype(float)
    place[np.arange(len(axis)), axis] += loaded.offsets
    assert np.abs(loaded.origin + loaded.cell * place - found.positions).max() < 1e-6
    # An edge of the surface leads from inside to outside or back.
    flat = loaded.inside().ravel()
    stride = np.array([1, nx, nx * ny])
    assert (flat[point] != flat[point + stride[axis]]).all()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"cell": 0}, "cell: expected a number above 0"),
        ({"cell": 1, "max_error": 1}, "cell: expected either"),
        ({"missed": -1}, "missed: expected 0 or more"),
        ({"least_views": 0}, "least_views: expected 1 or more"),
        ({"min_share": 2}, "min_share: expected 0 to 1"),
    ],
)
def test_wrong_options(wrong, message):
    with pytest.raises(fvv.UsageError, match=message):
        hull.HullOptions(**wrong)


def test_wrong_arguments(clip):
    _, cameras, masks = clip
    with pytest.raises(fvv.UsageError, match="masks: expected one for each of 7 cameras, found 6"):
        hull.carve(cameras, masks[1:])
    with pytest.raises(
        fvv.UsageError, match=r"masks\[1\]: expected 640 x 360 pixels as camera 1 has, found 10 x 20"
    ):
        hull.carve(cameras, [masks[0], np.zeros((20, 10), np.uint8), *masks[2:]])
    with pytest.raises(fvv.UsageError, match="cell: expected a grid of at most 1073741824 points"):
        hull.carve(cameras, masks, ([-1, 0, -1], [1, 2, 1]), hull.HullOptions(cell=0.001))
    with pytest.raises(fvv.UsageError, match="bounds: expected a lowest and a highest corner"):
        hull.carve(cameras, masks, ([1, 0, 0], [0, 1, 1]))
    with pytest.raises(fvv.UsageError, match="floor: expected a vector up"):
        hull.carve(cameras, masks, options=hull.HullOptions(floor=((0, 0, 0), 1)))
    empty = [np.zeros_like(mask) for mask in masks]
    with pytest.raises(fvv.Error, match="bounds: expected something in the silhouettes of 3 cameras"):
        hull.bounds(cameras, empty)
    nothing = hull.carve(cameras, empty, ([-1, 0, -1], [1, 2, 1]), hull.HullOptions(cell=0.1))
    assert nothing.indices.shape == (0, 3) and nothing.components == 0


def test_a_pixel_error_becomes_a_cell(clip):
    _, cameras, masks = clip
    box = hull.bounds(cameras, masks, least_views=4, floor=GROUND)
    found = hull.carve(cameras, masks, box, options(max_error=4))
    nearest = min(np.linalg.norm(np.clip(c.centre, *box) - c.centre) / c.K.max() for c in cameras)
    assert found.grid.cell == pytest.approx(4 * nearest, rel=0.01)


def test_wd2_human20():
    data("wd2_human20")
    cameras, masks = recordings.wd2_human20()
    found = hull.carve(cameras, masks, options=hull.HullOptions(cell=0.125))
    assert is_closed(found) and found.components == 1
    assert 15000 < len(found.positions) < 19000
    ious = hull.silhouette_iou(found.positions, found.indices, cameras, masks)
    print(f"mean {np.mean(ious):.4f}, min {min(ious):.4f}, {len(found.positions)} vertices")
    assert np.mean(ious) >= 0.955
    assert min(ious) >= 0.945


def test_middlebury_temple():
    data("middlebury_temple")
    cameras, masks, box = recordings.middlebury_temple()
    assert len(cameras) == 47
    found = hull.carve(cameras, masks, box, hull.HullOptions(cell=0.0008, missed=1, min_share=1))
    assert is_closed(found) and found.components == 1
    ious = hull.silhouette_iou(found.positions, found.indices, cameras, masks)
    print(f"mean {np.mean(ious):.4f}, min {min(ious):.4f}, {len(found.positions)} vertices")
    assert np.mean(ious) >= 0.90


def test_calibrations(clip, tmp_path):
    folder, cameras, _ = clip
    for path in (folder, folder / "capture.json", str(folder)):
        read = read_calibration(path)
        assert read.format == "fvv" and read.unit_known
        assert [c.name for c in read.cameras] == [c.name for c in cameras]
    assert read.up == "+y" and [entry["name"] for entry in read.entries] == [c.name for c in cameras]
    with pytest.raises(fvv.UsageError, match="has its own"):
        read_calibration(folder, units="millimetres")
    # Other units and another origin of pixels are converted.
    document = json.loads((folder / "capture.json").read_text())
    document["units"], document["conventions"] = "millimetres", {"pixel_centre": 0}
    for camera in document["cameras"]:
        camera["translation"] = [1000 * v for v in camera["translation"]]
        camera["intrinsics"]["cx"] -= 0.5
        camera["intrinsics"]["cy"] -= 0.5
    (tmp_path / "mm.json").write_text(json.dumps(document))
    converted = read_calibration(tmp_path / "mm.json").cameras
    for a, b in zip(converted, cameras, strict=True):
        assert np.allclose(a.t, b.t) and np.allclose(a.K, b.K)

    transforms = {
        "fl_x": 500, "fl_y": 500, "cx": 320, "cy": 180, "w": 640, "h": 360,
        "frames": [{"file_path": "a.png", "transform_matrix": [[1, 0, 0, 1], [0, -1, 0, 2], [0, 0, -1, 3], [0, 0, 0, 1]]}],
    }  # fmt: skip
    file = tmp_path / "anything.json"
    file.write_text(json.dumps(transforms))
    read = read_calibration(file)
    assert read.format == "nerfstudio" and not read.unit_known
    assert np.allclose(read.cameras[0].centre, [1, 2, 3]) and np.allclose(read.cameras[0].R, np.eye(3))
    read = read_calibration(file, units="millimetres")
    assert read.unit_known and np.allclose(read.cameras[0].centre, [0.001, 0.002, 0.003])
    assert read.cameras[0].name == "a.png" or read.cameras[0].name == "a"

    colmap = tmp_path / "sparse"
    colmap.mkdir()
    (colmap / "cameras.txt").write_text("1 PINHOLE 640 480 500 510 320 240\n")
    (colmap / "images.txt").write_text("1 1 0 0 0 0 0 4 1 left.png\n\n")
    read = read_calibration(colmap)
    assert read.format == "colmap" and np.allclose(read.cameras[0].centre, [0, 0, -4])
    assert recognise(tmp_path) == "colmap"  # a project with its model in sparse
    for name in ("cameras.txt", "images.txt"):
        (colmap / name).unlink()
    parameters = struct.pack("<QIiQQ4d", 1, 1, 1, 640, 480, 500, 510, 320, 240)
    (colmap / "cameras.bin").write_bytes(parameters)
    pose = struct.pack("<QI7dI", 1, 1, 1, 0, 0, 0, 0, 0, 5, 1)
    (colmap / "images.bin").write_bytes(pose + b"left.png\0" + struct.pack("<Q", 0))
    read = read_calibration(colmap)
    assert read.format == "colmap" and np.allclose(read.cameras[0].centre, [0, 0, -5])

    k = [[500, 0, 319.5], [0, 510, 239.5], [0, 0, 1]]
    krt = tmp_path / "KRT.txt"
    krt.write_text("".join(f"{a} {b} {c}\n" for a, b, c in k) + "1 0 0 0\n0 1 0 0\n0 0 1 6\n")
    read = read_calibration(krt, size=(640, 480))
    assert read.format == "krt" and np.allclose(read.cameras[0].K[:2, 2], [320, 240])
    assert np.allclose(read.cameras[0].centre, [0, 0, -6]) and read.cameras[0].name == "KRT"

    panoptic = tmp_path / "calibration.json"
    pose = {"R": np.eye(3).tolist(), "t": [[0], [0], [300]]}
    panoptic.write_text(
        json.dumps(
            {"calibDataSource": "a", "cameras": [{"name": "00_01", "resolution": [640, 480], "K": k, **pose}]}
        )
    )
    read = read_calibration(panoptic)
    assert read.format == "panoptic" and read.unit_known
    assert np.allclose(read.cameras[0].centre, [0, 0, -3])

    opencv = tmp_path / "opencv"
    opencv.mkdir()
    for name in ("a", "b"):
        (opencv / f"{name}.yml").write_text("%YAML:1.0\n---\n")
    assert recognise(opencv) == "opencv"
    with pytest.raises(fvv.Error, match="a.yml"):
        read_calibration(opencv)


@pytest.mark.parametrize(
    "name",
    [
        "easymocap",
        "kalibr",
        "metashape",
        "opencv_others",
        "panoptic_others",
        "realitycapture",
        "realitycapture_table",
        "toml",
    ],
)
def test_formats_are_recognised(name, tmp_path):
    sys.path.append(str(ROOT / "tests/tools"))
    import import_formats

    (format, path, *_), written = import_formats.WRITERS[name](tmp_path, np.random.default_rng(1))
    place = tmp_path if format == "opencv" else path
    if format != "panoptic":  # a list of cameras may be of many programs
        assert recognise(place) == format
    size = (
        (import_formats.WIDTH, import_formats.HEIGHT) if format in ("easymocap", "realitycapture") else None
    )
    read = read_calibration(place, format=format, size=size).cameras
    assert [camera.name for camera in read] == [name for _, name, *_ in written]
    for camera, (_, _, one, _) in zip(read, written):
        assert np.allclose(camera.centre, one.centre())


def test_wrong_calibrations(clip, tmp_path):
    folder, _, _ = clip
    text = tmp_path / "notes.txt"
    text.write_text("nothing\nof interest\n")
    with pytest.raises(fvv.Error, match="notes.txt: expected a calibration of fvv, colmap"):
        read_calibration(text)
    with pytest.raises(fvv.Error, match="No such file"):
        read_calibration(tmp_path / "none.json")
    with pytest.raises(fvv.Error, match="found none"):
        read_calibration(tmp_path)
    with pytest.raises(fvv.UsageError, match="format: expected"):
        read_calibration(text, format="maya")
    with pytest.raises(fvv.UsageError, match="units: expected"):
        read_calibration(folder, units="leagues")
    with pytest.raises(fvv.UsageError, match="size: expected width and height"):
        read_calibration(text, format="middlebury")
    with pytest.raises(
        fvv.UsageError, match="size: expected for middlebury, krt, realitycapture, easymocap only"
    ):
        read_calibration(folder, size=(640, 480))
