"""Runs every command of the tutorials as a reader would: run_tutorials.py GELFMU [PAGE...]

In a page, a block `sh` is a command, `python` goes into one interpreter for the page, and a block with a file name
after its language, such as `csv lab.csv`, is a file. A block `text` after one of these must be printed by it: every
line, in any place, but for spaces and lines with `…`. Each page runs in an empty folder. Needs the packages of
docs/tutorials/requirements.txt. `--show` prints what the blocks print, for pages whose figures have changed.
"""

import contextlib
import io
import json
import os
import re
import subprocess
import sys
import tempfile
import time
import traceback
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = ROOT / "docs" / "tutorials"
BLOCK = re.compile(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def serve():
    """Execute blocks of Python, one line of JSON each, in one namespace."""
    names, pipe = {"__name__": "__main__"}, sys.stdout
    for line in sys.stdin:
        printed = io.StringIO()
        code = 0
        with contextlib.redirect_stdout(printed):
            try:
                exec(compile(json.loads(line), "tutorial", "exec"), names)
            except BaseException:
                traceback.print_exc(file=printed)
                code = 1
        print(json.dumps([code, printed.getvalue()]), file=pipe, flush=True)


class Reader:
    """Who follows one page in a folder of their own."""

    def __init__(self, folder, gelfmu):
        programs = [str(gelfmu.parent), str(Path(sys.executable).parent), os.environ["PATH"]]
        variables = {
            "PATH": os.pathsep.join(programs),
            "PYTHONPATH": str(ROOT / "python"),
            "GELFMU": str(gelfmu),
            "EXAMPLES": str(ROOT / "examples"),
            "MPLBACKEND": "agg",
        }
        self.options = {"cwd": folder, "env": {**os.environ, **variables}, "text": True, "encoding": "utf-8"}
        self.folder, self.python = Path(folder), None

    def follow(self, language, file, text):
        """Do what a block says; return the exit status and what was printed."""
        if file:
            (self.folder / file).write_text(text, encoding="utf-8")
            return 0, ""
        if language == "sh":
            done = subprocess.run(["bash", "-euo", "pipefail", "-c", text], stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, **self.options)
            return done.returncode, done.stdout
        if self.python is None:
            self.python = subprocess.Popen([sys.executable, __file__, "--serve"], stdin=subprocess.PIPE,
                                           stdout=subprocess.PIPE, **self.options)
        self.python.stdin.write(json.dumps(text) + "\n")
        self.python.stdin.flush()
        return json.loads(self.python.stdout.readline())

    def leave(self):
        """End the interpreter."""
        if self.python is not None:
            self.python.stdin.close()
            self.python.wait()


def words(line):
    """A line without its spaces and frames."""
    return " ".join(re.sub("[│┆]", " ", line).split())


def run_page(page, gelfmu, show):
    """Follow a page; return what went wrong."""
    errors, printed = [], None
    with tempfile.TemporaryDirectory() as folder:
        reader = Reader(folder, gelfmu)
        for language, file, text in BLOCK.findall(page.read_text(encoding="utf-8")):
            if language == "text":
                lines = {words(line) for line in (printed or "").splitlines()}
                wanted = [line for line in text.splitlines() if line.strip() and "…" not in line]
                errors += [f"{page.name}: not printed: {line}" for line in wanted if words(line) not in lines]
                continue
            if not file and language not in ("sh", "python"):
                continue
            begin = time.monotonic()
            status, printed = reader.follow(language, file, text)
            if show:
                print(f"--- {time.monotonic() - begin:.1f} s\n{text}\n{printed}")
            if status:
                errors.append(f"{page.name}: status {status} of\n{text}\n{printed}")
                break
        reader.leave()
    return errors


def main(gelfmu, *words):
    """Follow all pages, or those named."""
    show = "--show" in words
    names = [word for word in words if word != "--show"]
    pages = [PAGES / name for name in names] or sorted(PAGES.glob("*.md"))
    errors = []
    for page in pages:
        begin = time.monotonic()
        found = run_page(page, Path(gelfmu).resolve(), show)
        print(f"{page.name}: {'fails' if found else 'runs'}, {time.monotonic() - begin:.0f} s")
        errors += found
    print("\n".join(errors), end="\n" if errors else "")
    return 1 if errors else 0


if __name__ == "__main__":
    if sys.argv[1:] == ["--serve"]:
        serve()
    else:
        sys.exit(main(*sys.argv[1:]))
