"""Places of a surface and viewers: by how much each camera colours the place. Clause 17.5."""

import math

from .. import media, meshes, payloads
from ..case import valid
from ..recipes import opened
from ..weights import Weights, above

VIDEO, SEEN, MOTION = 2, 4, 3
CAMERAS = {
    0: (0.4, 0.35, 1.2),
    1: (1.0, 0.3, 1.1),
    2: (-0.2, 0.4, 1.0),
    3: (0.4, 1.0, 1.3),
    4: (0.35, -0.3, 1.25),
}
MOVES = 1
# A whole picture at half its size, a crop at full size, and one whose pixels are not square.
WHOLE, CROP, FLAT = (0, 0, 32, 32), (8, 8, 16, 16), (0, 8, 32, 16)
SOURCES = {0: WHOLE, 1: WHOLE, 2: FLAT, 3: CROP, 4: WHOLE}
SHEET = meshes.grid(9, 8, 100)
# A plate of 0.2 m above the sheet.
PLATE = [(300, 200, 250), (500, 200, 250), (300, 400, 250), (500, 400, 250)]
COVERED = meshes.Shape(SHEET.positions + PLATE, SHEET.faces + [(72, 73, 74), (73, 75, 74)])
UP, TILTED = (0.0, 0.0, 1.0), (0.36, -0.48, 0.8)


