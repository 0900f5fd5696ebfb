"""Calibrations in other formats, written from random cameras by formulas of this file alone.

A function of WRITERS writes the files of one format and returns the arguments of fvvimport and the cameras, which project
points by that format's own definition. measure() imports the files and returns by how many pixels the cameras of the
capture.json, projected by spec/fvv.md clause 9, miss these places. As a script it prints that as JSON for bench.py.
"""

import json
import os
import pathlib
import struct
import subprocess
import sys
import tempfile

import numpy as np

FLIP = np.diag([1.0, -1.0, -1.0])
WIDTH, HEIGHT = 1280, 960

# COLMAP's name, number of focal lengths, and the coefficients in the order of its parameters.
COLMAP_MODELS = {
    "SIMPLE_PINHOLE": (1, ""),
    "PINHOLE": (2, ""),
    "SIMPLE_RADIAL": (1, "k1"),
    "RADIAL": (1, "k1 k2"),
    "OPENCV": (2, "k1 k2 p1 p2"),
    "FULL_OPENCV": (2, "k1 k2 p1 p2 k3 k4 k5 k6"),
    "SIMPLE_RADIAL_FISHEYE": (1, "k1"),
    "RADIAL_FISHEYE": (1, "k1 k2"),
    "OPENCV_FISHEYE": (2, "k1 k2 k3 k4"),
    "SIMPLE_FISHEYE": (1, ""),
    "FISHEYE": (2, ""),
}
RANGES = {"k1": 0.08, "k2": 0.02, "k3": 0.004, "k4": 0.03, "k5": 0.01, "k6": 0.002, "p1": 0.002, "p2": 0.002}


class Camera:
    """World -> camera R, t (x right, y down, z forward); the principal point is in the format's pixel convention."""

    def __init__(self, random, keys="", fisheye=False, focal_lengths=2):
        self.fisheye = fisheye
        self.f = random.uniform(900, 1300, focal_lengths).repeat(2 // focal_lengths)
        self.c = np.array([WIDTH, HEIGHT]) / 2 + random.uniform(-20, 20, 2)
        self.k = {key: random.uniform(-1, 1) * RANGES[key] for key in keys.split()}
        q = random.normal(size=4)
        self.q = q / np.linalg.norm(q)
        self.r = rotation(self.q)
        self.t = random.uniform(-3, 3, 3)

    def centre(self):
        return -self.r.T @ self.t

    def pose(self):
        """Camera -> world, 4 x 4, in OpenGL's axes."""
        out = np.eye(4)
        out[:3, :3] = self.r.T @ FLIP
        out[:3, 3] = self.centre()
        return out

    def project(self, points):
        """Pixels in the format's convention."""
        x, y, z = self.r @ points.T + self.t[:, None]
        return self.c + self.f * distort(np.stack([x / z, y / z], 1), self.k, self.fisheye)


def rotation(q):
    """q v q* for each axis v: Hamilton's product, w first."""
    w, v = q[0], q[1:]
    return np.stack([e + 2 * w * np.cross(v, e) + 2 * np.cross(v, np.cross(v, e)) for e in np.eye(3)], 1)


def rotation_vector(q):
    sine = np.linalg.norm(q[1:])
    return q[1:] / sine * 2 * np.arctan2(sine, q[0])


def distort(p, k, fisheye):
    k = {**dict.fromkeys(RANGES, 0.0), **k}
    x, y = p[:, 0], p[:, 1]
    r = np.hypot(x, y)
    if fisheye:
        a = np.arctan(r)
        scale = (a + k["k1"] * a**3 + k["k2"] * a**5 + k["k3"] * a**7 + k["k4"] * a**9) / r
        return p * scale[:, None]
    radial = (1 + k["k1"] * r**2 + k["k2"] * r**4 + k["k3"] * r**6) / (
        1 + k["k4"] * r**2 + k["k5"] * r**4 + k["k6"] * r**6
    )
    return np.stack(
        [
            x * radial + 2 * k["p1"] * x * y + k["p2"] * (r**2 + 2 * x**2),
            y * radial + 2 * k["p2"] * x * y + k["p1"] * (r**2 + 2 * y**2),
        ],
        1,
    )


def points_before(camera, random, count=200):
    """World points all over the picture and a little beyond, 2 to 9 units in front of the camera."""
    z = random.uniform(2, 9, count)
    xy = random.uniform(-0.5, 0.5, (count, 2)) * [WIDTH, HEIGHT] / camera.f
    return (np.column_stack([xy * z[:, None], z]) - camera.t) @ camera.r


def text(values):
    return " ".join(repr(float(v)) for v in np.ravel(values))


def write_colmap_binary(folder, random):
    """The default of COLMAP, in the folders of a project. The numbers of models are those of its sensor/models.h."""
    numbers = dict(
        zip("SIMPLE_PINHOLE PINHOLE SIMPLE_RADIAL RADIAL OPENCV OPENCV_FISHEYE FULL_OPENCV".split(), range(7))
    )
    numbers.update(SIMPLE_RADIAL_FISHEYE=8, RADIAL_FISHEYE=9, SIMPLE_FISHEYE=14, FISHEYE=15)
    cameras, intrinsics, images = [], [], []
    for i, (model, (focal_lengths, keys)) in enumerate(COLMAP_MODELS.items()):
        camera = Camera(random, keys, "FISHEYE" in model, focal_lengths)
        parameters = [*camera.f[:focal_lengths], *camera.c, *camera.k.values()]
        intrinsics.append(colmap_camera(i + 1, numbers[model], WIDTH, HEIGHT, parameters))
        images.append(colmap_image(i + 11, camera.q, camera.t, i + 1, f"rig/view{i}.png", keypoints=i))
        cameras.append((i + 11, f"view{i}", camera, 0))
    write_colmap_files(folder / "sparse/0", intrinsics, images)
    return ["colmap", folder], cameras


def colmap_camera(identity, model, width, height, parameters):
    return struct.pack(f"<IiQQ{len(parameters)}d", identity, model, width, height, *parameters)


def colmap_image(identity, q, t, camera, name, keypoints=0):
    points = b"".join(struct.pack("<ddQ", 1.5 * k, 2.5, 2**64 - 1) for k in range(keypoints))
    pose = struct.pack("<I7dI", identity, *q, *t, camera)
    return pose + name.encode() + b"\0" + struct.pack("<Q", keypoints) + points


def write_colmap_files(model, cameras, images):
    """Both files of a binary model."""
    model.mkdir(parents=True, exist_ok=True)
    for name, items in ("cameras", cameras), ("images", images):
        (model / f"{name}.bin").write_bytes(struct.pack("<Q", len(items)) + b"".join(items))


def write_colmap(folder, random):
    cameras, intrinsics, images = [], ["# Camera list"], ["# Image list"]
    for i, (model, (focal_lengths, keys)) in enumerate(COLMAP_MODELS.items()):
        camera = Camera(random, keys, "FISHEYE" in model, focal_lengths)
        parameters = [*camera.f[:focal_lengths], *camera.c, *camera.k.values()]
        intrinsics.append(f"{i + 1} {model} {WIDTH} {HEIGHT} {text(parameters)}")
        images += [
            f"{i + 11} {text(camera.q)} {text(camera.t)} {i + 1} rig/view{i}.png",
            "1.5 2.5 -1" * (i % 2),
        ]
        cameras.append((i + 11, f"view{i}", camera, 0))
    (folder / "cameras.txt").write_text("\n".join(intrinsics) + "\n")
    (folder / "images.txt").write_text("\n".join(images) + "\n")
    return ["colmap", folder], cameras


def product(p, q):
    """Hamilton's."""
    v = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *v])


