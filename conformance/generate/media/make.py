#!/usr/bin/env python3
"""Makes the ingredients that other encoders write: coded video, sound, pictures and Draco meshes, one JSON file each.

The files are kept, so that the cases can be generated without these encoders; run this only to add one. It needs
PyAV, Pillow and, for Draco, node with js/node_modules. usage: make.py [draco|video|sound|pictures ...]
"""

import base64
import io
import json
import pathlib
import struct
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent.parent))

WIDTH, HEIGHT = 64, 32


def write(name, value):
    (HERE / f"{name}.json").write_text(json.dumps(value, indent=1) + "\n")


def encoded(data):
    return base64.b64encode(bytes(data)).decode()


def flat(rows):
    return [int(x) for row in rows for x in row] or None


def draco():
    from generate import meshes

    def shape(name, mesh, speed, **more):
        return {
            "name": name,
            "speed": speed,
            "positions": flat(mesh.positions),
            "faces": flat(mesh.faces),
            "texture": flat(mesh.texture),
            "normals": flat(mesh.normals),
        } | more

    ball = meshes.ball(8, 12)
    both = meshes.with_normals(meshes.textured(meshes.grid(9, 7), 12), 10)
    shapes = [
        shape("tetrahedron", meshes.TETRAHEDRON, 5),
        shape("triangle", meshes.TRIANGLE, 5),
        shape("octahedron_sequential", meshes.OCTAHEDRON, 5, sequential=True),
        *[shape(f"ball_speed_{speed}", ball, speed) for speed in (0, 2, 5, 8, 10)],
        shape("ball_decoded", ball, 5, decoded=True),
        shape("grid_valence", meshes.grid(20, 20), 0),
        shape("grid_large", meshes.grid(60, 50), 3),
        shape("grid_sequential", meshes.grid(12, 9), 5, sequential=True),
        shape("grid_textured", meshes.textured(meshes.grid(9, 7), 12), 7),
        shape("grid_textured_sequential", meshes.textured(meshes.grid(9, 7), 12), 7, sequential=True),
        shape("grid_normals", meshes.with_normals(meshes.grid(9, 7), 10), 7),
        shape("grid_both", both, 7),
        shape("grid_both_sequential", both, 7, sequential=True),
        shape("strip", meshes.strip(12), 5),
        shape("corner", meshes.CORNER, 5),
        shape("torus", meshes.torus(9, 6), 5),
        *[shape(f"torus_speed_{speed}", meshes.torus(36, 14), speed) for speed in (0, 4)],
        shape("holed", meshes.holed(14, 12, 11), 5),
        shape("holed_valence", meshes.holed(28, 26, 11), 1),
        shape(
            "pieces",
            meshes.together(meshes.torus(8, 5), meshes.TRIANGLE, meshes.holed(8, 7, 7), meshes.torus(6, 4)),
            5,
        ),
        shape("hubs", meshes.holed_hubs(400), 5),
        # Not as clause 8.4 has them.
        shape("bad_float", meshes.TETRAHEDRON, 5, floats=True),
        shape("bad_beyond", meshes.BEYOND_CORNER, 5),
        shape("bad_steps", meshes.holed_hubs(600), 5),
        shape("bad_texture_range", meshes.textured(meshes.grid(4, 4), 12), 7),
    ]
    with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
        json.dump(shapes, file)
        file.flush()
        done = subprocess.run(["node", HERE / "make_draco.mjs", file.name], check=True, capture_output=True)
    (HERE / "draco.json").write_bytes(done.stdout)


