"""Pages looked at in Debian's Chromium, as a user would see them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

SIZES = [(1280, "light"), (1280, "dark"), (390, "light"), (390, "dark")]
"""Width of the window, px, and the colour scheme."""


def opened(browser: Browser, path: Path, width: int, scheme: str) -> Page:
    """A page without any fault: nothing said on the console, every image drawn and described, no sideways scrolling,
    nothing fetched from elsewhere.
    """
    page = browser.new_page(viewport={"width": width, "height": 900}, color_scheme=scheme)  # type: ignore[arg-type]  # one of two words
    said: list[str] = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    fetched: list[str] = []
    page.on("request", lambda request: fetched.append(request.url))
    page.goto(path.as_uri())
    page.wait_for_function("[...document.images].every(image => image.complete)")
    # What a script would fetch late; a video may go on loading for longer than any test waits.
    page.wait_for_timeout(500)
    assert said == []
    assert all(url.startswith(("file:", "data:")) for url in fetched)
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    images = page.evaluate("[...document.images].map(i => [i.complete && i.naturalWidth > 0, i.alt.length > 20])")
    assert all(all(image) for image in images)
    return page


def contrast(page: Page, selector: str) -> float:
    """Contrast of a text's colour against the page's background, 1 to 21 (WCAG 2: 4.5 is readable)."""
    return float(
        page.evaluate(
            """selector => {
                const light = text => {
                    const [r, g, b] = text.match(/[0-9.]+/g).slice(0, 3).map(v => {
                        const x = v / 255;
                        return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
                    });
                    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
                };
                const a = light(getComputedStyle(document.querySelector(selector)).color);
                const b = light(getComputedStyle(document.body).backgroundColor);
                return (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
            }""",
            selector,
        )
    )
