"""Four pictures of a page by a headless browser: wide and narrow, light and dark.

python tests/look.py results/quick/report.html [FOLDER] [HASH]
"""

import subprocess
import sys
import tempfile
from pathlib import Path

SIZES = {"wide": (1440, 1200), "narrow": (390, 844)}


def look(page: Path, folder: Path, place: str = "") -> list[Path]:
    """Pictures of the first screen of a page, or of the place in it with this id."""
    folder.mkdir(parents=True, exist_ok=True)
    made = []
    for name, (width, height) in SIZES.items():
        for dark in (False, True):
            made.append(folder / f"{page.stem}-{name}-{'dark' if dark else 'light'}.png")
            with tempfile.TemporaryDirectory() as profile:
                scheme = ["--blink-settings=preferredColorScheme=0"] if dark else []
                subprocess.run(
                    ["chromium", "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars",
                     f"--user-data-dir={profile}", f"--window-size={width},{height}", *scheme,
                     "--virtual-time-budget=4000", f"--screenshot={made[-1].resolve()}",
                     f"{page.resolve().as_uri()}{place and '#' + place}"],
                    check=True, capture_output=True, timeout=120,
                )  # fmt: skip
    return made


if __name__ == "__main__":
    target, *rest = sys.argv[1:]
    for picture in look(Path(target), Path(rest[0] if rest else "results/look"), *rest[1:]):
        print(picture)
