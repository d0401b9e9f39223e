"""Write the API reference: pages made from the docstrings, and a front page for each way of coming in.

    python docs/api.py [reports/api]

Shown are the public names, the rooms of the package, and the modules to which the README leads. The pages
need no network. Kernels are loaded without the JIT, which would hide that they are functions.
"""

from __future__ import annotations

import importlib
import os
import pkgutil
import re
import sys
import warnings
from pathlib import Path
from types import ModuleType

os.environ["NUMBA_DISABLE_JIT"] = "1"

import pdoc.doc
import pdoc.render

import hsr
from hsr.pages.frame import siblings

HERE = Path(__file__).parent
README = HERE.parent / "README.md"
TYPES_FOR_HINTS = "Error parsing type annotation"
"""Types that are imported for hints alone are shown as they are written."""


def shown() -> dict[str, pdoc.doc.Module]:
    """Import what is shown; the public names, which are loaded on first use, become plain ones."""
    rooms = [f"hsr.{one.name}" for one in pkgutil.iter_modules(hsr.__path__)]
    linked = re.findall(r"\]\(hsr/([\w/]+?)(?:/__init__)?\.py\)", README.read_text(encoding="utf-8"))
    names = {"hsr", *rooms, *(f"hsr.{path.replace('/', '.')}" for path in linked)}
    modules = {name: pdoc.doc.Module(importlib.import_module(name)) for name in sorted(names)}
    for module in modules.values():
        module.obj.__doc__ = listed(module.obj.__doc__ or "")
    vars(hsr).update({name: getattr(hsr, name) for name in hsr.__all__})
    return modules


def listed(text: str) -> str:
    """Make the glossary of a docstring a list of terms."""
    before, heading, terms = text.partition("Glossary\n--------\n")
    told = re.sub(r"^(\S.*)\n +", r"- **\1**: ", terms, flags=re.MULTILINE)
    return f"{before}## Glossary\n\n{told}" if heading else text


def write(folder: Path) -> Path:
    """Write the pages into a folder and return the front page."""
    warnings.filterwarnings("ignore", TYPES_FOR_HINTS)
    pdoc.render.configure(docformat="numpy", show_source=False, template_directory=HERE / "templates")
    front = ModuleType("index", (HERE / "index.md").read_text(encoding="utf-8"))
    pdoc.render.env.globals["front"] = pdoc.doc.Module(front)
    pdoc.render.env.globals["siblings"] = siblings(folder.resolve() / "index.html")
    modules = shown()
    pages = {"index.html": pdoc.render.html_index(modules), "search.js": pdoc.render.search_index(modules)}
    for name, module in modules.items():
        pages[f"{name.replace('.', '/')}.html"] = pdoc.render.html_module(module, modules)
    for name, text in pages.items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(text, encoding="utf-8")
    return folder / "index.html"


if __name__ == "__main__":
    print("API reference:", write(Path(sys.argv[1] if len(sys.argv) > 1 else "reports/api")))
