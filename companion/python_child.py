"""How the programs start others of their own: with this interpreter, and nothing of the folder.

Without `-P`, Python looks for modules in the working directory first: a file that lies there under
the name of one of ours, in an uploaded folder or a download, would be run.
"""

from __future__ import annotations

import sys


def python_module(module: str, *arguments: str) -> list[str]:
    """The command that runs an installed module.

    >>> python_module("sitl", "--help")[1:]
    ['-P', '-m', 'sitl', '--help']
    """
    return [sys.executable, "-P", "-m", module, *arguments]
