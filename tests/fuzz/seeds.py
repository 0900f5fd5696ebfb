"""Writes seeds for the fuzz targets: streams of conformance/, payloads of their chunks, and small files of other formats."""

import argparse
import base64
import hashlib
import json
import pathlib
import struct
import zlib

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
MOST = 8 << 10  # bytes of a seed: longer ones slow a target down and show nothing else
STREAM_TARGETS = ["container", "checker", "frames", "file", "stream"]
TOOL_TARGETS = ["demux_tool", "compare_tool", "render_tool", "recover_tool"]


def chunks_of(stream):
    """Type, track, flags and payload of each chunk of a valid stream."""
    at = 24
    while at + 32 <= len(stream):
        kind, flags, _, track = struct.unpack_from("<4sBBH", stream, at)
        (size,) = struct.unpack_from("<Q", stream, at + 16)
        yield kind.decode("latin1"), track, flags, stream[at + 32 : at + 32 + size]
        at += (32 + size + 7) // 8 * 8


def part(payload):
    """As Input::part of fuzz.h takes it."""
    payload = payload[:65535]
    return struct.pack("<H", len(payload)) + payload


class Seeds:
    def __init__(self, folder):
        self.folder = folder
        self.count = 0

    def add(self, target, content):
        if isinstance(content, str):
            content = content.encode()
        if len(content) > MOST:
            return
        folder = self.folder / target
        folder.mkdir(parents=True, exist_ok=True)
        path = folder / hashlib.sha1(content).hexdigest()
        self.count += not path.exists()
        path.write_bytes(content)


def from_stream(seeds, stream):
    """The stream, and inputs of the targets that take payloads."""
    for target in STREAM_TARGETS:
        seeds.add(target, stream)
    chunks = list(chunks_of(stream))
    by_kind = {}
    for kind, track, flags, payload in chunks:
        by_kind.setdefault(kind, []).append((track, flags, payload))
    for number, kind in enumerate(["SCEN", "TRAK", "TILE", "TEXR"]):
        for _, _, payload in by_kind.get(kind, [])[:4]:
            seeds.add("records", bytes([number]) + payload)
    from_meshes(seeds, by_kind)
    for _, _, payload in by_kind.get("BACK", []):
        seeds.add("environment", payload)
    cameras = [payload for _, _, payload in by_kind.get("CAMR", [])][:4]
    if cameras:
        moves = [bytes([flags >> 1 & 1]) + part(payload) for _, flags, payload in by_kind.get("CALB", [])[:4]]
        seeds.add("calibration", b"".join([bytes([len(cameras) - 1]), *map(part, cameras), *moves]))
    for track, _, record in by_kind.get("VCFG", []):
        for other, flags, payload in by_kind.get("VPKT", []):
            if other == track:
                seeds.add("video", bytes([flags >> 1 & 1]) + part(record) + payload)
    for track, _, record in by_kind.get("ACFG", []):
        sounds = [payload for other, _, payload in by_kind.get("AUDI", []) if other == track][:2]
        seeds.add("audio", part(record) + b"\x18" + b"".join(b"\0\0" + part(p) for p in sounds))


def from_tools(seeds, path):
    for target in TOOL_TARGETS:
        seeds.add(target, path.read_bytes())


def from_meshes(seeds, by_kind):
    profiles = {0: "raw", 1: "draco", 4: "fast"}
    key = None
    deltas = []
    for _, _, payload in by_kind.get("MESH", []):
        if payload and payload[0] in profiles:
            seeds.add(profiles[payload[0]], payload)
            if key and deltas:
                seeds.add("delta", part(key) + b"".join(map(part, deltas)))
            key, deltas = payload, []
        elif len(deltas) < 3:
            deltas.append(payload)
    if key:
        seeds.add("delta", part(key) + b"".join(map(part, deltas)))
        for _, _, payload in by_kind.get("VISI", [])[:3]:
            seeds.add("visibility", part(key) + struct.pack("<3h", 0, 0, -3000) + part(payload))
        for _, _, payload in by_kind.get("COLR", [])[:3]:
            seeds.add("colours", part(key) + payload)


