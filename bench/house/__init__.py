"""Figures of the house."""
