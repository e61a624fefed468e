"""Configuration of the documentation site; `docs/build.sh` builds it."""

import re
import sys
import tomllib
from pathlib import Path

from pygments.lexers.special import TextLexer

DOCS = Path(__file__).parent
ROOT = DOCS.parent
sys.path[:0] = [str(ROOT / "python"), str(DOCS / "site")]

project = "ballistic-gel"
author = "The ballistic-gel authors"
copyright = author  # noqa: A001
release = tomllib.loads((ROOT / "Cargo.toml").read_text(encoding="utf-8"))["package"]["version"]
version = release

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon", "katex_math"]
myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
nb_execution_mode = "off"  # notebooks/run.py executes them
nb_ipywidgets_js = {}  # nothing from elsewhere: a progress bar is shown as text
exclude_patterns = ["site/**", "requirements.*"]
highlight_language = "none"  # indented blocks are commands or what they print
nitpicky = True
nitpick_ignore_regex = [("py:.*", r".*")]  # types of packages that the build does not install

autodoc_mock_imports = ["matplotlib", "numpy", "pandas", "pyvista", "tqdm", "xarray"]
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
autosummary_generate = False
napoleon_google_docstring = False

html_theme = "furo"
html_title = "ballistic-gel"
html_static_path = ["site/static"]
html_css_files = ["katex/katex.min.css", "site.css"]
html_copy_source = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0b5d8a", "color-brand-content": "#0b5d8a"},
    "dark_css_variables": {"color-brand-primary": "#6cb8e0", "color-brand-content": "#6cb8e0"},
}

# Pages of this site whose source lies outside of docs/, by the path that a link on a code host has.
_MOVED = {"../benches/peers/README.md": "project/peers.md"}


def _prepare(app, name, source):
    for path, page in _MOVED.items():
        source[0] = source[0].replace(f"]({path}", f"]({page}")
    # Files of a tutorial are named above their text.
    source[0] = re.sub(r"^```(\w+) ([\w.-]+\.\w+)$", r"```{code-block} \1\n:caption: \2", source[0], flags=re.MULTILINE)
    if name == "cite":
        source[0] = source[0].replace("{VERSION}", f"{{{release}}}")


def _show_notebooks(app, path, name, source):
    """Lead links to the notebooks, which docs/build.sh brings into docs/, to their pages."""
    source[0] = source[0].replace("](../notebooks/", "](notebooks/")


def setup(app):
    """Follow links to pages from outside, name the version, and let tables of commas be plain text."""
    app.connect("source-read", _prepare)
    app.connect("include-read", _show_notebooks)
    for language in ("bibtex", "csv"):
        app.add_lexer(language, TextLexer)
