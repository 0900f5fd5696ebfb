"""Does a decoder of fvv agree with the conformance cases? See PROTOCOL.md and `fvv-conformance --help`."""

#: Version of the format that the cases certify.
FORMAT = "0.2"
__version__ = "0.2.0"
