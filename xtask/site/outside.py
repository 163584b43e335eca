"""A hook of MkDocs for links that leave docs/: pictures of examples/ are copied, other files are named without a link.

`cargo xtask site` checks before that all of them exist."""
import re
from pathlib import Path

from mkdocs.structure.files import File

ROOT = Path(__file__).resolve().parents[2]


def on_files(files, config):
    for path in sorted((ROOT / "examples").glob("*.png")):
        files.append(File(f"examples/{path.name}", str(ROOT), config.site_dir, config.use_directory_urls))
    return files


def on_page_markdown(markdown, **_):
    markdown = re.sub(r"\]\(\.\./(examples/\w+\.png)\)", r"](\1)", markdown)
    return re.sub(r"(?<!!)\[([^\]]*)\]\(\.\./[^)]*\)", r"\1", markdown)
