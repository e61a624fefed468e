"""Sphinx extension: formulas are typeset by KaTeX when the site is built, so that its pages need no script for them.

The environment variable KATEX names the folder of the npm package; its style sheet and fonts are copied into the site.
"""

import json
import os
import shutil
import subprocess
from pathlib import Path

from docutils import nodes
from sphinx.util import logging

KATEX = Path(os.environ["KATEX"])
RENDERER = Path(__file__).with_name("katex.mjs")
logger = logging.getLogger(__name__)


class Typesetter:
    """One process of node, which takes a formula and gives its HTML, a line of JSON each."""

    def __init__(self):
        pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
        command = ["node", str(RENDERER), str(KATEX / "dist" / "katex.mjs")]
        self.process = subprocess.Popen(command, text=True, encoding="utf-8", **pipes)

    def html(self, node, display):
        self.process.stdin.write(json.dumps({"tex": node.astext(), "display": display}) + "\n")
        self.process.stdin.flush()
        answer = json.loads(self.process.stdout.readline())
        if "error" in answer:
            logger.warning("KaTeX: %s", answer["error"], location=node)
        return answer.get("html", "")

    def close(self, *_):
        self.process.stdin.close()
        self.process.wait()


def copy_fonts(app, _):
    """Copy the style sheet, the fonts of today's browsers and the licence of KaTeX."""
    target = Path(app.outdir) / "_static" / "katex"
    shutil.copytree(KATEX / "dist" / "fonts", target / "fonts", ignore=lambda _, names: [
        name for name in names if not name.endswith(".woff2")], dirs_exist_ok=True)
    for file in (KATEX / "dist" / "katex.min.css", KATEX / "LICENSE"):
        shutil.copy(file, target)


def setup(app):
    """Register the renderer of formulas."""
    typesetter = Typesetter()

    def inline(translator, node):
        translator.body.append(f'<span class="math">{typesetter.html(node, False)}</span>')
        raise nodes.SkipNode

    def block(translator, node):
        translator.body.append(f'<div class="math-block">{typesetter.html(node, True)}</div>')
        raise nodes.SkipNode

    app.add_html_math_renderer("katex", (inline, None), (block, None))
    app.connect("builder-inited", lambda app: copy_fonts(app, None))
    app.connect("build-finished", typesetter.close)
    return {"parallel_read_safe": True, "parallel_write_safe": False}