def rigs_of(cameras, random):
    """All cameras as sensors of one rig, the first of which is its reference: (sensor_from_rig, rig_from_world)."""
    first = cameras[0][2]
    back = first.q * [1, -1, -1, -1]
    poses = []
    for _, _, camera, _ in cameras[1:]:
        q = product(camera.q, back)
        poses.append((q / np.linalg.norm(q), camera.t - rotation(q / np.linalg.norm(q)) @ first.t))
    return poses, (first.q, first.t)


def make_stale(camera):
    """What the list of images still has: another pose."""
    return product(camera.q, np.array([0.6, 0, 0.8, 0])), camera.t + 0.5


def write_colmap_rigs(folder, random):
    """COLMAP 3.12 and later: rigs.txt and frames.txt decide; images.txt may be stale (its issue 4752)."""
    arguments, cameras = write_colmap(folder, random)
    poses, (q, t) = rigs_of(cameras, random)
    sensors = "".join(f" CAMERA {i + 2} 1 {text(a)} {text(b)}" for i, (a, b) in enumerate(poses))
    (folder / "rigs.txt").write_text(f"# Rigs\n1 {len(cameras)} CAMERA 1{sensors}\n")
    data = "".join(f" CAMERA {i + 1} {camera[0]}" for i, camera in enumerate(cameras))
    (folder / "frames.txt").write_text(f"# Frames\n1 1 {text(q)} {text(t)} {len(cameras)}{data}\n")
    lines = (folder / "images.txt").read_text().split("\n")
    for i, (identity, _, camera, _) in enumerate(cameras):
        old_q, old_t = make_stale(camera)
        lines[1 + 2 * i] = f"{identity} {text(old_q)} {text(old_t)} {i + 1} rig/view{i}.png"
    (folder / "images.txt").write_text("\n".join(lines))
    return arguments, cameras


