"""Figures of meshes that are followed from frame to frame (docs/encoding/tracking.md)."""
