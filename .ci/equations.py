"""Prepares the documents for the site: equations as MathML, which browsers draw without a script; mdbook runs it (docs/book.toml).

Without the package latex2mathml, which CI installs, equations stay as they are written.
"""

import json
import re
import sys

try:
    from latex2mathml.converter import convert
except ImportError:
    convert = None

CODE = re.compile(r"(```.*?```|`[^`\n]*`)", re.DOTALL)
INLINE = re.compile(r"\$([^$\n]+)\$")


def converted(text):
    """A chapter with its equations converted: blocks of math, and what stands between dollars outside of code."""
    parts = CODE.split(text)
    for k, part in enumerate(parts):
        if part.startswith("```math\n"):
            parts[k] = convert(part.removeprefix("```math\n").removesuffix("```").strip(), display="block")
        elif part.startswith("```csv\n"):
            # The highlighter knows no CSV and would complain in the console.
            parts[k] = part.replace("```csv", "```text", 1)
        elif not part.startswith("`"):
            parts[k] = INLINE.sub(lambda found: convert(found[1]), part)
    return "".join(parts)


def walk(items):
    for item in items:
        if isinstance(item, dict) and "Chapter" in item:
            chapter = item["Chapter"]
            chapter["content"] = converted(chapter["content"])
            walk(chapter["sub_items"])


# mdbook asks first whether a renderer is supported.
if sys.argv[1:2] != ["supports"]:
    _, book = json.load(sys.stdin)
    if convert:
        walk(book["items"])
    json.dump(book, sys.stdout)
