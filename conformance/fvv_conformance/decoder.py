"""A decoder under test: a process that answers requests, one JSON object a line (PROTOCOL.md).

Requests are sent ahead of the answers. A process that dies, hangs or answers nonsense is ended and started again; the request
that it owes an answer to fails, and the next ones are sent once more.
"""

import collections
import itertools
import json
import queue
import shlex
import subprocess
import sys
import tempfile
import threading

PROTOCOL = 1
#: Requests that wait for answers: enough to keep a decoder busy, few enough to send again after a crash.
AHEAD = 16


#: Former words of the protocol, which are read for one version.
FORMER = {"background": "environment"}


class DecoderError(Exception):
    """A decoder that cannot be used at all."""


class Process:
    """One run of the program. Both pipes have a thread, so that neither side waits for the other to read."""

    def __init__(self, command):
        self._errors = tempfile.TemporaryFile()  # noqa: SIM115
        try:
            self._process = subprocess.Popen(
                shlex.split(command),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=self._errors,
            )
        except (OSError, ValueError) as error:
            raise DecoderError(f"{command}: cannot be started: {error}") from error
        self._requests = queue.SimpleQueue()
        self._answers = queue.SimpleQueue()
        for work in self._write, self._read:
            threading.Thread(target=work, daemon=True).start()

    def _write(self):
        pipe = self._process.stdin
        try:
            while (line := self._requests.get()) is not None:
                pipe.write(line)
                pipe.flush()
            pipe.close()
        except (OSError, ValueError):
            pass  # the process has ended, which the other thread notices

    def _read(self):
        try:
            for line in self._process.stdout:
                self._answers.put(line)
        except ValueError:
            pass
        self._answers.put(None)

    def send(self, request):
        self._requests.put(json.dumps(request).encode() + b"\n")

    def receive(self, seconds):
        """An answer, or a text that says why there is none."""
        try:
            line = self._answers.get(timeout=seconds)
        except queue.Empty:
            return f"no answer within {seconds:g} s"
        if line is None:
            return self._why_ended()
        try:
            answer = json.loads(line)
        except ValueError:
            answer = None
        return answer if isinstance(answer, dict) else f"expected a JSON object, found {line[:80]!r}"

    def _why_ended(self):
        try:
            code = self._process.wait(timeout=5)
        except subprocess.TimeoutExpired:
            return "closed its output"
        self._errors.seek(0)
        last = self._errors.read()[-4000:].decode(errors="replace").strip().splitlines()[-1:]
        how = f"ended by signal {-code}" if code < 0 else f"ended with exit code {code}"
        return ": ".join([how, *last])

    def close(self, seconds=5.0):
        """seconds: how long it may take to end by itself."""
        self._requests.put(None)
        try:
            self._process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._errors.close()


class Decoder:
    """timeout: seconds for one answer. The first one may take longer: programs start, modules are compiled."""

    def __init__(self, command, timeout=20.0, start_timeout=60.0):
        self.command, self._timeout, self._start_timeout = command, timeout, start_timeout
        self._process = None
        self.starts = 0
        hello = self._start()
        self.name = str(hello.get("name", shlex.split(command)[0]))
        self.version = str(hello.get("version", ""))
        self.format = str(hello.get("format", ""))
        parts = hello.get("parts", [])
        self.parts = frozenset(FORMER.get(part, part) for part in parts)
        for part in FORMER.keys() & set(parts):
            print(f"{self.name}: {part} is now {FORMER[part]}", file=sys.stderr)

    def _start(self):
        self._process = Process(self.command)
        self.starts += 1
        self._process.send({"op": "hello", "protocol": PROTOCOL})
        hello = self._process.receive(self._start_timeout)
        if not isinstance(hello, dict):
            self._end(0)
            raise DecoderError(f"{self.command}: {hello}")
        if hello.get("protocol") != PROTOCOL:
            self._end()
            raise DecoderError(f"{self.command}: protocol {hello.get('protocol')}, expected {PROTOCOL}")
        return hello

    def _end(self, seconds=5.0):
        if self._process is not None:
            self._process.close(seconds)
        self._process = None

    def decode_all(self, requests):
        """Yields the answer to each request, an iterable of dicts without op and id, in order; where there is none, a text."""
        numbered = enumerate(requests)
        waiting = collections.deque()
        while True:
            if self._process is None:
                self._start()
                for number, request in waiting:
                    self._process.send({"op": "decode", "id": number, **request})
            for number, request in itertools.islice(numbered, AHEAD - len(waiting)):
                waiting.append((number, request))
                self._process.send({"op": "decode", "id": number, **request})
            if not waiting:
                return
            number, _ = waiting.popleft()
            answer = self._process.receive(self._timeout)
            if isinstance(answer, dict) and answer.get("id") != number:
                answer = f"answered id {answer.get('id')}, expected {number}"
            if isinstance(answer, dict) and "error" in answer:
                yield f"error: {answer['error']}"
                continue
            if not isinstance(answer, dict):
                self._end(0)
                yield answer
                continue
            yield {FORMER.get(key, key): value for key, value in answer.items()}

    def close(self):
        if self._process is not None:
            self._process.send({"op": "quit"})
        self._end()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
