"""Figures of streams that many processes encode (docs/fvvmux-parts.md)."""