def write_colmap_rigs_binary(folder, random):
    arguments, cameras = write_colmap_binary(folder, random)
    model = folder / "sparse/0"
    poses, (q, t) = rigs_of(cameras, random)
    rig = struct.pack("<IIiI", 1, len(cameras), 0, 1)
    for i, (a, b) in enumerate(poses):
        rig += struct.pack("<iIB7d", 0, i + 2, 1, *a, *b)
    # An IMU, whose place is not known, counts for nothing.
    rig = rig[:4] + struct.pack("<I", len(cameras) + 1) + rig[8:] + struct.pack("<iIB", 1, 1, 0)
    (model / "rigs.bin").write_bytes(struct.pack("<Q", 1) + rig)
    frame = struct.pack("<II7dI", 1, 1, *q, *t, len(cameras) + 1) + struct.pack("<iIQ", 1, 1, 5)
    for i, camera in enumerate(cameras):
        frame += struct.pack("<iIQ", 0, i + 1, camera[0])
    (model / "frames.bin").write_bytes(struct.pack("<Q", 1) + frame)
    images = []
    for i, (identity, _, camera, _) in enumerate(cameras):
        images.append(colmap_image(identity, *make_stale(camera), i + 1, f"rig/view{i}.png", keypoints=i))
    (model / "images.bin").write_bytes(struct.pack("<Q", len(images)) + b"".join(images))
    return arguments, cameras


def opencv_yaml(values):
    out = ["%YAML:1.0", "---"]
    for key, value in values.items():
        if isinstance(value, np.ndarray):
            data = ",\n       ".join(repr(float(v)) for v in value.ravel())
            if value.ndim == 1:
                out += [f"{key}: !!opencv-nd-matrix", f"   sizes: [ {len(value)} ]"]
            else:
                out += [f"{key}: !!opencv-matrix", "   rows: {}\n   cols: {}".format(*value.shape)]
            out += ["   dt: d", f"   data: [ {data} ]"]
        else:
            out.append(f"{key}: {value}")
    return "\n".join(out) + "\n"


def opencv_xml(values):
    out = ['<?xml version="1.0"?>', "<opencv_storage>"]
    for key, value in values.items():
        if isinstance(value, np.ndarray):
            if value.ndim == 1:
                out.append(f'<{key} type_id="opencv-nd-matrix"><sizes>\n  {len(value)}</sizes>')
            else:
                size = "<rows>{}</rows><cols>{}</cols>".format(*value.shape)
                out.append(f'<{key} type_id="opencv-matrix">{size}')
            out.append("<dt>d</dt>")
            out.append(f"  <data>\n    {text(value)}</data></{key}>")
        else:
            out.append(f"<{key}>{value}</{key}>")
    return "\n".join([*out, "</opencv_storage>"]) + "\n"


def write_opencv(folder, random):
    cameras = []
    for i, keys in enumerate(
        ["k1 k2 p1 p2", "k1 k2 p1 p2 k3", "k1 k2 p1 p2 k3 k4 k5 k6", "k1 k2 k3 k4", "k1 k2 p1 p2 k3 k4 k5 k6"]
    ):
        camera = Camera(random, keys, fisheye=i == 3)
        d = np.array([*camera.k.values(), *([0.0] * 6 if i == 4 else [])])
        k = np.array([[camera.f[0], 0, camera.c[0]], [0, camera.f[1], camera.c[1]], [0, 0, 1]])
        values = {
            "calibration_time": '"today"',
            "image_width": WIDTH,
            "image_height": HEIGHT,
            ["camera_matrix", "K", "M"][i % 3]: k,
            ["distortion_coefficients", "D"][i % 2]: [d[:, None], d, d[None]][i % 3],
            "tvec" if i % 2 else "T": camera.t[:, None],
        }
        values.update({"R": camera.r} if i % 3 == 0 else {"rvec": rotation_vector(camera.q)[:, None]})
        if camera.fisheye:
            values["fisheye_model"] = 1
        as_xml = i % 2 == 1
        if i == 3:  # as a cv::Size
            values = {key: value for key, value in values.items() if not key.startswith("image_")}
            values["image_size"] = f"{WIDTH} {HEIGHT}"
        (folder / f"cam{i}.{'xml' if as_xml else 'yml'}").write_text(
            (opencv_xml if as_xml else opencv_yaml)(values)
        )
        cameras.append((i, f"cam{i}", camera, 0.5))
    return ["opencv", folder], cameras


