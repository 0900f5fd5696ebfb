"""Parts that many cases share: a stream of one mesh track, groups of whole frames, and a fault between two good groups."""

from . import meshes, payloads
from .writer import Stream

MESH_TRACK = 1


def opened(*tracks, scene=None, **header):
    """A stream with SCEN and TRAK. tracks: (identifier, payload); by default one mesh track."""
    s = Stream(**header)
    block(s, *tracks, scene=scene)
    return s


def block(s, *tracks, scene=None):
    s.chunk("SCEN", payloads.scene() if scene is None else scene)
    for identifier, payload in tracks or [(MESH_TRACK, payloads.track(payloads.MESH, "mesh"))]:
        s.chunk("TRAK", payload, track=identifier)


def frame(s, time, shape=meshes.TETRAHEDRON, **chunk):
    s.chunk("MESH", meshes.raw(shape), track=chunk.pop("track", MESH_TRACK), time=time, key=True, **chunk)


def group(s, start, frames=2, **ending):
    """A group of that many meshes, one for each tick; without frames it lasts one tick."""
    s.begin(start, start + max(frames, 1))
    for time in range(start, start + frames):
        frame(s, time)
    s.end(**ending)


def between(middle, *tracks, more=None, scene=None, after=1):
    """Group 0 of two frames at 0, whatever middle(s) writes from time 2 on, good groups from time 10 on, index and footer.

    more(s): the rest of the configuration block.
    """
    s = opened(*tracks, scene=scene)
    if more:
        more(s)
    with_mesh = not tracks or any(identifier == MESH_TRACK for identifier, _ in tracks)
    group(s, 0, 2 if with_mesh else 0)
    middle(s)
    for i in range(after):
        group(s, 10 + 2 * i, 2 if with_mesh else 0)
    s.finish()
    return s


def in_group(write, *tracks, more=None, scene=None, frames=1):
    """A fault inside a group of its own, from time 2 on: frames meshes come before write(s)."""

    def middle(s):
        s.begin(2, 6)
        for i in range(frames):
            frame(s, 2 + i)
        write(s)
        s.end()

    return between(middle, *tracks, more=more, scene=scene)


def finished(**ending):
    """Two groups of two frames. ending: as of Stream.finish."""
    s = opened()
    group(s, 0)
    group(s, 2)
    s.finish(**ending)
    return s
