"""Run the commands and the Python of a page, as they stand, in a folder: python docs/run_page.py PAGE FOLDER.

Commands are the indented lines that begin with ``foldrs``; they run first, one by one.
"""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

CALL = "from foldrs.cli import main; main()"
"""The command of this Python's foldrs, whatever is on the PATH."""


def main() -> None:
    """Run the page; the exit status is that of the first part that fails."""
    page, folder = Path(sys.argv[1]).read_text(), Path(sys.argv[2])
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for command in re.findall(r"^    foldrs (.+)$", page, re.MULTILINE):
        subprocess.run([sys.executable, "-c", CALL, *shlex.split(command)], cwd=folder, check=True)
    code = "\n".join(re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE))
    subprocess.run([sys.executable, "-"], cwd=folder, input=code, text=True, check=True)


if __name__ == "__main__":
    main()
