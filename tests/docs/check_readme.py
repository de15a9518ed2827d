"""check_readme.py SOURCE: README.md has at most 600 words outside its blocks of code; the
guide on embedding shows the program examples/correct_from_csv.cc as it is, and what README.md
shows in C++ stands in it; programs in examples/ have at most 40 lines; no line of a Markdown
file is longer than 120 characters, and what its links name exists, headings too.
"""

import pathlib
import re
import sys

source = pathlib.Path(sys.argv[1]).resolve()
faults = []

MOST_WORDS = 600


LINK = re.compile(r"(?:\]\(|^\[\w+\]: )([^)#\s]*)#?([^)\s]*)", re.MULTILINE)


def without_code(text):
    return re.sub(r"^ *```.*?^ *```", "", text, flags=re.DOTALL | re.MULTILINE)


def anchors_of(page):
    """The names of a page's headings in links, as GitHub makes them."""
    headings = re.findall(r"^#+ (.*)$", without_code(page.read_text()), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


readme = (source / "README.md").read_text()
words = re.findall(r"[^\W_][^\s|]*", re.sub(r"\]\([^)]*\)", "]", without_code(readme)))
if not 200 <= len(words) <= MOST_WORDS:
    faults.append(f"README.md has {len(words)} words, not at most {MOST_WORDS}")

example = (source / "examples/correct_from_csv.cc").read_text()
BLOCK = re.compile(r"^```cpp\n(.*?)^```", re.DOTALL | re.MULTILINE)
if example not in BLOCK.findall((source / "docs/guides/embedding.md").read_text()):
    faults.append("docs/guides/embedding.md does not show examples/correct_from_csv.cc as it is")
shown = BLOCK.findall(readme)
if not shown or not all("\n" + block in example for block in shown):
    faults.append("README.md shows lines that are not in examples/correct_from_csv.cc")
for program in (source / "examples").glob("*.cc"):
    if len(program.read_text().splitlines()) > 40:
        faults.append(f"{program}: more than 40 lines")

pages = [*source.glob("*.md"), *(source / "docs").rglob("*.md")]
for page in pages:
    text = page.read_text()
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > 120:
            faults.append(f"{page}:{number}: {len(line)} characters")
    for link, anchor in LINK.findall(without_code(text)):
        target = (page.parent / link).resolve() if link else page
        if re.match("https?:", link):
            continue
        if not target.exists():
            faults.append(f"{page}: there is no {link}")
        elif anchor and target.suffix == ".md" and anchor not in anchors_of(target):
            faults.append(f"{page}: {link} has no heading #{anchor}")
if len(pages) < 25:
    faults.append(f"only {len(pages)} pages were found")

for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
