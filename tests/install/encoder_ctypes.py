"""Encodes the frames of consumer_encode.cpp by the shared library of the encoder, without any other binding.

encoder_ctypes.py LIBRARY OUTPUT: libfvv is beside LIBRARY, libfvv_encoder
"""

import ctypes as c
import math
import sys


class Rational(c.Structure):
    _fields_ = [("numerator", c.c_uint32), ("denominator", c.c_uint32)]


class Diagnostic(c.Structure):
    _fields_ = [
        ("status", c.c_int32),
        ("issue", c.c_uint32),
        ("chunk_type", c.c_uint32),
        ("offset", c.c_uint64),
        ("chunk_offset", c.c_uint64),
        ("message", c.c_char * 208),
    ]


class Option(c.Structure):
    _fields_ = [("name", c.c_char_p), ("value", c.c_char_p)]


class Options(c.Structure):
    _fields_ = [
        ("struct_size", c.c_size_t),
        ("name", c.c_char_p),
        ("frame_duration", Rational),
        ("codec", c.c_uint32),
        ("bit_depth", c.c_uint32),
        ("psnr", c.c_double),
        ("bit_rate", c.c_uint64),
        ("max_error", c.c_double),
        ("group", c.c_uint32),
        ("threads", c.c_uint32),
        ("without_meshes", c.c_uint8),
        ("up", c.c_uint8),
        ("scale_unknown", c.c_uint8),
        ("named", c.POINTER(Option)),
        ("named_count", c.c_size_t),
        ("warning", c.CFUNCTYPE(None, c.c_void_p, c.c_char_p)),
        ("progress", c.CFUNCTYPE(c.c_int32, c.c_void_p, c.c_uint64)),
        ("user", c.c_void_p),
    ]


class Output(c.Structure):
    _fields_ = [("write", c.CFUNCTYPE(c.c_int32, c.c_void_p, c.c_void_p, c.c_size_t)), ("user", c.c_void_p)]


class Calibration(c.Structure):
    _fields_ = [
        ("id", c.c_uint16),
        ("lens", c.c_uint8),
        ("flags", c.c_uint8),
        ("width", c.c_uint32),
        ("height", c.c_uint32),
        *[(name, c.c_double) for name in ("fx", "fy", "cx", "cy", "skew")],
        ("distortion", c.c_double * 8),
        ("r_max", c.c_double),
        ("rotation", c.c_double * 9),
        ("translation", c.c_double * 3),
        ("name", c.c_char_p),
        ("name_size", c.c_size_t),
    ]


class Camera(c.Structure):
    _fields_ = [
        ("struct_size", c.c_size_t),
        ("calibration", c.POINTER(Calibration)),
        *[(name, c.c_uint8) for name in ("without_pictures", "has_masks", "moves", "has_visibility")],
    ]


class Picture(c.Structure):
    _fields_ = [
        ("pixels", c.c_void_p),
        *[(name, c.c_uint32) for name in ("width", "height", "channels", "bits")],
        ("stride", c.c_size_t),
    ]


class Frame(c.Structure):
    _fields_ = [
        ("struct_size", c.c_size_t),
        ("positions", c.POINTER(c.c_double)),
        ("vertex_count", c.c_size_t),
        ("faces", c.POINTER(c.c_uint32)),
        ("face_count", c.c_size_t),
        ("texture", c.POINTER(c.c_double)),
        ("normals", c.POINTER(c.c_double)),
        ("camera_count", c.c_size_t),
        ("pictures", c.POINTER(Picture)),
        ("masks", c.POINTER(Picture)),
        ("calibrations", c.POINTER(Calibration)),
        ("visibility", c.POINTER(c.c_char_p)),
    ]


def main():
    library = c.CDLL(sys.argv[1])
    encoder, diagnostic = c.c_void_p(), Diagnostic()

    def call(name, *arguments):
        if getattr(library, "fvv_encoder_" + name)(*arguments, c.byref(diagnostic)) < 0:
            sys.exit(f"{name}: {diagnostic.message.decode()}")

    out = bytearray()

    def write(_user, data, size):
        out.extend(c.string_at(data, size))
        return 0

    output = Output(Output._fields_[0][1](write))
    named = (Option * 1)((b"codec", b"jpeg"))
    options = Options(struct_size=c.sizeof(Options), group=5, named=named, named_count=1)
    call("create", c.byref(options), c.byref(output), c.byref(encoder))
    calibration = Calibration(width=64, height=48, fx=60, fy=60, cx=32, cy=24)
    calibration.rotation[0] = calibration.rotation[4] = calibration.rotation[8] = 1
    calibration.translation[2] = 3
    r_max = c.CDLL(sys.argv[1].replace("libfvv_encoder", "libfvv")).fvv_camera_r_max
    r_max.restype = c.c_double
    calibration.r_max = r_max(c.byref(calibration))
    camera = Camera(c.sizeof(Camera), c.pointer(calibration))
    call("add_camera", encoder, c.byref(camera))
    faces = (c.c_uint32 * 18)(0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4, 0, 2, 1, 0, 3, 2)
    for i in range(10):
        x, y = math.cos(i / 10), math.sin(i / 10)
        positions = (c.c_double * 15)(x, y, 0, -y, x, 0, -x, -y, 0, y, -x, 0, 0, 0, -1)
        pixels = c.create_string_buffer(bytes([20 * i]) * (64 * 48 * 3), 64 * 48 * 3)
        picture = Picture(c.cast(pixels, c.c_void_p), 64, 48, 3, 8)
        frame = Frame(c.sizeof(Frame), positions, 5, faces, 6, camera_count=1, pictures=c.pointer(picture))
        call("add_frame", encoder, c.byref(frame))
    positions[4] = math.nan
    if library.fvv_encoder_add_frame(encoder, c.byref(frame), c.byref(diagnostic)) != -6:
        sys.exit("a vertex that is not a number was accepted")
    if b"frame 10" not in diagnostic.message:
        sys.exit(f"expected the frame's number, found {diagnostic.message}")
    call("finish", encoder, None)
    library.fvv_encoder_destroy(encoder)
    with open(sys.argv[2], "wb") as file:
        file.write(out)
    print("10 frames")


if __name__ == "__main__":
    main()
