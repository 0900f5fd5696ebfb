"""Figures of the player on a graphics card."""
