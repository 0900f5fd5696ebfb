"""Charts of speed against accuracy, of where methods fail, and of growth: ./run charts."""
