"""What breaks first, and how: sheets of cases that differ from a good one by one thing, stronger and stronger."""