def png(depth, colour, rows):
    def chunk(kind, payload):
        return (
            struct.pack(">I", len(payload)) + kind + payload + struct.pack(">I", zlib.crc32(kind + payload))
        )

    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    width = 8
    line = b"\0" + bytes(range(width * channels * depth // 8))
    palette = chunk(b"PLTE", bytes(range(48))) if colour == 3 else b""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, rows, depth, colour, 0, 0, 0))
    pixels = chunk(b"IDAT", zlib.compress(line * rows))
    return b"\x89PNG\r\n\x1a\n" + header + palette + pixels + chunk(b"IEND", b"")


def glb(document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += b"\0" * (-len(binary) % 4)
    size = 12 + 8 + len(text) + 8 + len(binary)
    return (
        b"glTF" + struct.pack("<II", 2, size) + struct.pack("<I", len(text)) + b"JSON" + text
        + struct.pack("<I", len(binary)) + b"BIN\0" + binary
    )  # fmt: skip


def gltf_documents():
    """One triangle: plain, with a morph target, a skin, lights, a texture, and sparse values."""
    positions = struct.pack("<9f", 0, 0, 0, 1, 0, 0, 0, 1, 0)
    uvs = struct.pack("<6f", 0, 0, 1, 0, 0, 1)
    indices = struct.pack("<4H", 0, 1, 2, 0)
    binary = positions + uvs + indices + struct.pack("<2H3f", 1, 0, 0, 2, 0)
    views = [(0, 36), (36, 24), (60, 6), (68, 2), (72, 12)]
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "translation": [1, 2, 3], "rotation": [0, 0, 0, 1], "scale": [1, 1, 2]}],
        "buffers": [{"byteLength": len(binary)}],
        "bufferViews": [{"buffer": 0, "byteOffset": a, "byteLength": n} for a, n in views],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2"},
            {"bufferView": 2, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "meshes": [
            {"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}]}
        ],
        "materials": [{"pbrMetallicRoughness": {"baseColorFactor": [1, 0.5, 0, 1]}}],
    }
    yield document, binary
    sparse = json.loads(json.dumps(document))
    sparse["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": 3, "componentType": 5123},
        "values": {"bufferView": 4},
    }
    yield sparse, binary
    lit = json.loads(json.dumps(document))
    lit["extensionsUsed"] = ["KHR_lights_punctual", "KHR_materials_unlit"]
    lit["extensions"] = {
        "KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {"innerConeAngle": 0.1}}]}
    }
    lit["nodes"][0]["extensions"] = {"KHR_lights_punctual": {"light": 0}}
    lit["materials"][0]["extensions"] = {"KHR_materials_unlit": {}}
    yield lit, binary
    morphed = json.loads(json.dumps(document))
    morphed["meshes"][0]["primitives"][0]["targets"] = [{"POSITION": 0}]
    morphed["meshes"][0]["weights"] = [0.5]
    yield morphed, binary
    skinned = json.loads(json.dumps(document))
    skinned["nodes"].append({"translation": [0, 1, 0]})
    skinned["scenes"][0]["nodes"].append(1)
    skinned["nodes"][0]["skin"] = 0
    skinned["skins"] = [{"joints": [1]}]
    joints = struct.pack("<12B", *[0] * 12) + struct.pack("<12f", *[1, 0, 0, 0] * 3)
    start = len(binary)
    skinned["buffers"][0]["byteLength"] = start + len(joints)
    skinned["bufferViews"] += [
        {"buffer": 0, "byteOffset": start, "byteLength": 12},
        {"buffer": 0, "byteOffset": start + 12, "byteLength": 48},
    ]
    skinned["accessors"] += [
        {"bufferView": 5, "componentType": 5121, "count": 3, "type": "VEC4"},
        {"bufferView": 6, "componentType": 5126, "count": 3, "type": "VEC4"},
    ]
    skinned["meshes"][0]["primitives"][0]["attributes"] |= {"JOINTS_0": 3, "WEIGHTS_0": 4}
    yield skinned, binary + joints
    pictured = json.loads(json.dumps(document))
    picture = base64.b64encode(png(8, 2, 4)).decode()
    pictured["images"] = [{"uri": "data:image/png;base64," + picture}]
    pictured["textures"] = [{"source": 0}]
    pictured["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {"index": 0}
    yield pictured, binary


def meshes(seeds):
    seeds.add(
        "obj",
        "# one\nv 0 0 0\nv 1 0 0 1\nv 0 1 0 .5 .5 .5\nvt 0 1\nvt 1 1 0\nvn 0 0 1\nf 1/1/1 2/2/1 3/-1/-1\ng a\nl 1 2\n",
    )
    seeds.add(
        "obj",
        "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 \\\n0\nf 1 2 3 4\nusemtl x\ns off\nf -4//1 -3//1 -2//1\nvn 1 0 0\n",
    )
    seeds.add(
        "obj", "mtllib a.mtl b c.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl skin of a\nf 1 2 3\nusemtl\nf 3 2 1\n"
    )
    seeds.add(
        "obj",
        "# a library\nnewmtl skin of a\nKd 1 1 1\nmap_Kd -s 1 1 -o 0 0 0 -mm 0 1 -clamp on ..\\atlas\\a b.png\nnewmtl b\nmap_kd 7\n",
    )
    vertices = b"".join(struct.pack("<3f2f", x, y, 0, x, y) for x, y in [(0, 0), (1, 0), (0, 1)])
    for form in ("ascii", "binary_little_endian", "binary_big_endian"):
        header = (
            f"ply\nformat {form} 1.0\ncomment c\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
            "property float s\nproperty float t\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        ).encode()
        if form == "ascii":
            seeds.add("ply", header + b"0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n")
        elif form == "binary_little_endian":
            seeds.add("ply", header + vertices + struct.pack("<B3i", 3, 0, 1, 2))
        else:
            values = struct.unpack("<15f", vertices)
            seeds.add("ply", header + struct.pack(">15f", *values) + struct.pack(">B3i", 3, 0, 1, 2))
    for document, binary in gltf_documents():
        seeds.add("gltf", glb(document, binary))
        document["buffers"][0]["uri"] = (
            "data:application/octet-stream;base64," + base64.b64encode(binary).decode()
        )
        seeds.add("gltf", json.dumps(document))


def pictures(seeds):
    for depth, colour in [(8, 0), (16, 0), (8, 2), (16, 2), (8, 3), (8, 4), (8, 6), (16, 6)]:
        seeds.add("png", png(depth, colour, 4))
    for path in sorted((ROOT / "conformance").glob("**/*.fvv")):
        for kind, _, _, payload in chunks_of(path.read_bytes()):
            if kind == "VPKT" and payload[:2] == b"\xff\xd8":
                seeds.add("jpeg", payload)
            elif kind == "VPKT" and payload[:4] == b"\x76\x2f\x31\x01":
                seeds.add("exr", payload)
            elif kind == "BACK":
                for mark, target in ((b"\x89PNG\r\n", "png"), (b"\xff\xd8\xff", "jpeg")):
                    if (at := payload.find(mark)) >= 0:
                        seeds.add(target, payload[at:])


def captures(seeds):
    camera = {
        "id": 0, "name": "left", "width": 640, "height": 480, "fx": 500, "fy": 500, "cx": 320, "cy": 240,
        "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, 3], "pictures": "left/{frame:04}.png",
    }  # fmt: skip
    for path in sorted((ROOT / "tests").glob("**/*.json")):
        if '"cameras"' in path.read_text(errors="replace"):
            seeds.add("capture", path.read_bytes())
    text = (ROOT / "spec/capture.md").read_text()
    for block in text.split("```")[1::2]:
        body = block.partition("\n")[2]
        if body.lstrip().startswith("{"):
            seeds.add("capture", body)
    seeds.add("capture", json.dumps({"fvv_capture": 1, "name": "a", "frame_rate": 25, "frames": {"first": 0, "count": 2},
                                     "meshes": "m/{frame}.ply", "cameras": [camera]}))  # fmt: skip


def frame_pipes(seeds):
    """Of one camera with masks: a frame, one that is lost, an empty stage; and the same without an end."""
    camera = {
        "id": 0, "width": 16, "height": 8, "intrinsics": {"fx": 20, "fy": 20, "cx": 8, "cy": 4},
        "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]], "translation": [0, 0, 3], "pictures": "%d.png", "masks": "m%d.png",
    }  # fmt: skip
    show = {"fvv_capture": 1, "frame_rate": 25, "frames": {"first": 0, "count": 9}, "units": "metres"}
    text = json.dumps({**show, "meshes": {"pattern": "%d.ply"}, "cameras": [camera]}).encode()
    head = b"\x89FVP\r\n\x1a\n" + struct.pack("<2I", 1, len(text)) + text
    pictures = bytes(range(128)) * 4
    mesh = struct.pack("<9f3I", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 2)
    frame = struct.pack("<4s3I2qQ", b"FRAM", 3, 1, 0, 0, 0, len(mesh + pictures)) + mesh + pictures
    lost = struct.pack("<4s3I2qQ", b"LOST", 0, 0, 0, 1, 0, 4) + b"late"
    empty = struct.pack("<4s3I2qQ", b"FRAM", 0, 0, 0, 2, 1, len(pictures)) + pictures
    end = struct.pack("<4s3I2qQ", b"ENDS", 0, 0, 0, 0, 0, 0)
    seeds.add("frame_pipe", b"\0" + head + frame + lost + empty + end)
    seeds.add("frame_pipe", b"\1" + head + frame + empty)


def calibrations(seeds):
    colmap = (
        b"# Cameras\n1 OPENCV 640 480 500 500 320 240 0.1 0 0 0\n2 SIMPLE_RADIAL 640 480 500 320 240 0.1\n"
    )
    images = b"1 1 0 0 0 0 0 3 1 a.png\n1 2 -1\n2 0.7 0.7 0 0 0 0 3 2 b.png\n\n"
    seeds.add("calibrations", b"\0" + part(colmap) + images)
    matrix = "rows: 3\n   cols: 3\n   dt: d\n   data: [500, 0, 320, 0, 500, 240, 0, 0, 1]"
    yaml = f"""%YAML:1.0
---
image_width: 640
image_height: 480
camera_matrix: !!opencv-matrix
   {matrix}
distortion_coefficients: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [0.1, 0, 0, 0, 0]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [1, 0, 0, 0, 1, 0, 0, 0, 1]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [0, 0, 3]
"""
    seeds.add("calibrations", b"\1" + yaml.encode())
    xml = """<?xml version="1.0"?><opencv_storage><image_width>640</image_width><image_height>480</image_height>
<camera_matrix type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt><data>500 0 320 0 500 240 0 0 1</data></camera_matrix>
<R type_id="opencv-matrix"><rows>3</rows><cols>3</cols><dt>d</dt><data>1 0 0 0 1 0 0 0 1</data></R>
<T type_id="opencv-matrix"><rows>3</rows><cols>1</cols><dt>d</dt><data>0 0 3</data></T></opencv_storage>"""
    seeds.add("calibrations", b"\1" + xml.encode())
    frame = {
        "file_path": "a.png",
        "transform_matrix": [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 3], [0, 0, 0, 1]],
    }
    nerf = {"w": 640, "h": 480, "fl_x": 500, "fl_y": 500, "cx": 320, "cy": 240, "k1": 0.1, "frames": [frame]}
    seeds.add("calibrations", b"\2" + json.dumps(nerf).encode())
    qualisys = """<calibration><cameras><camera active="1" serial="1" model="Miqus"><fov_video left="0" top="0" right="639" bottom="479"/>
<transform x="0" y="0" z="3000" r11="1" r12="0" r13="0" r21="0" r22="1" r23="0" r31="0" r32="0" r33="1"/>
<intrinsic focallength="10" sensorMinU="0" sensorMaxU="40960" sensorMinV="0" sensorMaxV="30720" focalLengthU="32000"
focalLengthV="32000" centerPointU="20000" centerPointV="15000" skew="0" radialDistortion1="0" radialDistortion2="0"
radialDistortion3="0" tangentalDistortion1="0" tangentalDistortion2="0"/></camera></cameras></calibration>"""
    seeds.add("calibrations", b"\3" + qualisys.encode())
    seeds.add("calibrations", b"\4" + b"1\na.png 500 0 320 0 500 240 0 0 1 1 0 0 0 1 0 0 0 1 0 0 3\n")
    seeds.add(
        "calibrations", b"\5" + b"# X Y Z C U V\n" + b"".join(b"%d 0 1 0 50 %d\n" % (i, i) for i in range(9))
    )
    models = struct.pack("<QIiQQ8d", 2, 1, 4, 640, 480, 500, 500, 320, 240, 0.1, 0, 0, 0)
    models += struct.pack("<IiQQ4d", 2, 2, 640, 480, 500, 320, 240, 0.1)
    views = struct.pack("<QI7dI6sQddq", 2, 1, 1, 0, 0, 0, 0, 0, 3, 1, b"a.png", 1, 1, 2, -1)
    views += struct.pack("<I7dI6sQ", 2, 1, 0, 0, 0, 0, 0, 3, 2, b"b.png", 0)
    seeds.add("calibrations", b"\6" + part(models) + views)
    krt = b"1\n500 0 320\n0 500 240\n0 0 1\n0.1 0 0 0 0\n1 0 0 0\n0 1 0 0\n0 0 1 3\n\n2\n500 0 320\n0 500 240\n0 0 1\n"
    seeds.add("calibrations", b"\7" + krt + b"1 0 0\n0 1 0\n0 0 1\n0 0 3\n")
    mvsnet = b"extrinsic\n1 0 0 0\n0 1 0 0\n0 0 1 3\n0 0 0 1\n\nintrinsic\n500 0 320\n0 500 240\n0 0 1\n\n425 2.5\n"
    seeds.add("calibrations", b"\7" + mvsnet)
    panoptic = {"name": "00_00", "resolution": [640, 480], "K": [[500, 0, 320], [0, 500, 240], [0, 0, 1]]}
    panoptic.update(distCoef=[0.1, 0, 0, 0, 0], R=[[1, 0, 0], [0, 1, 0], [0, 0, 1]], t=[[0], [0], [300]])
    seeds.add("calibrations", b"\b" + json.dumps({"cameras": [panoptic]}).encode())
    seeds.add("calibrations", b"\b" + json.dumps({"left": panoptic}).encode())
    matrix = (
        "%YAML:1.0\n---\nnames: [ a ]\nK_a: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, 0, 0, 1]}\n"
    )
    pose = "%YAML:1.0\n---\nR_a: [0, 0.5, 0]\nT_a: [0, 0, 3]\n"
    seeds.add("calibrations", b"\t" + part((matrix + "dist_a: [0.1, 0, 0, 0, 0]\n").encode()) + pose.encode())
    toml = "[cam_0]\nname = 'a'\nsize = [640, 480]\nmatrix = [[500.0, 0, 320], [0, 500, 240], [0, 0, 1]]\n"
    toml += "distortions = [0.1, 0, 0, 0, 0]\nrotation = [0, 0.5, 0]\ntranslation = [0, 0, 3]\n[metadata]\nerror = 0.1\n"
    seeds.add("calibrations", b"\n" + toml.encode())
    chain = "  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  resolution: [640, 480]\n"
    chain += "  distortion_model: radtan\n  distortion_coeffs: [0.1, 0, 0, 0]\n"
    step = "  T_cn_cnm1: [[1, 0, 0, 0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]\n"
    seeds.add("calibrations", b"\v" + f"cam0:\n{chain}cam1:\n{step}{chain}".encode())
    metashape = '<document><chunk><sensors><sensor id="0" type="frame"><resolution width="640" height="480"/>'
    metashape += (
        '<calibration class="adjusted"><f>500</f><k1>0.1</k1><b2>1</b2></calibration></sensor></sensors>'
    )
    metashape += (
        '<cameras><camera sensor_id="0" label="a"><transform>1 0 0 0 0 1 0 0 0 0 1 -3 0 0 0 1</transform>'
    )
    metashape += "</camera></cameras><transform><scale>2</scale></transform></chunk></document>"
    seeds.add("calibrations", b"\f" + metashape.encode())
    table = "#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\na.jpg,1,2,3,10,20,30,28,0,0,0.1,0,0,0,0,0\n"
    seeds.add("calibrations", b"\r" + table.encode())
    xmp = '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF><rdf:Description xcr:DistortionModel="brown3"'
    xmp += (
        ' xcr:FocalLength35mm="28" xcr:DistortionCoeficients="0.1 0 0 0 0 0"><xcr:Rotation>1 0 0 0 1 0 0 0 1'
    )
    xmp += "</xcr:Rotation><xcr:Position>0 0 -3</xcr:Position></rdf:Description></rdf:RDF></x:xmpmeta>"
    seeds.add("calibrations", b"\x0e" + xmp.encode())


def paths(seeds):
    keys = [
        {"time": 0, "position": [2, 1.6, 2.5], "target": [0, 1, 0], "fov": 60},
        {"time": 1.5, "position": [0, 2, 3], "target": [0, 1, 0], "fov": 40},
        {"time": 3, "position": [-2, 1.2, 2.5], "target": [0, 1, 0], "fov": 60},
    ]
    seeds.add("path", json.dumps(keys))
    seeds.add("path", json.dumps([{"time": 0, "position": [0, 0, 1], "target": [0, 0, 0], "up": [0, 0, 1]}]))


def programs(seeds):
    """For targets whose input is a program: a few that go through, the rest is found by mutation."""
    for i in range(6):
        numbers = bytes((i * 37 + k * 11) & 255 for k in range(400))
        for target in ("writer", "mesh_encode", "encoder", "merge_tool"):
            seeds.add(target, numbers)
    # A scene, two groups with meshes, the end.
    group = bytes([3, 1, 9]) + bytes([7, 1, 0, 1, 1, 1, *range(12), 0]) * 2 + bytes([5])
    seeds.add("writer", bytes([1, 1, 1, 1]) + group * 2 + bytes([6, 0]))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, help="one folder for each target is made in it")
    options = parser.parse_args()
    seeds = Seeds(options.folder)
    for path in sorted((ROOT / "conformance").glob("**/*.fvv")):
        from_stream(seeds, path.read_bytes())
        if "faulty" not in path.parts:  # these end where a reader does, which other targets follow
            from_tools(seeds, path)
    for path in sorted((ROOT / "tests/tools/cli/hostile").glob("*.fvv")):
        from_stream(seeds, path.read_bytes())
        from_tools(seeds, path)
    for write in (meshes, pictures, captures, frame_pipes, calibrations, paths, programs):
        write(seeds)
    print(f"{seeds.count} new seeds in {options.folder}")


if __name__ == "__main__":
    main()
