#!/usr/bin/env python3
"""make_site.py SOURCE OUT: the documents as one site without a network, in OUT/index.html.

Pages are the Markdown files in docs/ and those of the project's folder, made HTML by
cmark-gfm, so that they read as they do in a repository's browser. The menu is the list in
docs/README.md, which every page must be in. Links to headers lead to the API reference that
Doxygen has written to OUT/api (with OUT/api.tag), links to other files to copies of these.
The search is of headings, text and names of the API, by docs/site/site.js.

Exit code 1 where a link, an anchor or an image leads nowhere, in any page of the site.
"""

import dataclasses
import html
import html.parser
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import urllib.parse
import xml.etree.ElementTree

source, out = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
here = pathlib.Path(__file__).resolve().parent

PROJECT = "Model Life Extension"
INDEX = "docs/README.md"
ROOT_PAGES = ["README.md", "CONTRIBUTING.md", "CHANGELOG.md"]
faults = []


@dataclasses.dataclass
class Page:
    path: str  # of the Markdown file in the project
    target: str  # of the page in the site
    title: str = ""
    body: str = ""
    sections: list = dataclasses.field(default_factory=list)  # (anchor, heading, text)


def target_of(path):
    if path == INDEX:
        return "index.html"
    if path == "README.md":
        return "overview.html"
    return re.sub(r"\.md$", ".html", re.sub(r"^docs/", "", path))


def page_paths():
    documents = sorted((source / "docs").rglob("*.md"))
    return [str(path.relative_to(source)) for path in documents] + ROOT_PAGES


def plain(fragment):
    """The text of a piece of HTML."""
    return html.unescape(re.sub(r"<[^>]*>", "", fragment))


def with_anchors(body):
    """Headings get the names that links use (those of GitHub)."""
    taken = {}

    def named(match):
        name = re.sub(r"[^\w\- ]", "", plain(match[2]).lower()).replace(" ", "-")
        count = taken[name] = taken.get(name, -1) + 1
        anchor = f"{name}-{count}" if count else name
        return f'<h{match[1]} id="{html.escape(anchor)}">{match[2]}</h{match[1]}>'

    return re.sub(r"<h([1-6])>(.*?)</h\1>", named, body, flags=re.DOTALL)


def sections_of(body, title):
    """The parts of a page that the search finds, each with the anchor that leads there."""
    parts = re.split(r'<h[1-6] id="([^"]*)">(.*?)</h[1-6]>', body, flags=re.DOTALL)
    for anchor, heading, text in zip(parts[1::3], parts[2::3], parts[3::3]):
        heading = plain(heading)
        yield ("" if heading == title else anchor, heading, " ".join(plain(text).split()))


def read_page(path):
    made = subprocess.run(
        ["cmark-gfm", "--unsafe", "-e", "table", "-e", "autolink", "-e", "strikethrough",
         str(source / path)], capture_output=True, text=True, check=True)
    page = Page(path, target_of(path), body=with_anchors(made.stdout))
    page.body = page.body.replace("<table>", '<div class="scroll"><table>')
    page.body = page.body.replace("</table>", "</table></div>")
    heading = re.search(r"<h1[^>]*>(.*?)</h1>", page.body, re.DOTALL)
    page.title = plain(heading[1]) if heading else path
    page.sections = list(sections_of(page.body, page.title))
    return page


def relative(target, page_target):
    return os.path.relpath(target, os.path.dirname(page_target) or ".")


@dataclasses.dataclass
class Api:
    headers: dict  # path of a header in the project → page
    names: list  # (name, page with anchor, kind)


def read_api():
    headers, names = {}, []
    tree = xml.etree.ElementTree.parse(out / "api.tag").getroot()
    for compound in tree.iter("compound"):
        kind, name = compound.get("kind"), compound.findtext("name")
        place = f"api/{compound.findtext('filename')}"
        if kind == "file":
            folder = pathlib.Path(compound.findtext("path"))
            headers[os.path.relpath(folder / name, source)] = place
        elif kind in ("class", "struct"):
            names.append((name, place, kind))
        elif kind == "namespace":
            names += [(f"{name}::{member.findtext('name')}",
                       f"api/{member.findtext('anchorfile')}#{member.findtext('anchor')}",
                       member.get("kind")) for member in compound.iter("member")]
    if len(headers) < 50 or len(names) < 200:
        faults.append(f"api.tag: only {len(headers)} headers and {len(names)} names")
    return Api(headers, sorted(set(names)))


def listing(path):
    """What a link to a file or folder of the project shows."""
    if path.is_dir():
        names = sorted(entry.name + "/" * entry.is_dir() for entry in path.iterdir())
        return "\n".join(name for name in names if not name.startswith((".", "__")))
    return path.read_text(errors="replace")


def copy_source(path):
    """The page of a file that is neither a document nor a header; images and pages are copied."""
    if path.suffix in (".png", ".svg", ".html"):
        target = f"images/{path.name}"
        (out / "images").mkdir(exist_ok=True)
        shutil.copyfile(path, out / target)
        return target
    name = str(path.relative_to(source))
    target = f"source/{name}.html"
    if not (out / target).exists():
        body = f"<h1>{html.escape(name)}</h1>\n<pre>{html.escape(listing(path))}</pre>"
        write_page(Page(name, target, name, body))
    return target


