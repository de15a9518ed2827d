"""check_readme.py SOURCE: the program that README.md shows is the one in examples/, of at
most 40 lines; no line of a Markdown file is longer than 120 characters, and what its links
name exists.
"""

import pathlib
import re
import subprocess
import sys

source = pathlib.Path(sys.argv[1]).resolve()
faults = []

example = (source / "examples/correct_from_csv.cc").read_text()
shown = re.findall(r"^```cpp\n(.*?)^```", (source / "README.md").read_text(), re.S | re.M)
if example not in shown:
    faults.append("README.md does not show examples/correct_from_csv.cc as it is")
for program in (source / "examples").glob("*.cc"):
    if len(program.read_text().splitlines()) > 40:
        faults.append(f"{program}: more than 40 lines")

pages = [*source.glob("*.md"), *(source / "docs").glob("*.md")]
for page in pages:
    text = page.read_text()
    for number, line in enumerate(text.splitlines(), 1):
        if len(line) > 120:
            faults.append(f"{page}:{number}: {len(line)} characters")
    for link in re.findall(r"\]\(([^)#\s]+)[^)]*\)", text):
        if not re.match("https?:", link) and not (page.parent / link).exists():
            faults.append(f"{page}: there is no {link}")
if len(pages) < 15:
    faults.append(f"only {len(pages)} pages were found")

for fault in faults:
    print(fault)
sys.exit(1 if faults else 0)
