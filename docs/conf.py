"""The documentation's site, made by `make docs`: what Sphinx needs to know."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

from it2hys import __version__  # noqa: E402

project = "it2hys"
author = "the it2hys developers"
project_copyright = "2026, the it2hys developers"
version = release = __version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "mathml",
    "run",
    "generated",
]
exclude_patterns = ["_ext", "_generated", "requirements.lock"]
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
napoleon_google_docstring = False
autodoc_typehints = "none"
html_math_renderer = "mathml"
html_theme = "furo"
html_title = f"it2hys {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
