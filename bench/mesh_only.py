"""Streams of meshes alone: bits a vertex of real sequences at 1 mm, mixed connectivity, and decimation of a large mesh."""

import json
import time

import codecs_table
import DracoPy
import numpy as np

ERROR_MM = 1
DRACO_BITS = (10, 11)
DRACO_EVERY = 10  # frames


def read_obj(path):
    """Vertices and triangles of an OBJ file; polygons become fans."""
    vertices, faces = [], []
    for line in path.read_text().splitlines():
        words = line.split()
        if words[:1] == ["v"]:
            vertices.append([float(x) for x in words[1:4]])
        elif words[:1] == ["f"]:
            corners = [int(word.split("/")[0]) - 1 for word in words[1:]]
            faces += [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
    return np.array(vertices), np.array(faces, np.uint32)


def write_ply(path, vertices, faces):
    header = (
        f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty double x\nproperty double y\n"
        f"property double z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    rows = np.empty(len(faces), [("count", "u1"), ("corners", "<i4", 3)])
    rows["count"], rows["corners"] = 3, faces
    path.write_bytes(header.encode() + vertices.astype("<f8").tobytes() + rows.tobytes())


def write_capture(folder, meshes):
    """A capture without cameras. meshes: vertices in metres and faces of each frame."""
    folder.mkdir(parents=True, exist_ok=True)
    for i, (vertices, faces) in enumerate(meshes):
        write_ply(folder / f"{i:04d}.ply", vertices, faces)
    description = {
        "fvv_capture": 1,
        "name": folder.name,
        "frame_rate": "25",
        "frames": {"first": 0, "count": len(meshes)},
        "units": "metres",
        "cameras": [],
        "meshes": {"pattern": "%04d.ply"},
    }
    (folder / "capture.json").write_text(json.dumps(description))
    return folder


def scaled(files, axis):
    """The meshes of files, scaled so that the first is HEIGHT high."""
    meshes = [read_obj(path) for path in files]
    extent = np.ptp(meshes[0][0][:, codecs_table.AXES[axis]])
    return [(vertices * codecs_table.HEIGHT / extent, faces) for vertices, faces in meshes]


def bits_per_vertex(tool, capture, meshes, *options):
    out = capture.with_suffix(".fvv")
    done = tool("fvvmux", capture, "-o", out, "--force", "--json", "--keep-geometry", "--max-error",
                f"{ERROR_MM}mm", *options)  # fmt: skip
    return 8 * json.loads(done)["mesh"]["bytes"] / sum(len(vertices) for vertices, _ in meshes)


def draco_bits_per_vertex(meshes, bits):
    """Of some frames, each as a mesh of its own: Draco knows no motion."""
    some = meshes[::DRACO_EVERY]
    size = sum(
        len(DracoPy.encode(v.astype(np.float32), f, quantization_bits=bits, compression_level=10))
        for v, f in some
    )
    return 8 * size / sum(len(vertices) for vertices, _ in some)


def icosphere(splits, radius=0.5):
    """20 * 4 ** splits triangles."""
    golden = (1 + 5**0.5) / 2
    vertices = np.array(
        [(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0), (0, -1, golden), (0, 1, golden)]
        + [
            (0, -1, -golden),
            (0, 1, -golden),
            (golden, 0, -1),
            (golden, 0, 1),
            (-golden, 0, -1),
            (-golden, 0, 1),
        ]
    )
    faces = np.array(
        [
            (0, 11, 5),
            (0, 5, 1),
            (0, 1, 7),
            (0, 7, 10),
            (0, 10, 11),
            (1, 5, 9),
            (5, 11, 4),
            (11, 10, 2),
            (10, 7, 6),
        ]
        + [
            (7, 1, 8),
            (3, 9, 4),
            (3, 4, 2),
            (3, 2, 6),
            (3, 6, 8),
            (3, 8, 9),
            (4, 9, 5),
            (2, 4, 11),
            (6, 2, 10),
        ]
        + [(8, 6, 7), (9, 8, 1)]
    )
    for _ in range(splits):
        edges = np.sort(faces[:, [(0, 1), (1, 2), (2, 0)]].reshape(-1, 2), axis=1)
        unique, index = np.unique(edges, axis=0, return_inverse=True)
        middle = (len(vertices) + index).reshape(-1, 3)
        vertices = np.vstack([vertices, (vertices[unique[:, 0]] + vertices[unique[:, 1]]) / 2])
        vertices /= np.linalg.norm(vertices, axis=1, keepdims=True)
        (a, b, c), (ab, bc, ca) = faces.T, middle.T
        faces = np.vstack([np.stack(f, 1) for f in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))])
    return vertices * radius, faces.astype(np.uint32)


def measure(tool, work):
    """Figures meshonly.*, mixed.* and decimate.*. tool(name, *arguments) runs a tool and returns what it prints."""
    figures = {}
    print(
        f"whole sequences without cameras, {codecs_table.HEIGHT} m high, every coordinate within {ERROR_MM} mm"
    )
    for name, pattern, axis, tracked in codecs_table.SEQUENCES:
        if not tracked:
            continue
        files = codecs_table.found(pattern, work / "sequences" / name)
        if not files:
            print(f"{name:12}absent: no {pattern} under FVV_DATA ({codecs_table.DATA})")
            continue
        meshes = scaled(files, axis)
        capture = write_capture(work / "mesh_only" / name, meshes)
        ours = bits_per_vertex(tool, capture, meshes)
        together = bits_per_vertex(tool, capture, meshes, "--group", len(meshes))
        draco = [draco_bits_per_vertex(meshes, bits) for bits in DRACO_BITS]
        figures[f"meshonly.{name}_bits_per_vertex"] = ours
        figures[f"meshonly.{name}_one_group_bits_per_vertex"] = together
        print(
            f"{name:12}{len(meshes):4} frames{len(meshes[0][0]):7} vertices: {ours:.2f} bits a vertex and frame in groups "
            f"of 25, {together:.2f} in one group; Draco "
            + ", ".join(f"q{bits} {value:.2f}" for bits, value in zip(DRACO_BITS, draco))
        )
    mixed = [icosphere(4)] + [icosphere(4) if i == 0 else icosphere_of(i) for i in range(20)]
    capture = write_capture(work / "mesh_only" / "mixed", mixed)
    figures["mixed.bytes_over_no_delta"] = bits_per_vertex(tool, capture, mixed) / bits_per_vertex(
        tool, capture, mixed, "--no-delta"
    )
    large = write_capture(work / "mesh_only" / "large", [icosphere(8)])
    begin = time.perf_counter()
    tool("fvvmux", large, "-o", large.with_suffix(".fvv"), "--force", "--max-error", f"{ERROR_MM}mm")
    figures["decimate.million_triangles_s"] = time.perf_counter() - begin
    return figures


def icosphere_of(i):
    """As icosphere(4), with connectivity of its own: some faces are split."""
    vertices, faces = icosphere(4)
    middles = vertices[faces[:i]].mean(axis=1)
    fans = []
    for k, (a, b, c) in enumerate(faces[:i]):
        m = len(vertices) + k
        fans += [(a, b, m), (b, c, m), (c, a, m)]
    return np.vstack([vertices, middles]), np.vstack([faces[i:], np.array(fans, np.uint32)])
