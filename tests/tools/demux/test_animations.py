"""fvvdemux --meshes gltf and --compress: what other decoders find is what the stream has."""

import base64
import json
import shutil
import struct
import subprocess

import DracoPy
import numpy as np
import pytest
import trimesh
from conftest import ROOT, figures, run
from PIL import Image

STEP = 0.001
FRAME = 1001 / 30000  # seconds
COMPONENTS = {5122: np.int16, 5123: np.uint16, 5125: np.uint32, 5126: np.float32}
CHECKER = ROOT / "js/testing/gltf.mjs"
needs_node = pytest.mark.skipif(
    not shutil.which("node") or not (ROOT / "js/node_modules/gltf-validator").exists(),
    reason="needs node, and npm ci in js",
)


def surface(frame, side, turned=False):
    """A waving surface of side x side squares as OBJ; turned: split along their other diagonal."""
    u, v = (a.ravel() / side for a in np.meshgrid(range(side + 1), range(side + 1)))
    height = 0.2 * np.sin(4 * u + 0.3 * frame) * np.cos(3 * v)
    slope = np.stack([-0.8 * np.cos(4 * u + 0.3 * frame) * np.cos(3 * v), 0 * u + 1, 0.2 * np.sin(3 * v)], 1)
    slope /= np.linalg.norm(slope, axis=1)[:, None]
    lines = [f"v {a:.3f} {b:.3f} {c:.3f}" for a, b, c in zip(u + 0.01 * frame, height, v)]
    lines += [f"vt {a} {b}" for a, b in zip(u, v)]
    lines += [f"vn {a:.4f} {b:.4f} {c:.4f}" for a, b, c in slope]
    for row in range(side):
        for column in range(side):
            a = row * (side + 1) + column + 1
            b, c, d = a + 1, a + side + 2, a + side + 1
            for corners in ((a, d, b), (b, d, c)) if turned else ((a, d, c), (a, c, b)):
                lines.append("f " + " ".join(f"{i}/{i}/{i}" for i in corners))
    return "\n".join(lines) + "\n"


@pytest.fixture(scope="module")
def stream(tmp_path_factory):
    """Six frames in groups of three; the faces change with the fifth."""
    root = tmp_path_factory.mktemp("animations")
    for i in range(6):
        (root / f"{i:04d}.obj").write_text(surface(i, 20, turned=i > 3))
        Image.new("RGB", (64, 64), (40 * i, 90, 200 - 30 * i)).save(root / f"{i:04d}.png")
    run("fvvmux", "--meshes", root / "%04d.obj", "--atlas", root / "%04d.png", "--fps", "30000/1001",
        "--units", "metres", "--up", "+y", "--step", STEP, "--group", 3, "--normals", "always",
        "--keep-geometry", "-o", root / "s.fvv", "--codec", "jpeg")  # fmt: skip
    return root / "s.fvv"


class Glb:
    """A GLB with one primitive; views: the bytes of those that are compressed."""

    def __init__(self, path, views=None):
        data = path.read_bytes()
        size = struct.unpack_from("<I", data, 12)[0]
        self.json = json.loads(data[20 : 20 + size])
        self.binary = data[28 + size :]
        self.views = {int(i): base64.b64decode(text) for i, text in (views or {}).items()}
        (mesh,), (self.node,) = self.json["meshes"], self.json["nodes"]
        (self.primitive,) = mesh["primitives"]
        self.mesh = mesh

    def view(self, index):
        view = self.json["bufferViews"][index]
        start = view.get("byteOffset", 0)
        return self.views.get(index, self.binary[start : start + view["byteLength"]])

    def numbers(self, index):
        accessor = self.json["accessors"][index]
        kind = np.dtype(COMPONENTS[accessor["componentType"]])
        width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3}[accessor["type"]]
        stride = self.json["bufferViews"][accessor["bufferView"]].get("byteStride", width * kind.itemsize)
        found = np.ndarray(
            (accessor["count"], width),
            kind,
            self.view(accessor["bufferView"]),
            accessor.get("byteOffset", 0),
            (stride, kind.itemsize),
        )
        if "min" in accessor:
            assert (found.min(0) == accessor["min"]).all() and (found.max(0) == accessor["max"]).all()
        return found.astype(np.float64)

    def poses(self, attribute="POSITION"):
        """Of the first frame, then with each target in turn."""
        first = self.numbers(self.primitive["attributes"][attribute])
        poses = [first] + [first + self.numbers(t[attribute]) for t in self.primitive.get("targets", [])]
        if attribute != "POSITION":
            return poses
        return [p * self.node.get("scale", [1] * 3) + self.node.get("translation", [0] * 3) for p in poses]

    def faces(self):
        return self.numbers(self.primitive["indices"]).astype(int).reshape(-1, 3)

    def texture(self):
        return self.numbers(self.primitive["attributes"]["TEXCOORD_0"])


