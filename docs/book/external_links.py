#!/usr/bin/env python3
"""Opens every link of the README and the book that leads elsewhere, and fails where one leads nowhere."""

from __future__ import annotations

import re
import sys
import urllib.error
import urllib.request
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md")]
LINK = re.compile(r"(?<=[(<])https?://[^)>\s]+")


def complaint(address: str) -> "str | None":
    request = urllib.request.Request(address, headers={"User-Agent": "Mozilla/5.0 (photosite's link check)"})
    try:
        with urllib.request.urlopen(request, timeout=30):
            return None
    except urllib.error.HTTPError as error:
        # Some sites let no program in: the page is there all the same.
        return None if error.code in (401, 403, 405, 429) else f"{error.code}"
    except OSError as error:
        return str(error)


def main() -> int:
    links: "dict[str, Path]" = {}
    for page in PAGES:
        for address in LINK.findall(page.read_text(encoding="utf-8")):
            links.setdefault(address, page)
    failed = 0
    for address, page in sorted(links.items()):
        wrong = complaint(address)
        print(f"{address}: {wrong or 'there'}", flush=True)
        if wrong:
            print(f"  in {page.relative_to(ROOT)}")
        failed += bool(wrong)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
