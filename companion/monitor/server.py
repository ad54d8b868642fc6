"""The monitor's web server: one page, its files, and one stream. It is read-only.

    GET /          the page        GET /NAME    its scripts and styles
    GET /stream    server-sent events (feed.py)

Its content security policy lets the page load nothing from elsewhere. It answers only under an
address or a name of this machine (own_names.py).
"""

from __future__ import annotations

import asyncio
import contextlib
import os
import socket
import sys
from collections.abc import AsyncIterator
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import Response, StreamingResponse
from starlette.routing import Route

from companion.monitor.feed import Feed
from companion.monitor.follower import PERIOD_S, Follower
from companion.monitor.own_names import OwnNamesOnly

STATIC = Path(__file__).parent / "static"
TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
}
HEADERS = {
    "Content-Security-Policy": "default-src 'none'; script-src 'self'; style-src 'self'; "
    "connect-src 'self'; img-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}
MOST_CONNECTIONS = 256
"""Most connections; a browser has up to six. Further ones are answered with 503."""
NICENESS = 10
"""The flight has priority."""
LAST_WORDS_S = 0.2
"""Time for clients to read the end."""


def application(feed: Feed) -> Starlette:
    """The pages of a feed."""
    files = {path.name: path for path in STATIC.iterdir() if path.suffix in TYPES}

    async def file(request: Request) -> Response:
        path = files.get(request.path_params.get("name", "index.html"))
        if path is None:
            return Response("not found", 404, HEADERS)
        return Response(path.read_bytes(), 200, HEADERS, TYPES[path.suffix])

    async def stream(request: Request) -> Response:
        return StreamingResponse(feed.stream(), 200, HEADERS, "text/event-stream")

    return Starlette(
        routes=[Route("/", file), Route("/stream", stream), Route("/{name}", file)],
        middleware=[Middleware(OwnNamesOnly)],
    )


def replay(listener: socket.socket, folder: Path) -> None:
    """Serves one run until Ctrl-C.

    Raises:
        MissionError: the folder cannot be shown.
    """
    run = Follower(folder, is_live=False)

    async def runs() -> AsyncIterator[Follower]:
        yield run
        await asyncio.Event().wait()

    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_serve(listener, runs()))


def follow(listener: socket.socket) -> None:
    """Serves the runs whose folders are named on standard input, one per line, until its end."""
    os.nice(NICENESS)

    async def runs() -> AsyncIterator[Follower]:
        lines = asyncio.StreamReader()
        protocol = asyncio.StreamReaderProtocol(lines)
        await asyncio.get_running_loop().connect_read_pipe(lambda: protocol, sys.stdin)
        while line := await lines.readline():
            yield Follower(Path(line.decode().rstrip("\n")), is_live=True)

    asyncio.run(_serve(listener, runs()))


async def _serve(listener: socket.socket, runs: AsyncIterator[Follower]) -> None:
    """Serves the newest of some runs until there are no more, or a signal arrives."""
    feed = Feed()
    config = uvicorn.Config(
        application(feed),
        log_level="error",
        access_log=False,
        lifespan="off",
        timeout_graceful_shutdown=1,
        limit_concurrency=MOST_CONNECTIONS,
    )
    server = uvicorn.Server(config)

    async def take() -> None:
        async for run in runs:
            feed.show(run)

    reading = asyncio.create_task(_read(feed))
    taking = asyncio.create_task(take())
    serving = asyncio.create_task(server.serve(sockets=[listener]))
    await asyncio.wait({reading, taking, serving}, return_when=asyncio.FIRST_COMPLETED)
    if feed.run is not None and not serving.done():
        for _ in range(2):  # the second time reads the events that waited
            feed.run.read()
    feed.close()
    await asyncio.sleep(0 if serving.done() else LAST_WORDS_S)
    server.should_exit = True
    await serving
    for task in (reading, taking):
        task.cancel()
    for done in await asyncio.gather(reading, taking, return_exceptions=True):
        if isinstance(done, Exception):
            raise done


async def _read(feed: Feed) -> None:
    """Reads what is new, five times a second, or faster while there is more."""
    while True:
        is_more = feed.run is not None and feed.run.read()
        feed.tell()
        await asyncio.sleep(0 if is_more else PERIOD_S)
