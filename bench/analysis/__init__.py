"""Figures of @fvv/analysis."""
