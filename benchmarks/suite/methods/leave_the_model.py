"""leave_the_model.py FOLDER: nothing has changed, whatever the record says."""

import pathlib
import sys

pathlib.Path(sys.argv[1], "decision.txt").write_text("no_change\n")
