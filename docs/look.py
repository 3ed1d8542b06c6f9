"""A report in headless Chromium: what must hold of it as one looks at it, and four pictures.

python docs/look.py results/quick/report.html [FOLDER] [HASH]
"""

import sys
from itertools import pairwise
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

SIZES = {"wide": (1440, 1200), "narrow": (390, 844)}
FIRST = 1200  # pixels from the top, above which the first figure begins
CONTRAST = 4.5  # of text to what is behind it, at least: WCAG 2.1, AA
# Ratio of luminances of each visible element with text of its own to what is behind it.
CONTRASTS = """() => {
  const pen = document.createElement("canvas").getContext("2d", {willReadFrequently: true});
  const rgba = (colour) => {
    pen.clearRect(0, 0, 1, 1); pen.fillStyle = colour; pen.fillRect(0, 0, 1, 1);
    return [...pen.getImageData(0, 0, 1, 1).data];
  };
  const luminance = (colour) => rgba(colour).slice(0, 3).map((c) => c / 255)
    .map((c) => c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4)
    .reduce((sum, c, k) => sum + c * [0.2126, 0.7152, 0.0722][k], 0);
  const behind = (element) => {
    for (let e = element; e; e = e.parentElement) {
      const colour = getComputedStyle(e).backgroundColor;
      if (rgba(colour)[3] > 250) return colour;
    }
    return "Canvas";
  };
  const speaks = (e) => e.checkVisibility() && e.getBoundingClientRect().width > 2 &&
    [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim());
  const all = [...document.querySelectorAll("body *:not(svg *, script, style)")];
  return all.filter(speaks).map((e) => {
    const [a, b] = [luminance(getComputedStyle(e).color), luminance(behind(e))];
    return [(Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05), e.textContent.trim().slice(0, 60)];
  });
}"""


def wrong_with(page: Page, narrow: bool) -> list[str]:
    """What does not hold of an opened report, in sentences."""
    found = []
    first = page.locator("main img").first.bounding_box()
    if first is None or first["y"] >= FIRST:
        found.append(f"the first figure is at {first and first['y']}, not within {FIRST} pixels")
    across = page.evaluate("document.documentElement.scrollWidth - innerWidth")
    if narrow and across > 0:
        found.append(f"the page scrolls {across} pixels sideways")
    faint = [text for ratio, text in page.evaluate(CONTRASTS) if ratio < CONTRAST]
    if faint:
        found.append(f"{len(faint)} texts have a contrast below {CONTRAST}, as {faint[:3]}")
    return found + wrong_with_table(page)


def wrong_with_table(page: Page) -> list[str]:
    """Whether its filter leaves out what it should, and a click on a column sorts."""
    found = []
    rows = page.locator("#table tbody tr:not([hidden])")
    page.locator("input[name=mark][value=r]").uncheck()
    marks = rows.evaluate_all("rows => rows.map((row) => row.dataset.mark)")
    if not marks or "r" in marks:
        found.append(f"without 'replicated' the table shows {sorted(set(marks))}")
    page.locator("input[name=mark][value=r]").check()
    column = page.locator("#table th.c-z button")
    for direction in (1, -1):
        column.evaluate("button => button.click()")  # a narrow screen leaves heads out
        z = rows.evaluate_all("rows => rows.map((row) => +row.querySelector('.c-z').dataset.sort)")
        known = [value for value in z if value == value]
        if any(direction * (b - a) < 0 for a, b in pairwise(known)):
            found.append("a click on z does not sort by it")
    return found


def look(path: Path, folder: Path, place: str = "") -> list[str]:
    """Write four pictures of a page, or of the place in it with this id; say what is wrong."""
    said = []
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path="/usr/bin/chromium")
        for name, (width, height) in SIZES.items():
            for scheme in ("light", "dark"):
                page = browser.new_page(
                    viewport={"width": width, "height": height}, color_scheme=scheme
                )
                errors: list[str] = []
                page.on("console", lambda m, to=errors: m.type == "error" and to.append(m.text))
                page.on("pageerror", lambda problem, to=errors: to.append(str(problem)))
                page.route("http*://**", lambda r, to=errors: to.append(r.request.url) or r.abort())
                page.goto(f"{path.resolve().as_uri()}{place and '#' + place}")
                page.screenshot(path=folder / f"{path.stem}-{name}-{scheme}.png")
                errors += wrong_with(page, name == "narrow")
                said += [f"{name}, {scheme}: {each}" for each in errors]
        browser.close()
    return said


if __name__ == "__main__":
    target, *rest = sys.argv[1:]
    folder = Path(rest[0] if rest else "results/look")
    sys.exit("\n".join(look(Path(target), folder, *rest[1:])) or None)
