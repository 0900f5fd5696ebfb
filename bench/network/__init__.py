"""What happens over a network, and in real time."""
