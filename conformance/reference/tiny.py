"""The two tiny files of conformance/tiny, and Appendix A of spec/fvv.md, which takes them apart byte by byte."""

from .container import Stream
from .mesh import Mesh, raw_parts

# Four corners of a cube of 200 mm; counter-clockwise seen from outside.
TETRAHEDRON = Mesh(
    positions=[(100, 100, 100), (100, -100, -100), (-100, 100, -100), (-100, -100, 100)],
    faces=[(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)],
)


def empty():
    stream = Stream()
    stream.scene()
    stream.finish()
    return stream


def tetrahedron(name="mesh"):
    stream = Stream()
    stream.scene()
    stream.track(1, 1, name)
    stream.begin_group(0, 1)
    stream.chunk("MESH", raw_parts(TETRAHEDRON), track=1, time=0, key=True)
    stream.end_group()
    stream.finish()
    return stream


FILES = {
    "empty.fvv": (empty, "A stream without groups: file header, one configuration block, index, footer."),
    "tetrahedron.fvv": (tetrahedron, "One mesh track, one group, one frame: a raw mesh of four vertices."),
}


def files():
    """The bytes of each file, by name."""
    return {name: make().data() for name, (make, _) in FILES.items()}


def appendix():
    """Appendix A: every byte of both files."""
    out = [
        "The numbers in the first column are offsets in the file. The files are in",
        "[conformance/tiny](../conformance/tiny/README.md).",
    ]
    for name, (make, text) in FILES.items():
        stream = make()
        out += ["", f"### {name}", "", f"{text} {stream.size} bytes."]
        for section in stream.sections:
            out += [
                "",
                f"**{section.title}**",
                "",
                "| offset | bytes | field | meaning |",
                "|---|---|---|---|",
            ]
            offset = section.offset
            for part in section.parts:
                out.append(f"| {offset} | `{part.data.hex(' ').upper()}` | {part.name} | {part.meaning} |")
                offset += len(part.data)
    return "\n".join(out)
