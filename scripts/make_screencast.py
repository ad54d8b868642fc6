"""Makes docs/monitor.webp: the monitor page during the paper's mission, 10 s of pictures.

It flies the mission in lockstep with seed 0, replays it, and takes a picture for each step of its
time with Debian's chromium, so no camera and no clock matter. New plans are shown longest.

Usage: python scripts/make_screencast.py [FILE]
"""

from __future__ import annotations

import io
import sys
from pathlib import Path

from benches import ROOT
from make_page_picture import paused_page, picture
from PIL import Image

FIRST_S, LAST_S, STEP_S = 7.6, 71.6, 0.8
"""Times of the flight that are shown: from the beginning of the task to the landing."""
REPLANS_S = (44.1, 52.3)
SHOWN_MS, REPLAN_MS, END_MS = 110, 1500, 3000
SIZE = (1080, 675)
QUALITY = 55
MOST_BYTES = 2_000_000


def main(path: Path) -> None:
    """Writes the pictures."""
    steps = int((LAST_S - FIRST_S) / STEP_S) + 1
    times_s = sorted({round(FIRST_S + i * STEP_S, 1) for i in range(steps)} | {*REPLANS_S})
    frames = []
    with paused_page() as page:
        for time_s in times_s:
            with Image.open(io.BytesIO(picture(page, time_s, wait_ms=350))) as image:
                frames.append(image.convert("RGB").resize(SIZE, Image.Resampling.LANCZOS))
    shown_ms = [REPLAN_MS if time_s in REPLANS_S else SHOWN_MS for time_s in times_s]
    shown_ms[-1] = END_MS
    frames[0].save(
        path,
        save_all=True,
        append_images=frames[1:],
        duration=shown_ms,
        loop=0,
        quality=QUALITY,
        method=4,
    )
    assert path.stat().st_size <= MOST_BYTES, f"{path} has {path.stat().st_size} bytes"
    print(f"{path}  {len(frames)} pictures, {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "monitor.webp")
