"""The options of fvvcapture, of fvvcapture calibrate and of fvvcapture live. Needs neither numpy nor the extension module, as `fvv.help`."""

from __future__ import annotations

from fvv.help import Parser, Section

from .choices import CALIBRATION_FORMATS, LENSES, SURFACES, SYNCHRONISE, UPS

EXAMPLES = [
    "fvvcapture videos --calibration room.json -o players.fvv",
    "fvvcapture videos --calibration room.json --plate empty --sheet look.png -o capture",
    "fvvcapture videos --calibration qca.txt --up +z --frames 0-49 --key difference -o capture",
    "fvvcapture pictures --masks mattes --calibration sparse/0 --units metres --fps 25 -o players.fvv",
    "fvvcapture take --walk board --board 8x6 --square 0.08 --dictionary 4x4_100 -o take.fvv",
]
NOTES = [
    "fvvcapture calibrate --help: films of a board. fvvcapture live --help: shows.",
    "docs/tools/fvvcapture.md has the rest.",
]
CALIBRATE_EXAMPLES = [
    "fvvcapture calibrate board_videos --board 8x6 --square 0.08 --marker 0.06 -o room.json",
    "fvvcapture calibrate walk --board 9x6 --square 0.12 --dictionary 4x4_100 --floor 412 -o room.json",
    "fvvcapture calibrate --calibration room.json --take take --moving crane --zoom -o moving.json",
]


LIVE_EXAMPLES = [
    "fvvcapture live cameras.txt --calibration room.json --plate empty --bounds=-2,0,-2,2,2,2 -o -",
    "fvvcapture live films --calibration room.json --plate empty --bounds=-2,0,-2,2,2,2 -o a.fvv",
]


def listed(text: str) -> list[str]:
    """The names of an option such as A,B."""
    return [name for name in text.split(",") if name]


def _board(section: Section) -> None:
    section.add("--board", metavar="CxR", help="squares of the board in a row and in a column")
    section.add("--square", type=float, metavar="METRES", help="side of a square")
    section.add("--dictionary", metavar="NAME", help="of the markers: 4x4_100; without it a chessboard")
    section.add(
        "--marker",
        type=float,
        metavar="METRES",
        rare=True,
        help="side of a marker. Default: 3/4 of the square",
    )


