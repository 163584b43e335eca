# SPDX-License-Identifier: GPL-3.0-or-later
"""Names that Blender and USD have for the same thing."""

PREFIX = "tailor:"
"""Custom properties of a garment that are options of its recipe."""

UV_SET = "st"
"""The name of the UV map that is active for rendering, as Blender exports it."""

LONGEST = 38
"""Bytes of the name of a seam or fold: Blender's names of custom properties have 63."""

SEAMS = "uv_seam"
"""The edge set of the seams that are marked in Edit Mode."""


def key(*parts: str) -> str:
    """The custom property of an option: ``tailor:seam:side:width``."""
    return PREFIX + ":".join(parts)


def usd_name(name: str) -> str:
    """The name as Blender's exporter writes it: letters, digits and underscores, of any language."""
    made = "".join(letter if ("a" + letter).isidentifier() else "_" for letter in name)
    return made if made and made.isidentifier() or made.startswith("_") else "_" + made


def ascii_names(name: str) -> tuple[str, str]:
    """The names as Blender's exporter writes it without *Allow Unicode*: 4.5 has an underscore for each byte of other letters, later
    versions for each letter.
    """
    return tuple(usd_name("".join(sign if ord(sign) < 128 else "_" for sign in signs)) for signs in (map(chr, name.encode()), name))


def uniquely(found, taken: set[str]) -> dict[str, str]:
    """A name in USD for each of the names, in their order, and none of those that are taken."""
    named = {}
    for name in found:
        named[name] = unique(usd_name(name), taken)
        taken.add(named[name])
    return named


def unique(name: str, taken) -> str:
    """The name, or the name with the first free number."""
    made, number = name, 1
    while made in taken:
        made, number = f"{name}_{number:03}", number + 1
    return made


def quoted(name: str) -> str:
    """The name in an expression of sets, which quotes what is no word."""
    is_word = name.isascii() and name.isidentifier()
    return name if is_word else '"' + name.replace("\\", "\\\\").replace('"', '\\"') + '"'
