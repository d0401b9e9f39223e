"""How fast a report opens in Chromium, and how smoothly it zooms.

    hsr compare scenes/teapot.toml --size 2048 -a zbuffer -a opengl -o report.html
    python benchmarks/opening.py report.html "#scene=teapot&method=opengl"

Opening lasts from the request to the second frame with the sample's panel filled. Zooming is eighty turns of
the wheel, one a frame. Headless Chromium paints without a graphics processor: the hardest case.
"""

from __future__ import annotations

import shutil
import sys
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

SIZES = ((1280, 800), (3840, 2160))

FRAMES = "() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"

ZOOM = """async () => {
  const stage = document.querySelector(".stage");
  const { left, top, width, height } = stage.getBoundingClientRect();
  const frames = [];
  for (let k = 0; k < 80; k++) {
    const before = performance.now();
    const settings = { deltaY: k < 40 ? -60 : 60, clientX: left + width / 2, clientY: top + height / 2 };
    stage.dispatchEvent(new WheelEvent("wheel", { ...settings, cancelable: true }));
    await new Promise(requestAnimationFrame);
    frames.push(performance.now() - before);
  }
  return frames.sort((a, b) => a - b);
}"""


def measured(tab: Any, address: str) -> str:
    """Open a report at a sample, zoom in and out, and return the figures."""
    tab.goto(address)
    tab.wait_for_selector("#inspector:not([aria-busy]) #methods tr", state="attached")
    tab.evaluate(FRAMES)
    opened, frames = tab.evaluate("performance.now()"), tab.evaluate(ZOOM)
    return (
        f"opened in {opened / 1e3:.2f} s; frames: median {frames[40]:.0f} ms, 95 % within {frames[76]:.0f} ms"
    )


def main() -> None:
    """Measure the report named on the command line at both sizes."""
    address = Path(sys.argv[1]).resolve().as_uri() + sys.argv[2]
    with sync_playwright() as started:
        browser = started.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for width, height in SIZES:
            tab = browser.new_page(viewport={"width": width, "height": height})
            print(f"{width} x {height}: {measured(tab, address)}")
            tab.close()
        browser.close()


if __name__ == "__main__":
    main()