def write_nerfstudio(folder, random):
    cameras, frames = [], []
    for i, keys in enumerate(["k1 k2 p1 p2", "k1 k2 p1 p2 k3", "k1 k2 k3 k4", ""]):
        camera = Camera(random, keys, fisheye=i == 2)
        model = ["OPENCV", "OPENCV", "OPENCV_FISHEYE", "PINHOLE"][i]
        frame = {"file_path": f"images/cam{i}/0001.png", "transform_matrix": camera.pose().tolist()}
        frame.update(camera_model=model, fl_x=camera.f[0], fl_y=camera.f[1], cx=camera.c[0], cy=camera.c[1])
        frames.append({**frame, **camera.k})
        cameras.append((i, f"cam{i}", camera, 0))
    path = folder / "transforms.json"
    path.write_text(json.dumps({"w": WIDTH, "h": HEIGHT, "frames": frames}))
    return ["nerfstudio", path], cameras


def write_qualisys(folder, random):
    cameras, out = [], ['<?xml version="1.0" encoding="ASCII"?>', "<calibration><cameras>"]
    for i in range(3):
        camera = Camera(random, "k1 k2 k3 p1 p2")
        left, top = 16 * i, 8 * i  # the sensor is larger than the picture
        window = f'left="{left}" top="{top}" right="{left + WIDTH - 1}" bottom="{top + HEIGHT - 1}"'
        whole = f'left="0" top="0" right="{WIDTH + 99}" bottom="{HEIGHT + 99}"'
        axes = FLIP @ camera.r
        turn = " ".join(f'r{j + 1}{k + 1}="{float(axes[j, k])!r}"' for j in range(3) for k in range(3))
        place = " ".join(f'{a}="{float(v) * 1000!r}"' for a, v in zip("xyz", camera.centre()))
        numbers = {
            "focalLengthU": camera.f[0] * 64,
            "focalLengthV": camera.f[1] * 64,
            "centerPointU": (camera.c[0] + left) * 64,
            "centerPointV": (camera.c[1] + top) * 64,
            "sensorMinU": 0,
            "sensorMaxU": (WIDTH + 99) * 64,
            "sensorMinV": 0,
            "sensorMaxV": (HEIGHT + 99) * 64,
            "skew": 0,
            "radialDistortion1": camera.k["k1"],
            "radialDistortion2": camera.k["k2"],
            "radialDistortion3": camera.k["k3"],
            "tangentalDistortion1": camera.k["p1"],
            "tangentalDistortion2": camera.k["p2"],
        }
        attributes = " ".join(f'{key}="{float(value)!r}"' for key, value in numbers.items())
        out.append(f'<camera active="1" serial="cam{i}" viewrotation="0"><fov_video {window}/>')
        out.append(f"<fov_video_max {whole}/><transform {turn} {place}/><intrinsic {attributes}/></camera>")
        cameras.append((i, f"cam{i}", camera, 0.5))
    path = folder / "room.qca.txt"
    path.write_text("\n".join([*out, "</cameras></calibration>"]) + "\n")
    return ["qualisys", path], cameras


def write_middlebury(folder, random):
    cameras, lines = [], ["3"]
    for i in range(3):
        camera = Camera(random)
        k = [[camera.f[0], 0, camera.c[0]], [0, camera.f[1], camera.c[1]], [0, 0, 1]]
        lines.append(f"view{i}.png {text(k)} {text(camera.r)} {text(camera.t)}")
        cameras.append((i, f"view{i}", camera, 0.5))
    path = folder / "views_par.txt"
    path.write_text("\ufeff" + "\n".join(lines) + "\n")
    return ["middlebury", path, "--size", f"{WIDTH}x{HEIGHT}"], cameras


def rows(matrix):
    return "".join(text(row) + "\n" for row in np.atleast_2d(matrix))


def intrinsic_matrix(camera):
    return np.array([[camera.f[0], 0, camera.c[0]], [0, camera.f[1], camera.c[1]], [0, 0, 1]])


def write_krt(folder, random):
    """Blocks in one file, with and without coefficients, poses in the three ways."""
    cameras, blocks = [], ["# K, lens, R and t"]
    for i, keys in enumerate(["", "k1 k2 p1 p2 k3", "k1 k2 p1 p2 k3 k4 k5 k6"]):
        camera = Camera(random, keys)
        r, t = camera.r, camera.t
        pose = [rows(np.column_stack([r, t])), rows(r) + rows(t), rows(r) + rows(t[:, None])][i]
        lens = rows(list(camera.k.values())) if keys else ""
        blocks.append(f"40000{i}\n{rows(intrinsic_matrix(camera))}{lens}{pose}")
        cameras.append((i, f"40000{i}", camera, 0.5))
    (folder / "KRT").write_text("\n".join(blocks))
    return ["krt", folder / "KRT", "--size", f"{WIDTH}x{HEIGHT}"], cameras


