"""Figures of streams that many processes encode (docs/encoding/parts.md)."""
