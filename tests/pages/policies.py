"""What every page promises of its Content Security Policy."""

from __future__ import annotations

import base64
import hashlib
import html
import re


def hashed(text: str) -> str:
    """Return the name by which a policy allows exactly this text."""
    return "'sha256-" + base64.b64encode(hashlib.sha256(text.encode("utf-8")).digest()).decode("ascii") + "'"


def assert_strict(page: str, images: str = "data:") -> None:
    """Assert that a page allows its own sheet and scripts and nothing else, and uses nothing else."""
    (policy,) = re.findall(r'Content-Security-Policy" content="([^"]*)"', page)
    (style,) = re.findall(r"<style>(.*?)</style>", page, re.DOTALL)
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    allowed = " ".join(map(hashed, scripts)) or "'none'"
    assert html.unescape(policy) == (
        f"default-src 'none'; img-src {images}; style-src {hashed(style)}; script-src {allowed}"
    )
    assert not re.search(r"<[^>]* (?:style|on\w+)=", page)
