"""Slow, plain readers and writers of streams, written from the prose of spec/fvv.md and spec/chunks.json alone.

They use nothing of libfvv, so that the specification and the library are checked against each other. Every reader takes
the container to be intact. `listing(stream)` of a module gives the lines of the files beside its vectors
(conformance/vectors.py).
"""
