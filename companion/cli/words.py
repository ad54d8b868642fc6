"""Words that users type in place of a command, and the command that they mean."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

_FILES = (".yaml", ".yml", ".plan")
_COMMANDS = {
    **dict.fromkeys(("fly", "start", "launch"), "sim, in the simulator, or run, on a vehicle"),
    **dict.fromkeys(("simulate", "simulator", "sitl"), "sim"),
    **dict.fromkeys(("validate", "lint", "verify"), "check"),
    **dict.fromkeys(("init", "create"), "new"),
    **dict.fromkeys(("list", "ls", "logs"), "runs"),
    **dict.fromkeys(("convert", "load"), "import"),
    **dict.fromkeys(("plot", "draw"), "figure"),
    **dict.fromkeys(("version",), "companion --version"),
}
"""Commands of other programs -> ours."""


class WordyGroup(TyperGroup):
    """The command group, with advice for unknown commands."""

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Like typer's; refuses a file, or a command of another program, with advice."""
        word = args[0]
        if word in self.commands:
            return super().resolve_command(ctx, args)
        if word.endswith(_FILES):
            ctx.fail(f"{word} is not a command: companion sim {word} flies it")
        if word in _COMMANDS:
            ctx.fail(f"there is no command {word}: write {_COMMANDS[word]}")
        return super().resolve_command(ctx, args)