def write_krt_files(folder, random):
    """A file for each camera: plain blocks, and those of MVSNet."""
    cameras, cams = [], folder / "cams"
    cams.mkdir(exist_ok=True)
    for i in range(4):
        camera = Camera(random)
        pose, k = rows(np.column_stack([camera.r, camera.t])), rows(intrinsic_matrix(camera))
        mvsnet = f"extrinsic\n{pose}0 0 0 1\n\nintrinsic\n{k}\n425 2.5\n"
        (cams / f"{i:08}_cam.txt").write_text(mvsnet if i % 2 else k + "\n" + pose)
        cameras.append((i, f"{i:08}_cam", camera, 0.5))
    return ["krt", cams, "--size", f"{WIDTH}x{HEIGHT}"], cameras


def write_panoptic(folder, random):
    cameras, entries = [], []
    for i in range(3):
        camera = Camera(random, ["", "k1 k2 p1 p2 k3"][i % 2])
        entries.append(
            {
                "name": f"00_{i:02}",
                "type": "hd",
                "resolution": [WIDTH, HEIGHT],
                "panel": 0,
                "node": i,
                "K": intrinsic_matrix(camera).tolist(),
                "distCoef": list(camera.k.values()) or [0.0] * 5,
                "R": camera.r.tolist(),
                "t": (camera.t * 100)[:, None].tolist(),
            }
        )
        cameras.append((i, f"00_{i:02}", camera, 0.5))
    path = folder / "calibration.json"
    path.write_text(json.dumps({"calibDataSource": "test", "cameras": entries}))
    return ["panoptic", path], cameras


def stored(values):
    """A matrix as cv::FileStorage writes it in JSON."""
    values = np.atleast_2d(values)
    return {
        "type_id": "opencv-matrix",
        "rows": values.shape[0],
        "cols": values.shape[1],
        "dt": "d",
        "data": [float(v) for v in values.ravel()],
    }


def ros(values):
    """A matrix of camera_info, which has neither a type nor dt."""
    values = np.atleast_2d(values)
    return "{rows: %d, cols: %d, data: [%s]}" % (
        *values.shape,
        ", ".join(repr(float(v)) for v in values.ravel()),
    )


def write_opencv_others(folder, random):
    """JSON of cv::FileStorage, camera_info of ROS with a pose beside it, and plain lists."""
    cameras = []
    for i, keys in enumerate(
        ["k1 k2 p1 p2 k3", "k1 k2 p1 p2 k3", "k1 k2 k3 k4", "k1 k2 p1 p2 k3 k4 k5 k6", ""]
    ):
        camera = Camera(random, keys, fisheye=i == 2)
        k, d = intrinsic_matrix(camera), list(camera.k.values())
        if i == 0:
            values = {"image_width": WIDTH, "image_height": HEIGHT, "camera_matrix": stored(k)}
            values["distortion_coefficients"] = stored(d)
            values |= {"rvec": stored(rotation_vector(camera.q)[:, None]), "tvec": stored(camera.t[:, None])}
            (folder / "cam0.json").write_text(json.dumps(values, indent="\t"))
        elif i < 3:
            model = "equidistant" if camera.fisheye else "plumb_bob"
            lines = [f"image_width: {WIDTH}", f"image_height: {HEIGHT}", f"camera_name: cam{i}"]
            lines += [f"camera_matrix: {ros(k)}", f"distortion_model: {model}"]
            lines += [f"distortion_coefficients: {ros(d)}", f"rectification_matrix: {ros(np.eye(3))}"]
            lines += [f"projection_matrix: {ros(np.eye(3, 4))}", f"R: {ros(camera.r)}", f"T: {ros(camera.t)}"]
            (folder / f"cam{i}.yaml").write_text("\n".join(lines) + "\n")
        else:
            values = {"image_size": [WIDTH, HEIGHT], "K": k.tolist() if i == 3 else k.ravel().tolist()}
            values |= {"dist": d or [0.0] * 5, "tvec": camera.t.tolist()}
            values |= {"R": camera.r.tolist()} if i == 3 else {"rvec": rotation_vector(camera.q).tolist()}
            (folder / f"cam{i}.json").write_text(json.dumps(values))
        cameras.append((i, f"cam{i}", camera, 0.5))
    return ["opencv", *(next(folder.glob(f"cam{i}.*")) for i in range(5))], cameras


def write_panoptic_others(folder, random):
    """The keys of the studio by the cameras' names, with other words for some of them."""
    cameras, entries = [], {}
    for i in range(3):
        camera = Camera(random, ["", "k1 k2 p1 p2 k3"][i % 2])
        entry = {"K": intrinsic_matrix(camera).tolist(), "R": camera.r.tolist()}
        entry |= {"image_size": [WIDTH, HEIGHT]} if i else {"width": WIDTH, "height": HEIGHT}
        entry |= {"T": camera.t.tolist()} if i else {"t": camera.t[:, None].tolist()}
        if camera.k:
            entry["dist"] = list(camera.k.values())
        entries[f"view{i}"] = entry
        cameras.append((i, f"view{i}", camera, 0.5))
    (folder / "cameras.json").write_text(json.dumps(entries))
    return ["panoptic", folder / "cameras.json"], cameras