def layout(cameras):
    return payloads.tiles(
        *[
            payloads.tile(camera, SOURCES[camera], (16 * (i % 4), 16 * (i // 4), 16, 16))
            for i, camera in enumerate(cameras)
        ]
    )


def camera(identifier, centre, **fields):
    intrinsics = {"width": 32, "height": 32, "fx": 20.0, "fy": 21.0, "cx": 16.0, "cy": 15.5}
    return payloads.camera(identifier, f"camera {identifier}", centre, **intrinsics | fields)


def place(face, barycentric, normal, eye):
    return {"face": face, "barycentric": list(barycentric), "normal": list(normal), "eye": list(eye)}


def places(faces, eyes):
    """Each face with another normal and another place in it, for every viewer."""
    inside = [(0.5, 0.3, 0.2), (0.2, 0.6, 0.2), (0.25, 0.25, 0.5)]
    return [
        place(face, inside[i % 3], (UP, TILTED)[i % 2], eye) for i, face in enumerate(faces) for eye in eyes
    ]


FACES = [3, 20, 37, 50, 58, 71, 94, 110]
EYES = [(0.4, 0.3, 1.5), (0.9, 0.1, 1.2), (0.1, 0.9, 0.9), (0.7, 0.5, 3.0)]
MIDDLE = [38, 41, 54, 57]  # below the plate


class Case:
    """A stream with a picture of each camera. frames: what is written after the mesh of each time, functions of (s, time)."""

    def __init__(
        self,
        shape=SHEET,
        cameras=CAMERAS,
        texturing=None,
        tracks=(),
        moves=(),
        frames=(lambda s, time: None,),
    ):
        self.shape, self.cameras, self.texturing = shape, cameras, texturing
        self.tracks, self.moves, self.frames = tracks, moves, frames

    def stream(self):
        clip = media.clip("jpeg")
        mesh, video = payloads.track(payloads.MESH, "mesh"), payloads.track(payloads.VIDEO, "cameras")
        s = opened((1, mesh), (VIDEO, video), *self.tracks)
        for identifier, centre in self.cameras.items():
            s.chunk("CAMR", camera(identifier, centre, flags=MOVES if identifier in self.moves else 0))
        s.chunk("VCFG", payloads.video("jpeg", width=clip.width, height=clip.height), track=VIDEO)
        s.chunk("TILE", layout(self.cameras), track=VIDEO)
        if self.texturing is not None:
            s.chunk("TEXR", self.texturing)
        for time, more in enumerate(self.frames):
            s.begin(time, time + 1)
            s.chunk("MESH", meshes.raw(self.shape), 1, time, True)
            more(s, time)
            s.chunk("VPKT", clip.samples[0][1], VIDEO, time, True)
            s.end()
        s.finish()
        return s


def add(name, title, case, rows, frame=0, clauses="17.5", **more):
    question = {"op": "weigh", "frame": frame, "mesh": 1, "places": rows}
    valid(f"weights_{name}", title, clauses, case.stream, questions=[question], **more)


def cosine_at_most(limit, face, eye):
    """Rows for normals around a threshold: their cosine to camera 0 is just below and just above it."""
    corners = [SHEET.positions[v] for v in SHEET.faces[face]]
    point = [sum(c[k] for c in corners) / 3000 for k in range(3)]
    ray = [a - b for a, b in zip(CAMERAS[0], point)]
    length = math.hypot(*ray)
    ray = [x / length for x in ray]
    aside = [ray[2], 0.0, -ray[0]]
    across = math.hypot(*aside)
    for cosine in (limit - 1e-4, limit + 1e-4):
        sine = math.sqrt(1 - cosine * cosine)
        yield place(face, [1 / 3] * 3, [cosine * r + sine * a / across for r, a in zip(ray, aside)], eye)


def seen(camera_, vertex):
    return (vertex // 9 + camera_) % 3 != 0


def level(camera_, vertex):
    return 1 + (vertex + camera_) % 3


def visible(s, time):
    centres = {i: above(*centre) for i, centre in CAMERAS.items() if i != 4}
    s.chunk("VISI", Weights(SHEET).chunk(centres, seen, level), SEEN, time, True)


BY_FACES = places(FACES, EYES)
texturing = payloads.texturing
add(
    "default",
    "Five cameras of a sheet, without TEXR: a crop, and a tile of other pixels; a normal that faces none of them.",
    Case(),
    [*BY_FACES, place(50, [0.5, 0.25, 0.25], (0.0, 0.0, -1.0), EYES[0])],
)
add(
    "hidden",
    "A plate hides a part of the sheet.",
    Case(COVERED),
    [
        *places([3, 20, 110], EYES),
        *places([112, 113], EYES[:2]),
        *places(MIDDLE, [(0.4, 1.6, 0.9), (1.6, 0.3, 0.7)]),
    ],
)
add(
    "visibility",
    "Visibility weights of four cameras decide, between states too; the fifth has none.",
    Case(tracks=[(SEEN, payloads.track(payloads.VISIBILITY, "seen"))], frames=(visible,)),
    [*BY_FACES, *places(range(0, 112, 9), EYES[:2])],
    clauses="17.4 17.5",
)
add(
    "best_2",
    "Two cameras are mixed, and the third takes from their weights.",
    Case(texturing=texturing(best=2)),
    BY_FACES,
)
add("best_8", "Eight cameras could be mixed.", Case(texturing=texturing(best=8)), BY_FACES)
add(
    "threshold",
    "A threshold of 0.8, and normals on both sides of it.",
    Case(texturing=texturing(threshold=0.8, best=5)),
    [*BY_FACES, *cosine_at_most(0.8, 50, EYES[0])],
)
add(
    "blend_1",
    "Weights by the normal alone, with visibility weights: a camera shows a place or not.",
    Case(
        tracks=[(SEEN, payloads.track(payloads.VISIBILITY, "seen"))],
        frames=(visible,),
        texturing=texturing(blend=1, threshold=0.25, best=2),
    ),
    [*BY_FACES, *places(range(0, 112, 9), EYES[:1])],
    clauses="17.4 17.5",
)
add(
    "inset",
    "Pictures show the surface 60 mm inside of the mesh, and at grazing angles 120 mm at most.",
    Case(texturing=texturing(inset=0.06, best=4)),
    [*BY_FACES, *places(FACES[:4], [(2.0, 0.3, 0.6)])],
)
# Numbers that binary fractions have exactly: both cameras have the same weight, bit for bit.
FLAT_SHEET = meshes.Shape([(0, 0, 0), (1000, 0, 0), (0, 500, 0), (1000, 500, 0)], [(0, 1, 2), (1, 3, 2)])
add(
    "equal",
    "Of two cameras with equal weights the first one in the stream is preferred, not that of the lower identifier.",
    Case(FLAT_SHEET, {4: (1.0, 0.125, 1.0), 0: (0.0, 0.125, 1.0)}, texturing(best=1)),
    [place(0, [0.25, 0.5, 0.25], UP, (0.5, 0.125, 2.0))],
)


def motion(s, time):
    """The camera moves at time 0, and is not calibrated afterwards."""
    values = payloads.moving_values(centre=(-3, 6, 16), pixels=(320, 336, 256, 248, 0))
    s.chunk("CALB", payloads.calibration(0, [] if time else [(2, values)]), MOTION, time, True)


MOVING = Case(
    tracks=[(MOTION, payloads.track(payloads.CALIBRATION, "motion"))],
    moves=(2,),
    texturing=texturing(best=5),
    frames=(motion, motion),
)
for number, title in enumerate(
    ("A camera that moves gives colour.", "A camera that is not calibrated gives no colour.")
):
    add(
        f"moving_{number}",
        title,
        MOVING,
        BY_FACES,
        number,
        "9.6 17.5",
        requirements=(9014,) if number else (),
    )


def without_two(s, time):
    if time:
        s.chunk("TILE", layout((4, 1, 0)), VIDEO, time, True)


add(
    "layout",
    "The second group has a layout without two of the cameras, and others in other places.",
    Case(frames=(without_two, without_two)),
    BY_FACES,
    1,
    "10.11 17.5",
)