def capture_parser(version: str) -> Parser:
    """The options of fvvcapture."""
    out = Parser(
        "fvvcapture",
        version,
        "Make a capture for fvvmux, or a stream, of what calibrated cameras filmed.",
        EXAMPLES,
        NOTES,
        has_rare=True,
    )
    out.positional(
        "recordings", metavar="FOLDER", help="a video, or a folder of numbered pictures, for each camera"
    )
    add = out.section("Files").add
    add("--calibration", metavar="FILE", action="extend", nargs="+",
        help="of fvvcapture calibrate, a capture.json, COLMAP, OpenCV, nerfstudio, Qualisys, Middlebury, K/R/t text, Panoptic")  # fmt: skip
    add("-o", "--output", metavar="OUT", required=True, help="a folder for the capture, or NAME.fvv")
    add("--plate", metavar="FOLDER", help="films of the empty stage. Default: the median of each clip")
    add("--masks", metavar="FOLDER", help="masks of another program, in place of keying")
    add("--sheet", metavar="FILE.png", help="pictures with the outlines of their keys: look at it first")
    add("--chart", metavar="FILE.png", rare=True, help="the report as a picture")
    add("--force", action="store_true", help="replace outputs that exist (docs/tools/outputs.md)")
    add("--json", action="store_true", help="print the report as JSON (spec/fvvcapture.schema.json)")
    board = out.section("A board, in place of --calibration (docs/tools/fvvcapture-calibrate.md)")
    board.add("--walk", metavar="FOLDER", help="films of a board that is carried through the volume")
    _board(board)
    board.add(
        "--on-floor", type=int, metavar="FRAME", rare=True, help="frame in which the board lies on the floor"
    )
    add = out.section("Cameras and time").add
    add("--cameras", metavar="A,B", default="", help="their names. Default: all that have recordings")
    add("--exclude", metavar="A,B", default="", rare=True, help="names of cameras to leave out")
    add("--frames", metavar="A-B", help="of the frames that all cameras have; A-: to the end")
    add("--fps", metavar="RATE", help="pictures a second, for folders of pictures: 25 or 30000/1001")
    add("--synchronise", choices=SYNCHRONISE, help="find offsets that are not given")
    add("--accept-offsets", action="store_true", rare=True, help="go on where they are not certain")
    add("--offset", metavar="CAMERA=N", action="append", default=[],
        help="pictures by which a recording begins earlier than the others")  # fmt: skip
    add("--place", metavar="CAMERA=X,Y", action="append", default=[], rare=True,
        help="where the pictures are in the calibrated ones, if they are cut")  # fmt: skip
    add("--units", metavar="UNIT", help="of the calibration, if its format does not say: millimetres")
    add("--up", choices=UPS, help="axis of the world that points up")
    add("--sound", metavar="CAMERA", rare=True, help="the recording whose sound is taken")
    add("--name", metavar="PATTERN", action="append", default=[], rare=True,
        help="of recordings: '{camera}_take'; once for each that there is")  # fmt: skip
    add("--title", metavar="TEXT", default="", rare=True, help="name of the scene")
    add = out.section("Keying (docs/tools/fvvcapture-keying.md)").add
    add("--key", choices=("auto", "chroma", "difference", "both"), default="auto",
        help="what tells the action from the background")  # fmt: skip
    add("--backing", metavar="R,G,B", rare=True, help="colour of the screen. Default: measured")
    add("--shadows", choices=("drop", "keep"), default="drop", rare=True,
        help="whether shadows are part of the action")  # fmt: skip
    add("--refine", choices=("none", "edge", "graph"), default="none",
        help="edge: outlines follow edges; graph: the least cut, slow")  # fmt: skip
    add = out.section("Visual hull (docs/tools/fvvcapture-hull.md)").add
    add("--cell", metavar="LENGTH", help="of the finest grid: 8mm")
    add("--max-error", metavar="PIXELS", type=float, help="in place of --cell. Default: 4")
    add("--floor", metavar="METRES", type=float, help="height below which nothing is; needs --up")
    add("--bounds", metavar="X,Y,Z,X,Y,Z", help="low and high corner in metres. Default: found")
    add("--least-views", metavar="N", type=int, rare=True, help="cameras that must see a point. Default: 3")
    add("--missed", metavar="N", type=int, default=0, rare=True, help="silhouettes that may miss a point")
    add("--min-share", metavar="SHARE", type=float, default=0.02, rare=True,
        help="components below this share of the largest are dropped")  # fmt: skip
    add("--smoothing", metavar="N", type=int, default=0, rare=True, help="rounds, within the silhouettes")
    add("--surface", choices=SURFACES, default="hull", rare=True,
        help="refined: hollows are carved by colour, slower")  # fmt: skip
    add("--grids", action="store_true", rare=True, help="keep grids/NNNN.npz beside the meshes")
    add = out.section("Running").add
    add("--mux", metavar="OPTION=VALUE", action="append", default=[],
        help="option of fvvmux for NAME.fvv: scale=0.5")  # fmt: skip
    add("--held-out", metavar="N", type=int, default=0, rare=True,
        help="predict each camera from the others at N frames, and report its PSNR")  # fmt: skip
    add("--jobs", metavar="N", type=int, help="processes at once. Default: one for each processor")
    add(
        "--dask", metavar="ADDRESS", rare=True, help="scheduler of a Dask cluster that reaches the same paths"
    )
    return out


def calibrate_parser(version: str) -> Parser:
    """The options of fvvcapture calibrate."""
    out = Parser(
        "fvvcapture calibrate",
        version,
        "Calibrate cameras: their lenses and poses, from videos of a board.",
        CALIBRATE_EXAMPLES,
        ["docs/tools/fvvcapture-calibrate.md explains all of it."],
    )
    out.positional(
        "videos",
        metavar="FOLDER",
        nargs="?",
        help="a video or a folder of pictures for each camera: the board walk",
    )
    add = out.section("Files").add
    add("-o", "--output", metavar="OUT", help="calibration to write")
    add("--format", choices=CALIBRATION_FORMATS, default="fvv", help="opencv: OUT is a folder of YAML files")
    add("--report", metavar="FOLDER", help="write a picture of each camera's errors there")
    add("-f", "--force", action="store_true", help="replace OUT if it exists")
    add("--json", action="store_true", help="print the figures as JSON")
    board = out.section("Board")
    _board(board)
    board.add("--legacy", action="store_true", help="ChArUco pattern of OpenCV before 4.6")
    add = out.section("Cameras and time").add
    add("--frames", metavar="A-B", help="frames to use. Default: all")
    add("--step", type=int, default=1, metavar="N", help="use every N-th frame")
    add("--offset", action="append", default=[], metavar="CAMERA=FRAMES",
        help="a camera that began earlier (positive) or later")  # fmt: skip
    add("--synchronise", choices=SYNCHRONISE, help="find offsets that are not given")
    add("--name", metavar="PATTERN", action="append", default=[], help="of recordings: '{camera}_board'")
    add("--exclude", metavar="A,B", default="", help="names of cameras to leave out")
    add("--lens", choices=LENSES, default="auto", help="auto: radtan5, or radtan8 where that is better")
    add = out.section("World").add
    add("--up", choices=UPS, default="+y", help="axis of the world that points up")
    add("--floor", type=int, metavar="FRAME", help="frame in which the board lies on the floor")
    add("--distance", nargs=3, metavar=("A", "B", "METRES"),
        help="metres between two cameras, for the scale")  # fmt: skip
    add = out.section("Cameras that move").add
    add("--take", metavar="FOLDER", help="films of the scene, by which the poses of moving cameras are found")
    add("--calibration", metavar="FILE",
        help="with --take: a calibration that exists, in place of a board walk")  # fmt: skip
    add("--moving", action="append", default=[], metavar="CAMERA", help="a camera that does not stand still")
    add("--tripod", action="append", default=[], metavar="CAMERA",
        help="a camera that turns and stays where it is; still in the walk")  # fmt: skip
    add("--zoom", action="store_true", help="moving cameras also change their focal length")
    return out