def write_easymocap(folder, random):
    cameras, inner, outer = [], {}, {}
    for i, keys in enumerate(["k1 k2 p1 p2 k3", "", "k1 k2 p1 p2 k3"]):
        camera = Camera(random, keys)
        name = f"{i:02}"
        inner[f"K_{name}"] = intrinsic_matrix(camera)
        inner[f"dist_{name}"] = np.array([list(camera.k.values()) or [0.0] * 5]).T
        if i == 2:
            inner |= {f"H_{name}": HEIGHT, f"W_{name}": float(WIDTH)}
        if i != 1:  # some writers leave one of them out
            outer[f"R_{name}"] = rotation_vector(camera.q)[:, None]
        if i != 0:
            outer[f"Rot_{name}"] = camera.r
        outer[f"T_{name}"] = camera.t[:, None]
        cameras.append((i, name, camera, 0.5))
    names = "names:\n" + "".join(f'   - "{name}"\n' for _, name, *_ in cameras)
    for file, values in (("intri.yml", inner), ("extri.yml", outer)):
        (folder / file).write_text(opencv_yaml(values) + names)
    return ["easymocap", folder, "--size", f"{WIDTH}x{HEIGHT}"], cameras


def write_toml(folder, random):
    """As aniposelib, Caliscope and Pose2Sim write it; tables out of the order of their names."""
    cameras, out = [], []
    for i, keys in enumerate(["k1 k2 p1 p2 k3", "k1 k2 k3 k4", "k1 k2 p1 p2"]):
        camera = Camera(random, keys, fisheye=i == 1)
        table = f"[cam_{9 - i}]\nname = 'view {i}'\nsize = [{WIDTH}.0, {HEIGHT}.0]\n"
        table += f"matrix = {intrinsic_matrix(camera).tolist()}\ndistortions = {list(map(float, camera.k.values()))}\n"
        table += f"rotation = {rotation_vector(camera.q).tolist()}\ntranslation = {camera.t.tolist()}\n"
        out.append(table + ("fisheye = true\n" if camera.fisheye else "" if i else "fisheye = false\n"))
        cameras.append((i, f"view {i}", camera, 0.5))
    out.append("[metadata]\nadjusted = false\nerror = 0.25\n")
    (folder / "calibration.toml").write_text("\n".join(out))
    return ["toml", folder / "calibration.toml"], cameras


def write_kalibr(folder, random):
    """A chain: each camera from the one before; the world is the first camera's."""
    cameras, out, before = [], [], np.eye(4)
    for i, keys in enumerate(["k1 k2 p1 p2", "k1 k2 k3 k4", ""]):
        camera = Camera(random, keys, fisheye=i == 1)
        to_camera = np.eye(4)
        if i:
            to_camera[:3, :3], to_camera[:3, 3] = camera.r, camera.t
        camera.r, camera.t = to_camera[:3, :3], to_camera[:3, 3]
        lines = [
            f"cam{i}:",
            "  camera_model: pinhole",
            f"  distortion_model: {['radtan', 'equidistant', 'none'][i]}",
        ]
        lines.append(f"  intrinsics: {[*map(float, camera.f), *map(float, camera.c)]}")
        lines.append(
            f"  distortion_coeffs: {list(map(float, camera.k.values()))}" if keys else "  rostopic: /left"
        )
        lines.append(f"  resolution: [{WIDTH}, {HEIGHT}]")
        if i:
            step = to_camera @ np.linalg.inv(before)
            lines += ["  T_cn_cnm1:", *(f"  - {row}" for row in step.tolist())]
        out += lines
        before = to_camera
        cameras.append((i, f"cam{i}", camera, 0.5))
    (folder / "camchain.yaml").write_text("\n".join(out) + "\n")
    return ["kalibr", folder / "camchain.yaml"], cameras


class Metashape(Camera):
    """Metashape's own formula, with b1 and b2; p1 goes with r^2 + 2 x^2."""

    def project(self, points):
        x, y, z = self.r @ points.T + self.t[:, None]
        u, v, k = x / z, y / z, {**dict.fromkeys(RANGES, 0.0), **self.k}
        r = np.hypot(u, v)
        radial = 1 + k["k1"] * r**2 + k["k2"] * r**4 + k["k3"] * r**6
        du = u * radial + k["p1"] * (r**2 + 2 * u**2) + 2 * k["p2"] * u * v
        dv = v * radial + k["p2"] * (r**2 + 2 * v**2) + 2 * k["p1"] * u * v
        f, b1, b2 = self.f[1], *self.b
        return np.stack([self.c[0] + du * f + du * b1 + dv * b2, self.c[1] + dv * f], 1)


