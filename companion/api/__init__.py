"""What the package offers to Python programs, function by function; `companion` exports it."""
