"""The parts of the reference decoder: chunks and damage, the order of a stream, configuration, and each kind of payload.

`report` of ../decoder.py puts them together. Written from the prose of spec/fvv.md; every violation is a `Broken` with the
number of the rule.
"""
