"""Files with four times as many of anything, 200,000 properties for one, take in proportion longer: none costs its square."""

import base64
import json
import resource
import struct
import subprocess

import pytest
from conftest import tool_path

pytestmark = pytest.mark.long
FEW, MANY = 50000, 200000
MOST_RATIO = 8  # 4 if all of the time is the file's, 16 if that grows with the square
RUNS = 3
CORNERS = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"]
FACES = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)]
TETRAHEDRON = [f"v {v}" for v in CORNERS] + ["f " + " ".join(str(i + 1) for i in face) for face in FACES]
CAPTURE = ["fvvmux", ".", "-o", "o.fvv", "--force"]
CASES = {}


def case(divisor=1):
    """divisor: of the counts, where a thing costs more than a line."""

    def add(function):
        CASES[function.__name__] = (function, divisor)
        return function

    return add


def meshes(name):
    return ["fvvmux", "--meshes", name, "--fps", 25, "-o", "o.fvv", "--force"]


def calibration(kind, name, *more):
    return ["fvvimport", kind, name, *more, "--pictures", "p/{name}/%04d.png", "-o", "o.json", "--force"]


def write(path, lines):
    path.parent.mkdir(exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def ply(folder, properties=(), more=(), values=""):
    body = [f"{corner}{values}" for corner in CORNERS] + [f"3 {a} {b} {c}" for a, b, c in FACES]
    vertex = ["element vertex 4", *(f"property float {axis}" for axis in "xyz"), *properties]
    face = ["element face 4", "property list uchar int vertex_indices", *more]
    write(folder / "m.ply", ["ply", "format ascii 1.0", *vertex, *face, "end_header", *body])
    return meshes("m.ply")


@case()
def ply_properties(folder, n):
    return ply(folder, properties=[f"property uchar p{i}" for i in range(n)], values=" 0" * n)


@case()
def ply_elements(folder, n):
    return ply(folder, more=[f"element e{i} 0" for i in range(n)])


@case()
def ply_pictures(folder, n):
    return ply(folder, more=[f"comment TextureFile {i}.png" for i in range(n)])


def obj(folder, lines):
    write(folder / "m.obj", [*TETRAHEDRON, *lines])
    return meshes("m.obj")


@case()
def obj_groups(folder, n):
    return obj(folder, (f"g g{i}" for i in range(n)))


@case()
def obj_materials(folder, n):
    return obj(folder, (line for i in range(n) for line in (f"usemtl m{i}", "f 1 3 2")))


@case(40)
def obj_libraries(folder, n):
    return obj(folder, (f"mtllib m{i}.mtl" for i in range(n)))


@case(40)
def mtl_materials(folder, n):
    write(folder / "m.mtl", (line for i in range(n) for line in (f"newmtl m{i}", f"map_Kd {i}.png")))
    textured = ["mtllib m.mtl", "vt 0 0", "vt 1 0", "vt 0 1", *(f"usemtl m{i}" for i in range(n))]
    return obj(folder, [*textured, "f 1/1 3/2 2/3"])


def gltf(folder, **more):
    """A tetrahedron, and more of anything."""
    bytes_ = struct.pack("<12f", *(float(x) for corner in CORNERS for x in corner.split()))
    bytes_ += struct.pack("<12H", *(corner for face in FACES for corner in face))
    uri = "data:application/octet-stream;base64," + base64.b64encode(bytes_).decode()
    views = [(0, 48), (48, 24)]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "buffers": [{"byteLength": len(bytes_), "uri": uri}],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": size} for at, size in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}
            | {"min": [0, 0, 0], "max": [1, 1, 1]},
            {"bufferView": 1, "componentType": 5123, "count": 12, "type": "SCALAR"},
        ],
    }
    for key, values in more.items():
        document[key] = document.get(key, []) + values if key != "scenes" else values
    write(folder / "m.gltf", [json.dumps(document)])
    return meshes("m.gltf")


@case()
def gltf_nodes(folder, n):
    return gltf(folder, nodes=[{}] * n, scenes=[{"nodes": list(range(n + 1))}])


@case()
def gltf_children(folder, n):
    return gltf(folder, nodes=[{"children": list(range(2, n + 2))}, *[{}] * n], scenes=[{"nodes": [0, 1]}])


@case(4)
def gltf_meshes(folder, n):
    return gltf(folder, meshes=[{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}] * n)


@case(20)
def gltf_primitives(folder, n):
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    return gltf(
        folder, nodes=[{"mesh": 1}], meshes=[{"primitives": [primitive] * n}], scenes=[{"nodes": [1]}]
    )


@case(4)
def gltf_accessors(folder, n):
    return gltf(folder, accessors=[{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}] * n)


@case(4)
def gltf_materials(folder, n):
    return gltf(folder, materials=[{}] * n, images=[{"uri": "a.png"}] * n, textures=[{"source": 0}] * n)


@case()
def gltf_joints(folder, n):
    return gltf(folder, nodes=[{}] * n, skins=[{"joints": list(range(1, n + 1))}])


def camera(number):
    lens = {"model": "pinhole", "coefficients": []}
    return {
        "id": number % 65536,
        "name": f"c{number}",
        "width": 64,
        "height": 48,
        "intrinsics": {"fx": 100, "fy": 100, "cx": 32, "cy": 24},
        "distortion": lens,
    }


@case(4)
def capture_cameras(folder, n):
    write(folder / "capture.json", [json.dumps({"fvv_capture": 1, "cameras": [camera(i) for i in range(n)]})])
    return CAPTURE


