"""Which frames of a damaged stream a decoder may call intact, if it looks closer than `decoder.report`.

`report` calls a frame whole when something after it in its group shows that it is over. Two kinds of decoders know more:

- one that is eager: a frame of which every track has a chunk is over, whatever follows. Sound is not part of frames;
- one with random access: the table in GEND lists every chunk of a group. Where it fits the chunks that are there, none is missing,
  and a broken rule about their order or their counters takes nothing from a frame.
"""

from .container import Broken
from .decode.group import Group
from .decoder import Reader, read, report

AUDIO = 7
#: Types whose content is not part of frames.
BESIDE = (b"BACK", b"AUDI")


class FrameGroup(Group):
    """A wrong environment or wrong sound takes nothing from a frame, and neither do colours without a key mesh."""

    def lose(self, chunk):
        is_needed = chunk.kind != b"COLR" or chunk.time in self.key_times.values()
        if chunk.kind not in BESIDE and is_needed:
            super().lose(chunk)


class EagerGroup(FrameGroup):
    """A group whose last frame before damage counts, if every track has a chunk in it."""

    complete_time = None

    def note_complete(self):
        time = self.whole_before
        seen = {track for _, track, at in self.times if at == time}
        wanted = (
            {id for id, track in self.block.tracks.items() if track.kind != AUDIO} if self.block else {None}
        )
        if time in self.frame_times and wanted <= seen:
            self.complete_time = time

    def damage(self):
        if self.intact:
            self.note_complete()
        super().damage()

    def whole_times(self):
        if self.intact and not self.ended:
            self.note_complete()
        more = [] if self.complete_time is None else [self.complete_time]
        return sorted({*super().whole_times(), *more})


class TableGroup(FrameGroup):
    """A group that is whole if its table is right."""

    lost = False

    def place(self, chunk):
        try:
            super().place(chunk)
        except Broken as broken:
            if broken.issue not in (1208, 1209):
                raise

    def damage(self):
        if self.lost:
            super().damage()

    def whole(self):
        return super().whole() if self.ended and not self.lost else iter(())


class TableReader(Reader):
    """Reads on where a rule is broken and nothing is lost."""

    group_type = TableGroup

    def lose(self, found):
        if self.group:
            self.group.lost = True
        super().lose(found)

    def in_group(self, chunk, broken):
        super().in_group(chunk, 0)


class EagerReader(Reader):
    group_type = EagerGroup


def frames(data):
    """The frames of `report`, and those that such decoders find as well."""
    found = {frame["time"]: frame for frame in report(data)["frames"]}
    for reader_type in EagerReader, TableReader:
        known = read(bytes(data), {}, reader_type).blocks
        for frame in read(bytes(data), known, reader_type).results()["frames"]:
            found.setdefault(frame["time"], frame)
    return [found[time] for time in sorted(found)]