def write_metashape_components(folder, random):
    """As newer versions write it: the transform is that of the cameras' component."""
    arguments, cameras = write_metashape(folder, random)
    text_of_file = arguments[1].read_text()
    begin, end = text_of_file.rindex("<transform><rotation>"), text_of_file.rindex("</chunk>")
    parts = f'<components next_id="2" active_id="1"><component id="1">{text_of_file[begin:end]}</component></components>'
    text_of_file = text_of_file[:begin] + parts + text_of_file[end:]
    arguments[1].write_text(text_of_file.replace("<camera id", '<camera component_id="1" id'))
    return arguments, cameras


def write_metashape(folder, random):
    """Two sensors, a group, a camera that is not aligned, and a chunk that is turned, moved and scaled."""
    turn, move, scale = Camera(random).r, random.uniform(-2, 2, 3), random.uniform(0.5, 2)
    cameras, sensors, entries = [], [], []
    for i, keys in enumerate(["k1 k2 k3 p1 p2", ""]):
        camera = Metashape(random, keys, focal_lengths=1)
        camera.b = random.uniform(-3, 3, 2) if keys else np.zeros(2)
        numbers = {"f": camera.f[1], "cx": camera.c[0] - WIDTH / 2, "cy": camera.c[1] - HEIGHT / 2}
        numbers |= camera.k | ({"b1": camera.b[0], "b2": camera.b[1]} if keys else {})
        size = f'<resolution width="{WIDTH}" height="{HEIGHT}"/>'
        lens = "".join(f"<{key}>{float(value)!r}</{key}>" for key, value in numbers.items())
        sensors.append(
            f'<sensor id="{i}" label="unknown" type="frame">{size}<calibration type="frame" class="initial">{size}'
            f'<f>1000</f></calibration><calibration type="frame" class="adjusted">{size}{lens}</calibration></sensor>'
        )
        # World to camera is R, t; in the chunk the centre is S^-1 of that in the world.
        pose = np.eye(4)
        pose[:3, :3] = turn.T @ camera.r.T
        pose[:3, 3] = turn.T @ (camera.centre() - move) / scale
        entries.append(
            f'<camera id="{7 + i}" sensor_id="{i}" label="shot{i}"><transform>{text(pose)}</transform></camera>'
        )
        cameras.append((i, f"shot{i}", camera, 0))
    chunk = f"<sensors>{''.join(sensors)}</sensors><cameras><group id='0'>{entries[0]}</group>{entries[1]}</cameras>"
    chunk += f"<transform><rotation>{text(turn)}</rotation><translation>{text(move)}</translation>"
    chunk += f"<scale>{float(scale)!r}</scale></transform>"
    path = folder / "cameras.xml"
    path.write_text(f'<?xml version="1.0"?><document version="1.5.0"><chunk>{chunk}</chunk></document>\n')
    return ["metashape", path], cameras


def write_realitycapture(folder, random):
    """Sidecars, with attributes and with elements."""
    cameras, unit = [], max(WIDTH, HEIGHT)
    for i, keys in enumerate(["", "k1 k2 p1 p2 k3"]):
        camera = Camera(random, keys, focal_lengths=1)
        k = {**dict.fromkeys(RANGES, 0.0), **camera.k}
        c = (camera.c - np.array([WIDTH, HEIGHT]) / 2) / unit
        lens = f'xcr:FocalLength35mm="{float(camera.f[0] * 36 / unit)!r}" xcr:Skew="0" xcr:AspectRatio="1"'
        lens += f' xcr:PrincipalPointU="{float(c[0])!r}" xcr:PrincipalPointV="{float(c[1])!r}"'
        numbers = text([k["k1"], k["k2"], k["k3"], 0, k["p1"], k["p2"]])
        lens += f' xcr:DistortionModel="{"brown3t2" if keys else "perspective"}"'
        lens += ' xmlns:xcr="http://www.capturingreality.com/ns/xcr/1.1#" xmlns:rdf="r"'
        inner = f"<xcr:Rotation>{text(camera.r)}</xcr:Rotation><xcr:Position>{text(camera.centre())}</xcr:Position>"
        inner += f"<xcr:DistortionCoeficients>{numbers}</xcr:DistortionCoeficients>"
        (folder / f"shot{i}.xmp").write_text(
            f'<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="r"><rdf:Description {lens}>{inner}'
            "</rdf:Description></rdf:RDF></x:xmpmeta>\n"
        )
        cameras.append((i, f"shot{i}", camera, 0))
    return ["realitycapture", folder, "--size", f"{WIDTH}x{HEIGHT}"], cameras


