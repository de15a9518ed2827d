"""check_flags.py SOURCE: every flag that a page of docs/ names, and every option that a message of
the library names, is one that a command or script has.

docs/commands.md, which a test compares with the commands, says what these have.
"""

import pathlib
import re
import sys


# Of programs that are not ours.
OF_OTHERS = {"oversubscribe"}


def flags_of_commands(source):
    """Names of flags by command: an entry of the page has one, or those that it names as in another."""
    flags = {}
    for section in (source / "docs/commands.md").read_text().split("\n## ")[1:]:
        entries = re.findall(r"^- (`--\w+`(?:,\s+`--\w+`)*)", section, re.MULTILINE)
        flags[section.split()[0]] = {"helpfull", *re.findall(r"\w+", " ".join(entries))}
    return flags


def flags_of_scripts(source):
    """All that scripts and benchmarks mention as an option."""
    names = set()
    for folder in ("scripts", "benchmarks", "cmake"):
        for file in (source / folder).rglob("*"):
            if file.is_file() and file.suffix in ("", ".py", ".sh", ".cmake", ".cc"):
                names.update(re.findall(r"--([a-z][\w-]*)", file.read_text(errors="ignore")))
    return names


def without_no(name, known):
    return name[2:] if name.startswith("no") and name[2:] in known else name


def main():
    source = pathlib.Path(sys.argv[1])
    commands = flags_of_commands(source)
    known = set().union(*commands.values()) | flags_of_scripts(source)
    faults = []
    for page in [source / "README.md", *sorted((source / "docs").rglob("*.md"))]:
        for number, line in enumerate(page.read_text().splitlines(), 1):
            for name in re.findall(r"`--([a-z]\w*)(?![\w-])", line):
                if name.endswith("_") or name in OF_OTHERS:  # "all --selection_…"
                    continue
                if without_no(name, known) not in known:
                    faults.append(f"{page.relative_to(source)}:{number}: no command has --{name}")
    # Messages of a correction name the options that would help.
    for file in sorted((source / "mle/maintain").glob("*.cc")):
        for names in re.findall(r'(?:options = |\s)\{("[a-z_]+"(?:,\s*"[a-z_]+")*)\}[,;})]',
                                file.read_text()):
            for name in re.findall(r'"(\w+)"', names):
                if name not in commands["mle_correct"]:
                    faults.append(f"{file.relative_to(source)}: mle_correct has no --{name}")
    print("\n".join(faults))
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
