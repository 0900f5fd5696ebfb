"""What a stream is: the document of `fvvinfo --json`, and the text of one screen of `python -m fvv info`."""

from __future__ import annotations

import json
from typing import Any

from . import _core
from .clip import Clip
from .errors import DamagedError
from .sources import Readable, Source


def inspect(source: Readable, *, decode: bool = False, chunks: bool = False) -> dict[str, Any]:
    """The document that `fvvinfo --json` prints of a stream (spec/fvvinfo.schema.json), from the same function.

    source: as of `fvv.open`. decode: decode meshes and check video samples too, as `--check`. chunks: list every chunk.
    Damage is in the document; OSError where the source cannot be read.
    """
    found: dict[str, Any] = json.loads(document(source, decode=decode, chunks=chunks))
    return found


def document(source: Readable, *, decode: bool = False, chunks: bool = False) -> str:
    """What `inspect` returns, as text."""
    what = Source(source)
    return _core.inspect(what.core, what.name, decode, chunks)


def _described(clip: Clip) -> dict[str, Any]:
    """What `text` shows: bytes, seconds, tracks with what they send, cameras, sound, and damage that was met. Decodes the mesh of
    the first frame that is whole, and no pictures."""
    chunks = clip.chunks()
    return {
        "file": clip.name,
        "bytes": clip.size,
        "frames": len(clip),
        "groups": len(set(chunks["group"].tolist())),
        "start": clip.start,
        "duration": clip.duration,
        "rate": float(clip.rate),
        "up": clip.up,
        "tracks": [
            _track(track, chunks[chunks["track"] == track.id], clip.duration) for track in clip.tracks
        ],
        "rungs": [{"rung": one.number, "tracks": list(one.tracks), "scale": one.scale} for one in clip.rungs],
        "cameras": _cameras(clip),
        "mesh": _mesh(clip),
        "sound": [
            {
                "track": sound.track,
                "title": sound.title,
                "codec": sound.codec,
                "rate": sound.rate,
                "channels": sound.channels,
                "start": sound.start,
                "duration": sound.duration,
            }
            for sound in clip.audio
        ],
        "problems": [str(problem) for problem in clip.problems],
    }


def _track(track: Any, chunks: Any, seconds: float) -> dict[str, Any]:
    size = int(chunks["size"].sum())
    chunks = chunks[chunks["type"] != b"TILE"]  # layouts of groups
    return {
        "track": track.id,
        "kind": track.kind,
        "name": track.name,
        "selected": track.selected,
        "chunks": len(chunks),
        "key_chunks": int(chunks["key"].sum()),
        "bytes": size,
        "bits_per_second": 8 * size / seconds if seconds else None,
    }


def _first_frame(clip: Clip) -> Any:
    return next((frame for frame in clip if frame.intact), None)


def _cameras(clip: Clip) -> list[dict[str, Any]]:
    frame = _first_frame(clip)
    if frame is None:
        return []
    return [
        {
            "id": camera.id,
            "name": camera.name,
            "width": camera.width,
            "height": camera.height,
            "lens": camera.lens,
            "moves": camera.moves,
        }
        for camera in frame.cameras.values()
    ]


def _mesh(clip: Clip) -> dict[str, Any] | None:
    frame = _first_frame(clip)
    try:
        mesh = frame and frame.mesh
    except DamagedError:
        return None
    if mesh is None or not mesh.vertex_count:
        return None
    low, high = mesh.positions.min(axis=0), mesh.positions.max(axis=0)
    return {
        "frame": frame.number,
        "vertices": mesh.vertex_count,
        "faces": mesh.face_count,
        "step": mesh.step,
        "size": [float(side) for side in high - low],
    }


def _amount(size: float) -> str:
    for unit in ("bytes", "kB", "MB", "GB"):
        if size < 1000 or unit == "GB":
            break
        size /= 1000
    return (
        f"{size:.0f} {unit}"
        if unit == "bytes"
        else f"{size:.3g} {unit}"
        if size < 1000
        else f"{size:.0f} {unit}"
    )


def _rate(bits: float | None) -> str:
    if bits is None:
        return ""
    return f"{bits / 1e6:.2f} Mbit/s" if bits >= 1e6 else f"{bits / 1e3:.1f} kbit/s"


def text(clip: Clip) -> str:
    """A rung of a clip for people, on one screen: long lists are cut, with the number of what is left out."""
    found = _described(clip)
    seconds, size = found["duration"], found["bytes"]
    lines = [
        found["file"],
        f"  {seconds:.2f} s: {found['frames']} frames at {found['rate']:g} Hz in {found['groups']} groups",
        f"  {_amount(size)}" + (f", {_rate(8 * size / seconds)} with the container" if seconds else ""),
    ]
    if found["mesh"]:
        mesh = found["mesh"]
        sides = " x ".join(f"{side:.2f}" for side in mesh["size"])
        lines.append(
            f"  frame {mesh['frame']}: {mesh['vertices']:,} vertices, {mesh['faces']:,} faces, {sides} m, "
            f"lattice of {1000 * mesh['step']:.3g} mm, up {found['up'] or 'not stated'}"
        )
    lines.append("tracks")
    rows: list[tuple[str, ...]] = [
        (
            str(track["track"]),
            track["kind"],
            "" if track["name"] == track["kind"] else track["name"],
            f"{track['chunks']} chunks",
            f"{track['key_chunks']} keys",
            _amount(track["bytes"]),
            _rate(track["bits_per_second"]),
            "" if track["selected"] else "not of this rung",
        )
        for track in found["tracks"]
    ]
    lines += _table(rows, "lllrrrrl")
    for rung in found["rungs"][1:] and found["rungs"]:
        scale = f", pictures at {rung['scale']:.3g}" if rung["scale"] else ""
        lines.append(f"  rung {rung['rung']}: tracks {', '.join(map(str, rung['tracks']))}{scale}")
    cameras = found["cameras"]
    sizes = sorted({f"{camera['width']} x {camera['height']}" for camera in cameras})
    if cameras:
        names = _cut([str(camera["name"] or camera["id"]) for camera in cameras], 12)
        moving = sum(camera["moves"] for camera in cameras)
        lines.append(
            f"cameras\n  {len(cameras)}, {', '.join(sizes)} pixels{f', {moving} moving' if moving else ''}: {names}"
        )
    if found["sound"]:
        lines.append("sound")
    for sound in found["sound"]:
        title = sound["title"] or f"track {sound['track']}"
        lines.append(
            f"  {title}: {sound['codec']}, {sound['channels']} channel{'s' * (sound['channels'] > 1)}, {sound['rate']} Hz, "
            f"{sound['start']:.2f} s to {sound['start'] + sound['duration']:.2f} s"
        )
    if found["problems"]:
        lines.append("damage\n  " + _cut(found["problems"], 8, "\n  "))
    return "\n".join(lines)


def _cut(items: list[str], most: int, between: str = ", ") -> str:
    left = len(items) - most
    return between.join(items[:most]) + (f"{between}and {left} more" if left > 0 else "")


def _table(rows: list[tuple[str, ...]], sides: str) -> list[str]:
    most = 24
    widths = [max(len(row[column]) for row in rows) for column in range(len(sides))] if rows else []
    out: list[str] = []
    for row in rows[:most]:
        cells = [cell.rjust(w) if side == "r" else cell.ljust(w) for cell, w, side in zip(row, widths, sides)]
        out.append("  " + "  ".join(cell for cell, w in zip(cells, widths) if w).rstrip())
    return out + ([f"  and {len(rows) - most} more"] if len(rows) > most else [])