def write_realitycapture_table(folder, random):
    """Heading, pitch and roll of a camera that looks down, its top to the north, as rotations about fixed axes."""
    cameras, lines, unit = (
        [],
        ["#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2"],
        max(WIDTH, HEIGHT),
    )

    def about(axis, degrees):
        q = np.zeros(4)
        q[0], q[1 + axis] = np.cos(np.radians(degrees) / 2), np.sin(np.radians(degrees) / 2)
        return rotation(q)

    for i in range(3):
        camera = Camera(random, "k1 k2 k3", focal_lengths=1)
        heading, pitch, roll = random.uniform(-180, 180), random.uniform(0, 90), random.uniform(-90, 90)
        centre = camera.centre()
        camera.r = FLIP @ (about(2, -heading) @ about(0, pitch) @ about(1, roll)).T
        camera.t = -camera.r @ centre
        c = (camera.c - np.array([WIDTH, HEIGHT]) / 2) * 36 / unit
        values = [*centre, heading, pitch, roll, camera.f[0] * 36 / unit, *c, *camera.k.values(), 0, 0, 0]
        lines.append(f"shot{i}.jpg," + ",".join(repr(float(v)) for v in values))
        cameras.append((i, f"shot{i}", camera, 0))
    (folder / "cameras.csv").write_text("\n".join(lines) + "\n")
    return ["realitycapture", folder / "cameras.csv", "--size", f"{WIDTH}x{HEIGHT}"], cameras


WRITERS = {
    "realitycapture": write_realitycapture,
    "realitycapture_table": write_realitycapture_table,
    "easymocap": write_easymocap,
    "kalibr": write_kalibr,
    "metashape": write_metashape,
    "metashape_components": write_metashape_components,
    "opencv_others": write_opencv_others,
    "panoptic_others": write_panoptic_others,
    "toml": write_toml,
    "colmap": write_colmap,
    "colmap_binary": write_colmap_binary,
    "colmap_rigs": write_colmap_rigs,
    "colmap_rigs_binary": write_colmap_rigs_binary,
    "krt": write_krt,
    "krt_files": write_krt_files,
    "panoptic": write_panoptic,
    "opencv": write_opencv,
    "nerfstudio": write_nerfstudio,
    "qualisys": write_qualisys,
    "middlebury": write_middlebury,
}


def project_capture(camera, points):
    """spec/fvv.md clause 9.1, on a camera of a capture.json with pixel_centre 0.5."""
    x, y, z = np.array(camera["rotation"]) @ points.T + np.array(camera["translation"])[:, None]
    lens, i = camera["lens"], camera["intrinsics"]
    names = {"none": "", "radtan": "k1 k2 p1 p2 k3 k4 k5 k6", "fisheye": "k1 k2 k3 k4"}[lens["model"]].split()
    k = dict(zip(names, lens.get("coefficients", [])))
    u, v = distort(np.stack([x / z, y / z], 1), k, lens["model"] == "fisheye").T
    return np.stack([i["fx"] * u + i["skew"] * v + i["cx"], i["fy"] * v + i["cy"]], 1)


def measure(tool, name, folder, seed=1):
    """Returns the largest distance in pixels by NumPy, and by fvvimport --check."""
    random = np.random.default_rng(seed)
    arguments, cameras = WRITERS[name](folder, random)
    out, observed = folder / "capture.json", folder / "observed.txt"
    lines, expected = ["# X Y Z CAMERA_ID U V"], []
    for identity, _, camera, to_half in cameras:
        points = points_before(camera, random)
        pixels = camera.project(points) + to_half
        expected.append((points, pixels))
        lines += [f"{text(p)} {identity} {text(q)}" for p, q in zip(points, pixels)]
    observed.write_text("\n".join(lines) + "\n")
    options = ["-o", out, "--force", "--pictures", "{name}/{id}.png", "--check", observed, "--json"]
    done = subprocess.run([str(a) for a in [tool, *arguments, *options]], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"fvvimport {name}: {done.returncode}: {done.stderr.strip()}")
    written = json.loads(out.read_text())["cameras"]
    assert [(c["id"], c["name"]) for c in written] == [(c[0], c[1]) for c in cameras]
    worst = max(
        np.abs(project_capture(camera, points) - pixels).max()
        for camera, (points, pixels) in zip(written, expected)
    )
    check = json.loads(done.stdout)["check"]
    assert check["invisible"] == 0
    return float(worst), check["max_px"]


def main():
    tool = pathlib.Path(os.environ["FVV_TOOLS_DIR"]).resolve() / "fvvimport/fvvimport"
    errors = {}
    for name in WRITERS:
        with tempfile.TemporaryDirectory() as folder:
            errors[name] = max(measure(tool, name, pathlib.Path(folder)))
    print(json.dumps({"max_error_px": max(errors.values()), "max_error_px_of_format": errors}))


if __name__ == "__main__":
    sys.exit(main())
