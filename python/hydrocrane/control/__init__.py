"""What drives a crane: sticks, and controllers by name or of one's own."""
