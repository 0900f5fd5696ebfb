"""Fuzzes the Python bindings with atheris: files, push reading, checks and the writing of arrays raise fvv's own errors only.

The extension module is not instrumented; atheris is guided by the coverage of the package's Python code, and inputs come
from the corpora of the targets that read streams.
"""

import argparse
import contextlib
import pathlib
import struct
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
PACKAGE = ROOT / "build/default/bindings/python"


def crc_table():
    table = []
    for value in range(256):
        for _ in range(8):
            value = value >> 1 ^ (0x82F63B78 if value & 1 else 0)
        table.append(value)
    return table


TABLE = crc_table()


def crc32c(data, before=0):
    value = before ^ 0xFFFFFFFF
    for byte in data:
        value = value >> 8 ^ TABLE[(value ^ byte) & 255]
    return value ^ 0xFFFFFFFF


def repaired(stream):
    """CRCs of all chunks, and digests and chains of groups, so that changed payloads are read."""
    out = bytearray(stream)
    if len(out) >= 24:
        struct.pack_into("<I", out, 20, crc32c(out[:20]))
    at, digest, chain, in_group = 24, 0, 0, False
    while at + 32 <= len(out):
        kind = bytes(out[at : at + 4])
        (size,) = struct.unpack_from("<Q", out, at + 16)
        size = min(size, len(out) - at - 32)
        struct.pack_into("<Q", out, at + 16, size)
        if kind == b"SCEN":
            digest, in_group = 0, False
        elif kind == b"GRUP" and size >= 8:
            struct.pack_into("<I", out, at + 36, digest)
            chain, in_group = 0, True
        elif kind == b"GEND" and size >= 12:
            struct.pack_into("<I", out, at + 40, chain)
            in_group = False
        struct.pack_into("<I", out, at + 24, crc32c(out[at + 32 : at + 32 + size]))
        struct.pack_into("<I", out, at + 28, crc32c(out[at : at + 28]))
        if in_group:
            chain = crc32c(out[at : at + 28], chain)
        else:
            digest = crc32c(out[at : at + 28], digest)
        at += 32 + (size + 7) // 8 * 8
    return bytes(out)


def touch(fvv, frame):
    """Reads all that a frame has, each as if it were the only thing that is wanted."""
    for read in (
        lambda: (frame.mesh.lattice, frame.mesh.indices, frame.mesh.positions) if frame.mesh else None,
        lambda: [camera.project(frame.mesh.positions[:4]) for camera in frame.cameras.values()]
        if frame.mesh
        else None,
        lambda: frame.visibility,
        lambda: frame.pictures,
    ):
        with contextlib.suppress(fvv.Error):
            read()


def read(fvv, stream):
    with contextlib.suppress(fvv.Error), fvv.open(stream) as clip:
        for number in range(min(len(clip), 20)):
            with contextlib.suppress(fvv.Error):
                touch(fvv, clip[number])
        list(clip.problems)


def push(fvv, stream):
    step = 1 + crc32c(stream[:64]) % 700
    with contextlib.suppress(fvv.Error):
        reader = fvv.Reader(visibility=True, sound=True)
        for at in range(0, len(stream), step):
            for event in reader.feed(stream[at : at + step]):
                if isinstance(event, fvv.FrameEvent):
                    touch(fvv, event.frame)
        reader.finish()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--available", action="store_true", help="say whether it can run here")
    parser.add_argument("--seconds", type=int, default=10)
    parser.add_argument("--crashes", default=".", help="folder for inputs that fail")
    parser.add_argument("folders", nargs="*", help="inputs; the first also receives what is found")
    options = parser.parse_args()
    sys.path.insert(0, str(PACKAGE))
    try:
        import atheris
    except ImportError:
        print("no atheris: pip install -r tests/fuzz/requirements.txt")
        return 1
    try:
        with atheris.instrument_imports(include=["fvv"]):
            import fvv
    except ImportError as error:
        print(f"no package fvv in build/default: configure with -DFVV_PYTHON_PACKAGE=ON ({error})")
        return 1
    if options.available:
        return 0
    for folder in [options.crashes, *options.folders]:
        pathlib.Path(folder).mkdir(parents=True, exist_ok=True)

    def mutate(data, capacity, _):
        changed = atheris.Mutate(bytes(data), capacity)
        return repaired(changed)[:capacity] if changed[-1:] != b"\1" else changed

    executions = 0
    end = time.monotonic() + options.seconds

    def one(data):
        nonlocal executions
        executions += 1
        (read if executions % 2 else push)(fvv, bytes(data))

    arguments = [
        "fuzz_bindings",
        f"-max_total_time={max(1, round(end - time.monotonic()))}",
        "-timeout=10",
        "-max_len=16384",
    ]
    arguments += [f"-artifact_prefix={options.crashes}/", "-print_final_stats=1", *options.folders]
    atheris.Setup(arguments, one, custom_mutator=mutate)
    atheris.Fuzz()
    return 0


if __name__ == "__main__":
    sys.exit(main())
