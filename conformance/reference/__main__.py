"""Answers requests of ../PROTOCOL.md on stdin and stdout, one JSON object in a line. usage: python3 -m reference"""

import base64
import json
import pathlib
import sys

from .container import DATA
from .decoder import report
from .questions import ANSWERS

PARTS = [
    "check",
    "mesh",
    "camera",
    "visibility",
    "colours",
    "video",
    "sound",
    "environment",
    "join",
    *ANSWERS,
]


def hello():
    version = f"{DATA['format']['major']}.{DATA['format']['minor']}"
    return {"protocol": 1, "name": "reference", "version": version, "format": version, "parts": PARTS}


def content_of(request):
    """The bytes of a stream, which is given by its path or its bytes."""
    if "data" in request:
        return base64.b64decode(request["data"])
    return pathlib.Path(request["path"]).read_bytes()


def answer(request):
    """A report of a stream, or the answer to a question on one of its frames."""
    data, op = content_of(request), request["op"]
    if op in ANSWERS:
        found = ANSWERS[op](data, request)
    else:
        found = report(data, bool(request.get("live")), bool(request.get("joined")))
    return {"id": request.get("id"), **found}


def main():
    for line in sys.stdin:
        request = json.loads(line)
        if request["op"] == "quit":
            break
        found = hello() if request["op"] == "hello" else answer(request)
        print(json.dumps(found, separators=(",", ":")), flush=True)


if __name__ == "__main__":
    main()
