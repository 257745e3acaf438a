"""Links within a folder of HTML that lead nowhere."""

import html.parser
import pathlib
import urllib.parse


class Page(html.parser.HTMLParser):
    """What a page links to, and where it can be linked to."""

    LINKS = {"a": "href", "img": "src", "link": "href", "script": "src", "iframe": "src", "object": "data"}

    def __init__(self, path):
        super().__init__()
        self.links, self.anchors = set(), set()
        self.feed(path.read_text(errors="replace"))

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.anchors |= {attributes.get("id"), attributes.get("name")}
        if link := attributes.get(self.LINKS.get(tag)):
            self.links.add(link)


def broken(folder):
    """(page, link) of each link to a file or an anchor that is not there; what lies outside is not asked for."""
    pages = {path: Page(path) for path in sorted(pathlib.Path(folder).resolve().rglob("*.html"))}
    for path, page in pages.items():
        for link in sorted(page.links):
            parts = urllib.parse.urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            anchor = urllib.parse.unquote(parts.fragment)
            known = target in pages
            if not target.is_file() or (known and anchor and anchor not in pages[target].anchors):
                yield path, link
