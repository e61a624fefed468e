"""Refuses a site that would load something from elsewhere, or whose links lead nowhere: check_site.py FOLDER"""

import re
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

LOADED = {("script", "src"), ("img", "src"), ("link", "href"), ("source", "src"), ("source", "srcset"),
          ("iframe", "src"), ("video", "src"), ("audio", "src"), ("object", "data"), ("embed", "src"), ("use", "href")}
OUTSIDE = re.compile(r"^\s*(?:[a-z]+:)?//", re.IGNORECASE)
STYLE = re.compile(r"url\(\s*['\"]?([^'\")]+)|@import\s+['\"]([^'\"]+)")


class Page(HTMLParser):
    """What a page loads, where its links lead, and its anchors."""

    def __init__(self, text):
        super().__init__()
        self.loaded, self.links, self.anchors = [], [], {"", "top"}
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name in ("id", "name") and value:
                self.anchors.add(value)
            if (tag, name) in LOADED and value:
                self.loaded.append(value)
            if (tag, name) == ("a", "href") and value:
                self.links.append(value)
            if name == "style" and value:
                self.loaded += [a or b for a, b in STYLE.findall(value)]


def main(folder):
    """Print what is wrong, and return the number of errors."""
    pages = {file: Page(file.read_text(encoding="utf-8")) for file in folder.rglob("*.html")}
    errors = []
    for file, page in pages.items():
        errors += [f"{file}: loads {address}" for address in page.loaded if OUTSIDE.match(address)]
        for address in page.links + page.loaded:
            parts = urlsplit(address)
            if parts.scheme or OUTSIDE.match(address):
                continue
            target = (file.parent / unquote(parts.path)).resolve() if parts.path else file
            if not target.exists():
                errors.append(f"{file}: no file {address}")
            elif target in pages and unquote(parts.fragment) not in pages[target].anchors:
                errors.append(f"{file}: no anchor {address}")
    for file in folder.rglob("*.css"):
        addresses = [a or b for a, b in STYLE.findall(file.read_text(encoding="utf-8"))]
        errors += [f"{file}: loads {address}" for address in addresses if OUTSIDE.match(address)]
    for file in folder.rglob("*.js"):
        if re.search(r"(?:import|src\s*=|fetch\()\s*\(?['\"`](?:https?:)?//", file.read_text(encoding="utf-8")):
            errors.append(f"{file}: loads a script from elsewhere")
    print("\n".join(errors) or f"{len(pages)} pages, nothing loaded from elsewhere, no dead link")
    return len(errors)


if __name__ == "__main__":
    sys.exit(1 if main(Path(sys.argv[1]).resolve()) else 0)
