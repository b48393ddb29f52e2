"""Hooks of the site: pages from outside `docs`, and links to what the site does not have."""

import re
from pathlib import Path
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

OUTSIDE = {"README.md": "start.md", "CONTRIBUTING.md": "contributing.md"}
"""Pages beside the folder `docs` -> what the site calls them."""
LINK = re.compile(r"\[([^\[\]]*)\]\((?!https?:|#)([^)\s]+)\)")


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages from outside."""
    root = Path(config.config_file_path).parent
    for name, page in OUTSIDE.items():
        text = LINK.sub(_from_root, (root / name).read_text(encoding="utf-8"))
        files.append(File.generated(config, page, content=text))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Point links that leave the folder to the pages that the site has of them."""
    return LINK.sub(_from_docs, markdown)


def _from_root(link: re.Match[str]) -> str:
    """A link of a page beside `docs`, as seen from within."""
    text, target = link.groups()
    if target.startswith("docs/"):
        inside = target.removeprefix("docs/")
        return f"[{text}]({inside})" if "." in inside else text
    return f"[{text}]({OUTSIDE[target]})" if target in OUTSIDE else text


def _from_docs(link: re.Match[str]) -> str:
    """A link of a page in `docs`; what is nowhere on the site remains as its words."""
    text, target = link.groups()
    if not target.startswith("../"):
        return link[0]
    page = OUTSIDE.get(target.removeprefix("../"))
    return f"[{text}]({page})" if page else text