def picture(number, width=WIDTH, height=HEIGHT):
    """RGB: a gradient and a square that moves."""
    import numpy

    y, x = numpy.mgrid[0:height, 0:width]
    rgb = numpy.stack([x * 255 // width, y * 255 // height, (x + y + 20 * number) % 256], axis=2)
    at = 6 * number
    rgb[8:20, at : at + 12] = (240, 200, 40)
    return rgb.astype("uint8")


def coded(encoder, pixel_format, options, frames=6, gop=3, width=WIDTH, height=HEIGHT, **settings):
    """Packets (key, bytes) and extradata as MP4 stores them."""
    import av

    file = io.BytesIO()
    with av.open(file, "w", format="mp4") as out:
        stream = out.add_stream(encoder, rate=25, options=options)
        stream.width, stream.height, stream.pix_fmt = width, height, pixel_format
        stream.codec_context.gop_size = gop
        stream.codec_context.thread_count = 1
        for name, value in settings.items():
            setattr(stream.codec_context, name, value)
        for number in range(frames):
            frame = av.VideoFrame.from_ndarray(picture(number, width, height), "rgb24").reformat(
                format=pixel_format
            )
            frame.pts = number
            for packet in stream.encode(frame):
                out.mux(packet)
        for packet in stream.encode():
            out.mux(packet)
    file.seek(0)
    with av.open(file) as back:
        video = back.streams.video[0]
        packets = [(packet.is_keyframe, bytes(packet)) for packet in back.demux(video) if packet.size]
        return packets, bytes(video.codec_context.extradata or b"")


def sample_list(packets):
    return [{"key": bool(key), "data": encoded(data)} for key, data in packets]


def video_file(name, codec, depth, string, record, packets, width=WIDTH, height=HEIGHT):
    write(
        name,
        {
            "codec": codec,
            "width": width,
            "height": height,
            "bit_depth": depth,
            "codec_string": string,
            "record": encoded(record),
            "samples": sample_list(packets),
        },
    )


def hevc_string(record):
    profile, tier = record[1] & 31, "H" if record[1] & 32 else "L"
    compatibility = int(f"{struct.unpack('>I', record[2:6])[0]:032b}"[::-1], 2)
    constraints = record[6:12].rstrip(b"\0")
    parts = [f"hvc1.{profile}", f"{compatibility:X}", f"{tier}{record[12]}"]
    return ".".join(parts + [f"{byte:X}" for byte in constraints])


def by_command(pixel_format, options):
    """As coded, by the program ffmpeg: PyAV's libvpx has 8 bits only."""
    import av

    raw = b"".join(picture(number).tobytes() for number in range(6))
    source = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{WIDTH}x{HEIGHT}", "-r", "25", "-i", "-"]
    with tempfile.NamedTemporaryFile(suffix=".mp4") as out:
        command = [
            "ffmpeg",
            "-v",
            "error",
            "-y",
            *source,
            "-pix_fmt",
            pixel_format,
            "-g",
            "3",
            *options,
            out.name,
        ]
        subprocess.run(command, input=raw, check=True)
        with av.open(out.name) as back:
            return [(p.is_keyframe, bytes(p)) for p in back.demux(back.streams.video[0]) if p.size]


def vp9(name, pixel_format, profile, depth):
    options = {"crf": "30", "b": "0", "lag-in-frames": "0", "cpu-used": "5"}
    if depth == 8:
        packets, _ = coded("libvpx-vp9", pixel_format, options)
    else:
        command = ["-c:v", "libvpx-vp9", "-b:v", "0", "-crf", "30", "-lag-in-frames", "0", "-cpu-used", "5"]
        packets = by_command(pixel_format, command)
    level = 10
    # 4:2:0 colocated, limited range, BT.709.
    record = struct.pack(">BBHBBBBBBH", 1, 0, 0, profile, level, depth << 4 | 1 << 1, 1, 1, 1, 0)
    video_file(name, "vp09", depth, f"vp09.{profile:02}.{level}.{depth:02}", record, packets)


def av1(name, encoder, pixel_format, depth, options):
    packets, record = coded(encoder, pixel_format, options)
    profile, level = record[1] >> 5, record[1] & 31
    tier = "H" if record[2] & 128 else "M"
    video_file(name, "av01", depth, f"av01.{profile}.{level:02}{tier}.{depth:02}", record, packets)


def video():
    x264 = {"crf": "30", "preset": "medium", "bf": "0", "x264-params": "sliced-threads=0:bframes=0:aud=0"}
    for name, profile in ("h264", "high"), ("h264_baseline", "baseline"), ("h264_main", "main"):
        packets, record = coded("libx264", "yuv420p", x264 | {"profile": profile})
        packets = [(key, without_sei(data)) for key, data in packets]
        video_file(name, "avc1", 8, f"avc1.{record[1:4].hex()}", record, packets)
    packets, record = coded(
        "libx264", "yuv420p", x264 | {"profile": "high", "x264-params": "slices=2:bframes=0"}
    )
    video_file("h264_slices", "avc1", 8, f"avc1.{record[1:4].hex()}", record, packets)
    for name, pixel_format, depth in ("hevc", "yuv420p", 8), ("hevc_10", "yuv420p10le", 10):
        parameters = (
            "bframes=0:info=0:repeat-headers=0:log-level=none:open-gop=0:keyint=3:pools=1:frame-threads=1"
        )
        packets, record = coded(
            "libx265", pixel_format, {"crf": "30", "x265-params": parameters, "tag": "hvc1"}
        )
        record = complete(record)
        video_file(name, "hvc1", depth, hevc_string(record), record, packets)
    vp9("vp9", "yuv420p", 0, 8)
    vp9("vp9_10", "yuv420p10le", 2, 10)
    options = {"crf": "45", "cpu-used": "8", "lag-in-frames": "0", "usage": "realtime"}
    av1("av1", "libaom-av1", "yuv420p", 8, options)
    av1("av1_10", "libaom-av1", "yuv420p10le", 10, options)
    jpeg()


def without_sei(sample):
    """x264 puts its name and options into an SEI of the first sample."""
    out = at = 0
    out = b""
    while at < len(sample):
        size = struct.unpack_from(">I", sample, at)[0]
        if sample[at + 4] & 31 != 6:
            out += sample[at : at + 4 + size]
        at += 4 + size
    return out


def complete(record):
    """hvcC with array_completeness 1 and only parameter sets."""
    at, arrays = 23, []
    for _ in range(record[22]):
        kind, count, begin = record[at] & 63, struct.unpack_from(">H", record, at + 1)[0], at + 1
        at += 3
        for _ in range(count):
            at += 2 + struct.unpack_from(">H", record, at)[0]
        if kind in (32, 33, 34):
            arrays.append((kind, record[begin:at]))
    arrays.sort()
    return record[:22] + bytes([len(arrays)]) + b"".join(bytes([128 | k]) + a for k, a in arrays)


def jpeg():
    from PIL import Image

    def file(number, mode="RGB", **options):
        out = io.BytesIO()
        Image.fromarray(picture(number)).convert(mode).save(out, "JPEG", **options)
        return out.getvalue()

    kinds = {
        "jpeg": {},
        "jpeg_grey": {"mode": "L"},
        "jpeg_444": {"subsampling": 0},
        "jpeg_progressive": {"progressive": True},
    }
    for name, options in kinds.items():
        samples = [(True, file(number, quality=50, **options)) for number in range(3)]
        video_file(name, "jpeg", 8, "", b"", samples)
    samples = [(True, file(0, quality=50, mode="CMYK"))]
    video_file("jpeg_cmyk", "jpeg", 8, "", b"", samples)


def sound():
    import av
    import numpy

    def packets(encoder, rate, layout, channels, options, bit_rate, seconds=0.4):
        codec = av.CodecContext.create(encoder, "w")
        codec.sample_rate, codec.layout, codec.options = rate, layout, options
        codec.format, codec.bit_rate = "fltp" if encoder == "aac" else "s16", bit_rate
        found, times = [], numpy.arange(int(rate * seconds)) / rate
        size = 1024 if encoder == "aac" else rate // 50
        wave = 0.3 * numpy.sin(2 * numpy.pi * 440 * times)
        for first in range(0, len(wave) - size + 1, size):
            part = numpy.stack([wave[first : first + size] * (1 - 0.2 * c) for c in range(channels)])
            if encoder == "aac":
                frame = av.AudioFrame.from_ndarray(part.astype("float32"), format="fltp", layout=layout)
            else:
                mixed = (part.T.reshape(1, -1) * 32767).astype("int16")
                frame = av.AudioFrame.from_ndarray(mixed, format="s16", layout=layout)
            frame.sample_rate, frame.pts = rate, first
            found += [bytes(packet) for packet in codec.encode(frame)]
        found += [bytes(packet) for packet in codec.encode(None)]
        return found, bytes(codec.extradata or b"")

    out = {}
    for name, encoder, rate, layout, channels, bit_rate in (
        ("opus_mono", "libopus", 48000, "mono", 1, 16000),
        ("opus_stereo", "libopus", 48000, "stereo", 2, 24000),
        ("aac_44100", "aac", 44100, "mono", 1, 24000),
        ("aac_stereo", "aac", 48000, "stereo", 2, 32000),
    ):
        found, record = packets(encoder, rate, layout, channels, {}, bit_rate)
        out[name] = {"rate": rate, "channels": channels, "record": encoded(record)}
        out[name]["packets"] = [encoded(packet) for packet in found if packet]
    write("sound", out)


def pictures():
    from PIL import Image

    def file(kind, mode, width, height, **options):
        out = io.BytesIO()
        Image.fromarray(picture(1, width, height)).convert(mode).save(out, kind, **options)
        return {"width": width, "height": height, "data": encoded(out.getvalue())}

    write(
        "pictures",
        {
            "png": file("PNG", "RGB", 24, 20),
            "png_grey": file("PNG", "L", 17, 23),
            "png_alpha": file("PNG", "RGBA", 24, 20),
            "png_palette": file("PNG", "P", 24, 20),
            "jpeg": file("JPEG", "RGB", 24, 20, quality=60),
            "jpeg_grey": file("JPEG", "L", 24, 20, quality=60),
            "jpeg_progressive": file("JPEG", "RGB", 24, 20, quality=60, progressive=True),
        },
    )


def main():
    parts = {"draco": draco, "video": video, "sound": sound, "pictures": pictures}
    for name in sys.argv[1:] or parts:
        parts[name]()


if __name__ == "__main__":
    main()
