"""The functions that the package offers to Python programs; `companion` exports them."""