@case()
def capture_ranges_left_out(folder, n):
    frames = {"first": 0, "count": n, "step": 1, "left_out": [[0, n - 2]] * (n // 10)}
    write(
        folder / "capture.json",
        [json.dumps({"fvv_capture": 1, "frame_rate": 25, "frames": frames, "up": "down"})],
    )
    return CAPTURE


@case()
def capture_keys(folder, n):
    write(folder / "capture.json", [json.dumps({f"k{i}": 1 for i in range(n)})])
    return CAPTURE


IDENTITY = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]


@case(10)
def nerfstudio_frames(folder, n):
    document = {"fl_x": 100, "fl_y": 100, "cx": 32, "cy": 24, "w": 64, "h": 48}
    frames = [{"file_path": f"c{i}.png", "transform_matrix": IDENTITY} for i in range(n)]
    write(folder / "transforms.json", [json.dumps(document | {"frames": frames})])
    return calibration("nerfstudio", "transforms.json")


@case(10)
def panoptic_cameras(folder, n):
    turn = [row[:3] for row in IDENTITY[:3]]
    lens = {"resolution": [64, 48], "K": [[100, 0, 32], [0, 100, 24], [0, 0, 1]], "distCoef": [0] * 5}
    one = {"type": "hd", "R": turn, "t": [[0], [0], [1]], **lens}
    write(folder / "c.json", [json.dumps({"cameras": [one | {"name": str(i)} for i in range(n)]})])
    return calibration("panoptic", "c.json")


@case(10)
def middlebury_cameras(folder, n):
    numbers = "100 0 32 0 100 24 0 0 1 1 0 0 0 1 0 0 0 1 0 0 2"
    write(folder / "par.txt", [str(n), *(f"a{i}.png {numbers}" for i in range(n))])
    return calibration("middlebury", "par.txt", "--size", "64x48")


@case(12)
def metashape_sensors(folder, n):
    size = "<resolution width='64' height='48'/>"
    sensor = f"{size}<calibration>{size}<f>100</f></calibration>"
    pose = f"<transform>{' '.join(str(x) for row in IDENTITY for x in row)}</transform>"
    lines = ["<document><chunk><sensors>"]
    lines += [f"<sensor id='{i}'>{sensor}</sensor>" for i in range(n)]
    lines += ["</sensors><cameras>", f"<camera id='{n}' sensor_id='0' label='a'>{pose}</camera>"]
    lines += [f"<camera id='{i}' sensor_id='{i}' label='c{i}'/>" for i in range(n)]
    write(folder / "m.xml", [*lines, "</cameras></chunk></document>"])
    return calibration("metashape", "m.xml")


@case(4)
def qualisys_cameras(folder, n):
    cameras = [f"<camera serial='{i}' active='0'/>" for i in range(n)]
    write(folder / "q.xml", ["<calibration><cameras>", *cameras, "</cameras></calibration>"])
    return calibration("qualisys", "q.xml")


@case(2)
def yaml_keys(folder, n):
    write(folder / "c.yml", ["%YAML:1.0", "---", *(f"k{i}: 1" for i in range(n))])
    return calibration("opencv", "c.yml")


@case(40)
def kalibr_cameras(folder, n):
    lens = "camera_model: pinhole\n  distortion_model: radtan\n  distortion_coeffs: [0, 0, 0, 0]"
    lens += "\n  intrinsics: [100, 100, 32, 24]\n  resolution: [64, 48]"
    write(folder / "c.yaml", (f"cam{i}:\n  {lens}\n  T_cn_cnm1: {IDENTITY}" for i in range(n)))
    return calibration("kalibr", "c.yaml")


@case(2)
def toml_keys(folder, n):
    write(folder / "c.toml", (f"k{i} = 1" for i in range(n)))
    return calibration("toml", "c.toml")


@case(40)
def toml_cameras(folder, n):
    lens = "size = [64, 48]\nmatrix = [[100.0, 0.0, 32.0], [0.0, 100.0, 24.0], [0.0, 0.0, 1.0]]"
    pose = "distortions = [0.0, 0.0, 0.0, 0.0]\nrotation = [0.0, 0.0, 0.0]\ntranslation = [0.0, 0.0, 1.0]"
    write(folder / "c.toml", (f"[cam_{i}]\n{lens}\n{pose}" for i in range(n)))
    return calibration("toml", "c.toml")


@case(10)
def colmap_images(folder, n):
    write(folder / "m/cameras.txt", (f"{i} PINHOLE 64 48 100 100 32 24" for i in range(1, n + 1)))
    write(folder / "m/images.txt", (f"{i} 1 0 0 0 0 0 0 {i} c{i}.png\n" for i in range(1, n + 1)))
    write(folder / "m/points3D.txt", [])
    return calibration("colmap", "m")


def seconds(command, folder):
    """Processor time, the least of some runs. A file may be refused, by a limit too; no run may crash or wait."""
    words = [str(tool_path(command[0])), *map(str, command[1:])]
    best = float("inf")
    for _ in range(RUNS):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=60)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        best = min(best, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
        assert done.returncode in (0, 1, 3), done.stderr[:500]
    return best


@pytest.mark.parametrize("name", CASES)
def test_four_times_as_many(name, tmp_path):
    prepare, divisor = CASES[name]
    times = []
    for count in (FEW // divisor, MANY // divisor):
        folder = tmp_path / str(count)
        folder.mkdir()
        times.append(seconds(prepare(folder, count), folder))
    assert times[1] < MOST_RATIO * times[0], times