def new_link(link, page, pages, api):
    """Where a link of a Markdown file leads in the site."""
    if re.match(r"[a-z]+:", link):
        return link
    path, _, anchor = link.partition("#")
    if not path:
        return link
    target = (source / page.path).parent / urllib.parse.unquote(path)
    target = pathlib.Path(os.path.normpath(target))
    if not target.exists() or source not in [target, *target.parents]:
        faults.append(f"{page.path}: there is no {link}")
        return link
    name = str(target.relative_to(source))
    if name in pages:
        place = pages[name].target
    elif name == "docs":
        place = "index.html"
    else:
        place = api.headers.get(name) or copy_source(target)
    return relative(place, page.target) + (f"#{anchor}" if anchor else "")


def redirect(page, pages, api):
    def changed(match):
        link = new_link(html.unescape(match[2]), page, pages, api)
        return f'{match[1]}="{html.escape(link)}"'

    page.body = re.sub(r'\b(href|src)="([^"]*)"', changed, page.body)


menu = []  # (group, [(title, target)])


def read_menu(pages):
    """The groups of the index, and their pages; every page stands in one."""
    text = (source / INDEX).read_text()
    listed = {INDEX, "README.md"}
    for group, items in re.findall(r"^## (.*)\n\n((?:- .*\n?)+)", text, re.MULTILINE):
        entries = []
        for title, link in re.findall(r"\[([^\]]*)\]\(([^)#]*)\)", items):
            path = os.path.normpath(f"docs/{link}")
            listed.add(path)
            if path in pages:
                entries.append((title, pages[path].target))
        menu.append((group, entries))
    menu[[group for group, _ in menu].index("Developer")][1].append(
        ("API", "api/index.html"))
    faults.extend(f"{INDEX}: does not name {path}" for path in sorted(set(pages) - listed))


def bar(root):
    return (f'<header class="site-bar"><a href="{root}index.html">{PROJECT}</a>'
            '<form role="search"><input type="search" aria-label="Search the documentation" '
            'placeholder="Search" autocomplete="off"><ol class="found" hidden></ol></form>'
            "</header>")


def head(root):
    return (f'<link rel="stylesheet" href="{root}site.css">'
            f'<script>const SITE_ROOT = "{root}";</script>'
            f'<script defer src="{root}search_index.js"></script>'
            f'<script defer src="{root}site.js"></script>')


def root_of(target):
    return "../" * target.count("/")


def write_page(page):
    root = root_of(page.target)
    groups = []
    for group, entries in menu:
        links = "".join(
            f'<li><a href="{root}{target}"{" aria-current=page" * (target == page.target)}>'
            f"{html.escape(title)}</a></li>" for title, target in entries)
        groups.append(f"<p>{html.escape(group)}</p><ul>{links}</ul>")
    target = out / page.target
    target.parent.mkdir(parents=True, exist_ok=True)
    target.write_text(f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{html.escape(page.title)} – {PROJECT}</title>
{head(root)}</head>
<body>{bar(root)}
<div class="site"><nav><details open><summary>Contents</summary>{"".join(groups)}</details></nav>
<main>{page.body}</main></div></body></html>
""")


def write_index(pages, api):
    entries = [[page.target + (f"#{anchor}" if anchor else ""), page.title, heading, text]
               for page in pages.values() for anchor, heading, text in page.sections]
    entries += [[place, "API", name, kind] for name, place, kind in api.names]
    (out / "search_index.js").write_text(
        "const SEARCH_INDEX = " + json.dumps(entries, ensure_ascii=False) + ";\n")


def frame_api():
    """The bar of the site, with its search, above each page of Doxygen's, and without Doxygen's
    links to lists of private classes, which it does not write."""
    for path in (out / "api").glob("*.html"):
        text = path.read_text()
        if "site-bar" in text:
            continue
        if 'name="nested-classes"' not in text:
            text = re.sub(r'<a href="#nested-classes">.*?</a> &#124;\s*', "", text)
        text = text.replace("</head>", head("../") + "</head>", 1)
        path.write_text(re.sub(r"(<body[^>]*>)", lambda match: match[1] + bar("../"), text, count=1))


class Links(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.links, self.anchors = [], set()
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("href", "src") and value:
                self.links.append(value)
            if name in ("id", "name") and value:
                self.anchors.add(value)


def check_links():
    """What leads nowhere; returns how many links were followed."""
    parsed = {path: Links(path.read_text(errors="replace")) for path in out.rglob("*.html")}
    followed = 0
    for path, page in parsed.items():
        for link in page.links:
            if re.match(r"[a-z]+:", link):
                continue
            followed += 1
            place, _, anchor = link.partition("#")
            place, anchor = urllib.parse.unquote(place), urllib.parse.unquote(anchor)
            target = pathlib.Path(os.path.normpath(path.parent / place)) if place else path
            if not target.is_file():
                faults.append(f"{path.relative_to(out)}: dead link {link}")
            elif anchor and target in parsed and anchor not in parsed[target].anchors:
                faults.append(f"{path.relative_to(out)}: no place {link}")
    return followed


def main():
    pages = {path: read_page(path) for path in page_paths()}
    api = read_api()
    read_menu(pages)
    for page in pages.values():
        redirect(page, pages, api)
        write_page(page)
    write_index(pages, api)
    for name in ("site.css", "site.js"):
        shutil.copyfile(here / name, out / name)
    frame_api()
    followed = check_links()
    for fault in faults:
        print(fault)
    print(f"{len(pages)} documents, {len(api.names)} names of the API, {followed} links followed, "
          f"{len(faults)} dead")
    return 1 if faults or followed < 1000 else 0


sys.exit(main())
