"""The README as the package index shows it: it has neither our pictures nor our documents."""

import re
from pathlib import Path
from typing import Any

from hatchling.metadata.plugin.interface import MetadataHookInterface

README = Path(__file__).parents[1] / "README.md"
PICTURE = re.compile(r"^!\[([^]]*)]\((?!https?:)[^)]*\)\n(<!--.*?-->\n)?", re.MULTILINE)
DOCUMENT = re.compile(r"\[([^]]*)]\(docs/([\w-]+)(?:/README)?\.md[^)]*\)")
FILE = re.compile(r"\[([^]]*)]\((?!https?:|#)[^)]*\)")


def package_page(readme: str) -> str:
    """Without pictures of the repository; each document is named by the command that opens it."""
    text = DOCUMENT.sub(lambda found: f"{found[1]} (`tendril docs {found[2]}`)", PICTURE.sub("", readme))
    return FILE.sub(lambda found: found[1], text)


class PackagePage(MetadataHookInterface):
    """Gives the wheel its description."""

    def update(self, metadata: dict[str, Any]) -> None:
        """Called by hatchling for every build, an editable one too."""
        metadata["readme"] = {"content-type": "text/markdown", "text": package_page(README.read_text(encoding="utf-8"))}