def checked(*paths):
    """What the validator and meshoptimizer's decoder find; no file may have an error or a warning."""
    done = subprocess.run(["node", CHECKER, *paths], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    for file in found:
        # Extensions that the validator does not know, and what only these use.
        assert {i["code"] for i in file["issues"]} <= {"UNSUPPORTED_EXTENSION", "UNUSED_OBJECT"}, file
        assert all(i["severity"] > 1 for i in file["issues"]), file
    return [file["views"] for file in found]


def plain_frames(folder, numbers):
    return [trimesh.load(folder / f"meshes/{i:04d}.ply", process=False) for i in numbers]


def corners_of(faces, positions, texture):
    """The faces as whole numbers, whatever the order of vertices, faces, and corners in a face: of each corner
    the lattice points in all frames, and the texture coordinates."""
    values = np.concatenate([np.rint(p / STEP) for p in positions] + [np.rint(texture * 4096)], 1).astype(int)
    out = []
    for face in values[faces].tolist():
        first = face.index(min(face))
        out.append(face[first:] + face[:first])
    return sorted(out)


@pytest.fixture(scope="module")
def plain(stream, tmp_path_factory):
    folder = tmp_path_factory.mktemp("plain") / "out"
    run("fvvdemux", stream, "-o", folder, "--format", "ply")
    return folder


def texture_of(mesh):
    return np.array(mesh.visual.uv) * [1, -1] + [0, 1]  # v up


@needs_node
def test_a_run_of_frames_is_one_animation(stream, plain, tmp_path):
    done = run("fvvdemux", stream, "-o", tmp_path / "out", "--meshes", "gltf", "--json", warns=True)
    told = json.loads(done.stdout)
    assert (told["meshes"], told["mesh_files"], told["atlas"]) == (6, 2, 6)
    assert told["warnings"] == [
        "a glTF animation has one picture: 4 frames show that of the first frame of their file; atlas/ has "
        "their own"
    ]
    runs = {"0000-0003.glb": range(4), "0004-0005.glb": range(4, 6)}
    assert sorted(p.name for p in (tmp_path / "out/meshes").iterdir()) == sorted(runs)
    assert "meshes" not in json.loads((tmp_path / "out/capture.json").read_text())
    for name, numbers in runs.items():
        glb = Glb(tmp_path / "out/meshes" / name)
        frames = plain_frames(plain, numbers)
        assert (glb.faces() == frames[0].faces).all()
        assert np.abs(glb.texture() - texture_of(frames[0])).max() < 1e-7
        poses, normals = glb.poses(), glb.poses("NORMAL")
        assert len(poses) == len(frames)
        for frame, pose, normal in zip(frames, poses, normals):
            assert np.abs(frame.vertices - pose).max() < 1e-6
            own = np.stack([frame.metadata["_ply_raw"]["vertex"]["data"][k] for k in ("nx", "ny", "nz")], 1)
            assert np.abs(own - normal).max() < 1e-6
        (animation,) = glb.json["animations"]
        (sampler,), (channel,) = animation["samplers"], animation["channels"]
        assert channel == {"sampler": 0, "target": {"node": 0, "path": "weights"}}
        assert sampler["interpolation"] == "LINEAR"
        times = glb.numbers(sampler["input"]).ravel()
        assert times == pytest.approx([i * FRAME for i in range(len(frames))], abs=1e-7)
        weights = glb.numbers(sampler["output"]).reshape(len(frames), -1)
        assert (weights == np.eye(len(frames))[:, 1:]).all()
        assert glb.mesh["extras"]["targetNames"] == [f"{i:04d}" for i in numbers][1:]
        (image,) = glb.json["images"]
        picture = (tmp_path / f"out/atlas/{numbers[0]:04d}.png").read_bytes()
        assert glb.view(image["bufferView"]) == picture
    checked(*(tmp_path / "out/meshes").iterdir())


@needs_node
def test_meshopt_keeps_every_coordinate(stream, plain, tmp_path):
    for name, options in ("small", ["--compress", "meshopt"]), ("large", []):
        run("fvvdemux", stream, "-o", tmp_path / name, "--format", "gltf", "--pictures", "jpg", *options,
            warns=True)  # fmt: skip
    files = sorted((tmp_path / "small/meshes").iterdir())
    for path, views, numbers in zip(files, checked(*files), (range(4), range(4, 6))):
        assert path.stat().st_size < 0.6 * (tmp_path / "large/meshes" / path.name).stat().st_size
        glb = Glb(path, views)
        assert len(views) > 4
        assert {"EXT_meshopt_compression", "KHR_mesh_quantization"} <= set(glb.json["extensionsRequired"])
        frames = plain_frames(plain, numbers)
        for frame, pose in zip(frames, glb.poses()):
            assert np.abs(np.sort(frame.vertices, 0) - np.sort(pose, 0)).max() < 1e-9
        assert corners_of(glb.faces(), glb.poses(), glb.texture()) == corners_of(
            frames[0].faces, [f.vertices for f in frames], texture_of(frames[0])
        )


@needs_node
@pytest.mark.parametrize("compression", ["draco", "meshopt"])
def test_files_of_one_frame_are_compressed_too(stream, plain, tmp_path, compression):
    run("fvvdemux", stream, "-o", tmp_path / "out", "--meshes", "glb", "--compress", compression,
        "--frames", 4)  # fmt: skip
    path = tmp_path / "out/meshes/0004.glb"
    (views,) = checked(path)
    glb = Glb(path, views)
    (frame,) = plain_frames(plain, [4])
    if compression == "draco":
        extension = glb.primitive["extensions"]["KHR_draco_mesh_compression"]
        decoded = DracoPy.decode(glb.view(extension["bufferView"]))
        found = decoded.faces, [decoded.points], decoded.tex_coord
        position = glb.json["accessors"][glb.primitive["attributes"]["POSITION"]]
        assert (position["count"], position["max"]) == (len(decoded.points), decoded.points.max(0).tolist())
        assert np.abs(decoded.points / STEP - np.rint(decoded.points / STEP)).max() < 0.01
    else:
        found = glb.faces(), glb.poses(), glb.texture()
    assert corners_of(*found) == corners_of(frame.faces, [frame.vertices], texture_of(frame))


@needs_node
def test_every_kind_of_file_is_valid(stream, tmp_path):
    """Grey, and the plain one of one frame with a picture as well."""
    kinds = [
        ("jpg", "glb"),
        ("none", "glb"),
        ("none", "glb", "--compress", "draco"),
        ("none", "glb", "--compress", "meshopt"),
        ("none", "gltf"),
        ("none", "gltf", "--compress", "meshopt"),
    ]
    paths = []
    for i, (pictures, *form) in enumerate(kinds):
        run("fvvdemux", stream, "-o", tmp_path / str(i), "--frames", "0-1", "--pictures", pictures,
            "--format", *form)  # fmt: skip
        paths.append(min((tmp_path / str(i) / "meshes").iterdir()))
    checked(*paths)
    for (pictures, form, *_), path in zip(kinds, paths):
        document = Glb(path).json
        assert ("images" in document) == (pictures == "jpg")
        assert ("animations" in document) == (form == "gltf")


@pytest.mark.parametrize("options", [[], ["--compress", "meshopt"]])
def test_a_stream_comes_back_from_its_animation(stream, tmp_path, options):
    run("fvvdemux", stream, "-o", tmp_path / "out", "--format", "gltf", *options, warns=True)
    run("fvvmux", "--meshes", tmp_path / "out/meshes/0000-0003.glb", "--fps", "30000/1001", "--step", STEP,
        "--no-delta", "--normals", "always", "--keep-geometry", "-o", tmp_path / "again.fvv", "--codec", "jpeg")  # fmt: skip
    told = figures("fvvcompare", stream, tmp_path / "again.fvv", "--frames", "0-3", "--samples", 1000)
    assert told["compared"] == 4
    assert told["distance"]["symmetric"]["max"] < 1e-9
    assert told["normals"]["symmetric"]["mean"] < 0.1


def test_a_run_ends_where_a_frame_is_missing(stream, tmp_path):
    run("fvvdemux", stream, "-o", tmp_path / "some", "--format", "gltf", "--frames", "0-1,3",
        "--pictures", "none", warns=True)  # fmt: skip
    assert sorted(p.name for p in (tmp_path / "some/meshes").iterdir()) == ["0000-0001.glb", "0003.glb"]
    assert b"animations" not in (tmp_path / "some/meshes/0003.glb").read_bytes()
    data = bytearray(stream.read_bytes())
    second = data.index(b"MESH", data.index(b"MESH") + 1)
    data[second + 60] ^= 1
    (tmp_path / "damaged.fvv").write_bytes(data)
    told = figures("fvvdemux", tmp_path / "damaged.fvv", "-o", tmp_path / "left", "--format", "gltf", code=3)
    assert sorted(p.name for p in (tmp_path / "left/meshes").iterdir()) == [
        "0000.glb",
        "0003.glb",
        "0004-0005.glb",
    ]
    assert (told["meshes"], told["mesh_files"]) == (4, 3)


@pytest.mark.parametrize("pictures", [False, True])
def test_a_run_ends_where_the_stage_is_empty(tmp_path, pictures):
    """Without pictures the stream has no frame at all at that time, and the numbers of its frames have no gap."""
    for i in range(6):
        (tmp_path / f"{i:04d}.obj").write_text("# empty\n" if i == 2 else surface(i, 4))
        Image.new("RGB", (64, 64), (40 * i, 90, 30)).save(tmp_path / f"{i:04d}.png")
    options = ["--atlas", tmp_path / "%04d.png", "--codec", "jpeg"] if pictures else []
    run("fvvmux", "--meshes", tmp_path / "%04d.obj", *options, "--fps", 25, "--step", STEP, "-o",
        tmp_path / "s.fvv")  # fmt: skip
    assert figures("fvvinfo", tmp_path / "s.fvv")["files"][0]["frames"] == (6 if pictures else 5)
    told = figures("fvvdemux", tmp_path / "s.fvv", "-o", tmp_path / "out", "--format", "gltf",
                   "--pictures", "none")  # fmt: skip
    assert (told["meshes"], told["mesh_files"]) == (5, 2)
    before, after = sorted((tmp_path / "out/meshes").iterdir())
    assert (before.name, after.name) == ("0000-0001.glb", "0003-0005.glb")
    glb = Glb(after)
    (animation,) = glb.json["animations"]
    times = glb.numbers(animation["samplers"][0]["input"]).ravel()
    assert times == pytest.approx([0, 0.04, 0.08], abs=1e-7)


def test_a_long_run_is_several_files(tmp_path):
    for i in range(130):
        (tmp_path / f"{i:04d}.obj").write_text(surface(i, 1))
    run("fvvmux", "--meshes", tmp_path / "%04d.obj", "--fps", 25, "--step", STEP, "-o",
        tmp_path / "s.fvv")  # fmt: skip
    told = figures("fvvdemux", tmp_path / "s.fvv", "-o", tmp_path / "out", "--format", "gltf")
    assert (told["mesh_files"], told["warnings"]) == (2, [])
    first, rest = sorted((tmp_path / "out/meshes").iterdir())
    assert (first.name, rest.name) == ("0000-0127.glb", "0128-0129.glb")
    # The last frame as the last target, and the first of the next file.
    assert np.abs(Glb(first).poses()[127] - Glb(rest).poses()[0]).max() < 0.1


def test_what_cannot_be_compressed_is_refused(stream, tmp_path):
    for options, expected in (
        (["--format", "gltf", "--compress", "draco"], "Draco cannot compress the animation"),
        (["--compress", "meshopt"], "--compress: expected --meshes glb or gltf"),
        (["--format", "gltf", "--compress", "zip"], "--compress"),
    ):
        assert expected in run("fvvdemux", stream, "-o", tmp_path / "out", *options, code=2).stderr
    assert not (tmp_path / "out").exists()
