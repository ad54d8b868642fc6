"""The command that lists what installed packages offer to missions: skills."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def skills(as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False) -> None:
    """Lists the functions of installed packages that missions may call, with their parameters.

    To read its parameters, each function is loaded in a process of its own.
    """
    from companion.mission.installed_calls import WORDS
    from companion.skills.catalogue import as_json as values_of
    from companion.skills.installed import read_all

    catalogue = read_all()
    if as_json:
        typer.echo(json.dumps(values_of(catalogue)))
        return
    for function, offers in catalogue.items():
        sources = " and ".join(each.source for each in offers)
        if len(offers) > 1:
            about = f"{function.name}: claimed by {sources}; neither is used"
        elif offers[0].failure:
            about = f"{function.name} of {sources}: {offers[0].failure}"
        else:
            about = f"{offers[0].in_words}    {sources}"
        typer.echo(f"{WORDS[function.kind]:<15} {about}")
    if not catalogue:
        typer.echo("no installed package offers any; docs/skills.md says how to write one")
