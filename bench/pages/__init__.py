"""Figures of the documentation and of the demo site."""
