#!/usr/bin/env python3
"""Opens every link of the README and the book that leads elsewhere, and fails where one leads nowhere.

Where most sites cannot be reached at all, as on a machine without a way out, it says so and passes.
"""

from __future__ import annotations

import re
import sys
import urllib.error
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
LINK = re.compile(r"(?<=[(<])https?://[^)>\s]+")


def opened(address: str) -> "str | None":
    """The status with which a site refuses an address; none where the page is there. Raises OSError out of its reach."""
    request = urllib.request.Request(address, headers={"User-Agent": "Mozilla/5.0 (photosite's link check)"})
    try:
        with urllib.request.urlopen(request, timeout=30):
            return None
    except urllib.error.HTTPError as error:
        # Some sites let no program in: the page is there all the same.
        return None if error.code in (401, 403, 405, 429) else f"{error.code}"


def main() -> int:
    links: "dict[str, Path]" = {}
    for page in PAGES:
        for address in LINK.findall(page.read_text(encoding="utf-8")):
            links.setdefault(address, page)
    wrong, out_of_reach = [], []
    for address, page in sorted(links.items()):
        place = f"{address} (in {page.relative_to(ROOT)})"
        try:
            refusal = opened(address)
        except OSError as error:
            out_of_reach.append(f"{place}: {error}")
            continue
        if refusal:
            wrong.append(f"{place}: {refusal}")
    print(*wrong, *out_of_reach, sep="\n")
    # A machine behind a proxy or a mirror reaches few sites and says nothing of the others.
    if len(out_of_reach) > len(links) / 2:
        print(f"warning: {len(out_of_reach)} of {len(links)} links are out of this machine's reach and were not looked at")
        return 0
    return 1 if wrong or out_of_reach else 0


if __name__ == "__main__":
    sys.exit(main())
