"""Meshes in the Draco profile: clause 8.4 of spec/fvv.md."""


def decode(data, header):
    raise NotImplementedError("the Draco profile")