def live_parser(version: str) -> Parser:
    """The options of fvvcapture live."""
    out = Parser(
        "fvvcapture live",
        version,
        "Make a stream of what calibrated cameras film, while they film it.",
        LIVE_EXAMPLES,
        ["docs/guide/live.md explains all of it."],
    )
    out.positional(
        "sources",
        metavar="SOURCES",
        help="a file with a line NAME ADDRESS [OPTION=VALUE ...] for each camera; or a folder of videos, played at their speed",
    )
    add = out.section("Files").add
    add("--calibration", metavar="FILE", action="extend", nargs="+", help="as fvvcapture takes it")
    add("-o", "--output", metavar="OUT", required=True, help="NAME.fvv; - is standard output")
    add("--plate", metavar="FOLDER", help="films of the empty stage, by name of the camera")
    add("--force", action="store_true", help="replace an output that exists (docs/tools/outputs.md)")
    add(
        "--json",
        action="store_true",
        help="print events and summary as JSON (spec/fvvcapture-live.schema.json)",
    )
    add = out.section("Cameras and time").add
    add("--exclude", metavar="A,B", default="", help="names of cameras to leave out")
    add("--fps", metavar="RATE", help="frames a second: 12.5 or 30000/1001. Default: 12.5")
    add("--offset", metavar="CAMERA=N", action="append", default=[], help="frames by which a camera is late")
    add("--max-delay", metavar="SECONDS", type=float, default=2.0,
        help="from light to the last byte of a group; older frames are dropped. Default: 2")  # fmt: skip
    add("--idle", metavar="SECONDS", type=float, default=10.0,
        help="without a whole frame, after which the show ends. Default: 10")  # fmt: skip
    add("--units", metavar="UNIT", help="of the calibration, if its format does not say: millimetres")
    add("--up", choices=UPS, help="axis of the world that points up")
    add("--title", metavar="TEXT", default="", help="name of the scene")
    add = out.section("Keying (docs/tools/fvvcapture-keying.md)").add
    add("--key", choices=("auto", "chroma", "difference", "both"), default="auto",
        help="what tells the action from the background")  # fmt: skip
    add("--backing", metavar="R,G,B", help="colour of the screen. Default: measured in the plate")
    add("--shadows", choices=("drop", "keep"), default="drop", help="whether shadows are part of the action")
    add = out.section("Visual hull (docs/tools/fvvcapture-hull.md)").add
    add(
        "--bounds",
        metavar="X,Y,Z,X,Y,Z",
        required=True,
        help="where the action is: low and high corner in metres",
    )
    add("--cell", metavar="LENGTH", help="of the finest grid: 25mm; larger where that does not hold the rate")
    add("--max-error", metavar="PIXELS", type=float, help="in place of --cell. Default: 4")
    add("--floor", metavar="METRES", type=float, help="height below which nothing is; needs --up")
    add("--least-views", metavar="N", type=int, help="cameras that must see a point. Default: 3")
    add("--missed", metavar="N", type=int, default=0, help="silhouettes that may miss a point")
    add("--min-share", metavar="SHARE", type=float, default=0.02,
        help="components below this share of the largest are dropped")  # fmt: skip
    add = out.section("Running").add
    add("--mux", metavar="OPTION=VALUE", action="append", default=[], help="option of fvvmux: scale=0.5")
    add("--jobs", metavar="N", type=int, help="processes that make frames. Default: one for each processor")
    return out
