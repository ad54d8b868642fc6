"""Opens what a flight needs, flies it and closes everything, for commands and for Python."""
