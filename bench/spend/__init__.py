"""Figures of what --view-loss saves (docs/encoding/view-loss.md)."""
