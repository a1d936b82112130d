"""What goes wrong around real nodes over DDS; a run prints a table of what they said."""
