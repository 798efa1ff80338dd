"""How Sphinx makes the site: ``make site``.

The source folder is the whole repository: every page is the Markdown file that a code host shows, links between files
hold unchanged, and the address of a page is its path. `contents.rst` is the table of contents,
`templates/landing.html` the first page.
"""

from __future__ import annotations

import os
import sys
import tomllib
from pathlib import Path

SITE = Path(__file__).parent
ROOT = SITE.parents[1]
sys.path[:0] = [str(ROOT / "python"), str(SITE / "extensions")]

# Modules are imported for their docstrings alone: the site needs no compiled core.
import core_stand_in  # noqa: E402
import notebooks  # noqa: E402

core_stand_in.install()

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
project = PROJECT["name"]
version = release = PROJECT["version"]
author = "The hydrocrane contributors"
copyright = author
html_title = f"{project} {version}"
html_show_sphinx = False

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinxcontrib.katex",
    "sphinx_copybutton",
    "source_views",
    "first_page",
    "notebooks",
]

# --- pages ------------------------------------------------------------------------------------------------------------
root_doc = "docs/site/contents"
include_patterns = [
    "docs/*.md",
    "docs/**/*.md",
    "docs/site/*.rst",
    "docs/site/groups/*.rst",
    "docs/site/python/*.rst",
    "README.md",
    "NOTATION.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "machines/README.md",
    "benches/README.md",
    "reproductions/**/*.md",
]
exclude_patterns = [
    ".*",
    "target",
    "results",
    "dist",
    "crates",
    "cockpit",
    "python",
    "tests",
    "shared",
    "benches/solvers",
]
source_suffix = {".rst": "restructuredtext", ".md": "myst-nb"}

# --- Markdown, as code hosts read it ----------------------------------------------------------------------------------
myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_fence_as_directive = ["math"]
# Deep enough for every heading; anchors are spelt as code hosts spell them.
myst_heading_anchors = 6

globals().update(notebooks.settings(ROOT))

# --- docstrings -------------------------------------------------------------------------------------------------------
autodoc_typehints = "none"
autodoc_member_order = "bysource"
# `"undoc-members": False` would turn them on: to Sphinx an option that is named is an option that is given.
autodoc_default_options = {"members": True}
autosummary_generate = False
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
add_module_names = False
python_use_unqualified_type_names = True
nitpicky = True

# --- mathematics: KaTeX out of a folder of npm, nothing from another host ------------------------------------------
KATEX = ROOT / "results" / "katex" / "static"
katex_css_path = "katex.min.css"
katex_options = "throwOnError: true"

# --- looks ------------------------------------------------------------------------------------------------------------
html_theme = "furo"
templates_path = ["templates"]
html_static_path = ["static", os.path.relpath(KATEX, SITE)]
html_css_files = ["site.css"]
html_favicon = "../../cockpit/src/icon.svg"
html_copy_source = False
html_show_copyright = False
html_last_updated_fmt = None
pygments_style = "default"
pygments_dark_style = "github-dark"
html_theme_options = {
    "source_directory": "",
    "top_of_page_buttons": [],
    "light_css_variables": {"color-brand-primary": "#0b5c8f", "color-brand-content": "#0b5c8f", "pictures": "none"},
    # Pictures are drawn on white: white and black change places, almost to the theme's background, and hues stay.
    "dark_css_variables": {
        "color-brand-primary": "#6cb8ea",
        "color-brand-content": "#6cb8ea",
        "pictures": "invert(0.93) hue-rotate(180deg)",
    },
}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
