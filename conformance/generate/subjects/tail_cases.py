"""Ancillary chunks that a later version made longer: clause 16. Their tails are ignored."""

from .. import meshes, payloads
from ..case import valid
from ..recipes import frame, group, opened
from ..weights import Weights
from . import environment_cases, sound_cases, visibility_cases

TAIL = b"of a later version"


def case(name, title, clauses, make):
    valid(f"tail_{name}", title, f"16 {clauses}", make, uncommon=True, requirements=(9027,))


def ended(s):
    s.finish()
    return s


def texturing():
    s = opened()
    s.chunk("TEXR", payloads.texturing(best=2) + TAIL)
    group(s, 0)
    return ended(s)


def sound(config=b"", packets=b""):
    s = sound_cases.begun(payloads.audio(language="en") + config)
    s.begin(0, 4)
    for time in range(4):
        frame(s, time)
        good = payloads.sound(1920 * time, [sound_cases.SILENCE] * 2)
        sound_cases.audio(s, time, good + packets, time == 0)
    s.end()
    return ended(s)


def visibility():
    shape = visibility_cases.GRID
    s = visibility_cases.begun((0, 1))
    weights = Weights(shape)
    s.begin(0, 2)
    for time in range(2):
        s.chunk("MESH", meshes.raw(shape), 1, time, True)
        payload = weights.chunk(visibility_cases.centres(0, 1), visibility_cases.patches)
        s.chunk("VISI", payload + TAIL, visibility_cases.TRACK, time, time == 0)
    s.end()
    return ended(s)


def environment():
    part = payloads.part(environment_cases.PLAIN)
    payload = payloads.environment([part], lights=environment_cases.LIGHTS)
    return environment_cases.stream(payload + TAIL)


def index():
    s = opened()
    group(s, 0)
    group(s, 2)
    s.finish(payload=s.index_payload() + TAIL)
    return s


case("texturing", "Bytes follow the fields of TEXR.", "17.5", texturing)
case("sound_config", "Bytes follow the language of ACFG.", "20.1", lambda: sound(config=TAIL))
case("sound", "Bytes follow the packets of AUDI.", "20.2", lambda: sound(packets=TAIL))
case("visibility", "Bytes follow the streams of VISI.", "17.1", visibility)
case("environment", "Bytes follow the last mesh of BACK.", "18.1", environment)
case("index", "Bytes follow the last entry of INDX.", "7.1", index)
