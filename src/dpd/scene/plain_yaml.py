"""YAML in which nothing means something else than it looks like.

YAML 1.1 takes the last of two values of one key, reads 010 as 8, 1:30 as 90, and the word `no`
as false, and lets a few bytes stand for millions of values. All of that is refused here.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

from dpd.errors import shown

# libyaml reads a paper in a tenth of the time; PyYAML may come without it.
LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
DEEPEST = 64  # levels of lists and mappings; a paper has about ten
MOST_VALUES = 200_000  # keys and values, each counted as often as aliases repeat it
LONGEST_NUMBER = 400  # characters
MERGE = "tag:yaml.org,2002:merge"
KNOWN = {
    f"tag:yaml.org,2002:{kind}" for kind in ("str", "int", "float", "bool", "null", "map", "seq")
}
OPENING = (yaml.MappingStartEvent, yaml.SequenceStartEvent)
CLOSING = (yaml.MappingEndEvent, yaml.SequenceEndEvent)


class Problem(Exception):
    """What is wrong with a text, and on which line (from 1)."""

    def __init__(self, text, mark):
        super().__init__(text)
        self.line = mark.line + 1


def load_plain(text: str) -> Any:
    """The value that a YAML text stands for.

    Parameters
    ----------
    text : str

    Raises
    ------
    Problem
        If the text is YAML, but could be misunderstood or is too large.
    yaml.YAMLError
        If it is not YAML.
    """
    _check_depth(text)
    loader = LOADER(text)
    try:
        root = loader.get_single_node()
        if root is None:
            return None
        _Check(loader).size(root, "")
        return loader.construct_document(root)
    finally:
        loader.dispose()


def _check_depth(text):
    """Refuse deep nesting before anything recurses into it."""
    depth = 0
    for count, event in enumerate(yaml.parse(text, LOADER)):
        depth += isinstance(event, OPENING)
        depth -= isinstance(event, CLOSING)
        if depth > DEEPEST:
            raise Problem(
                f"lists and mappings are nested more than {DEEPEST} levels deep", event.start_mark
            )
        if count > MOST_VALUES:
            raise Problem(f"more than {MOST_VALUES} keys and values", event.start_mark)


class _Check:
    """A walk over all nodes of a document, each looked at once."""

    def __init__(self, loader):
        self._loader = loader
        self._sizes = {}
        self._open = set()

    def size(self, node, key):
        """Number of values that a node stands for, aliases written out."""
        if node in self._open:
            raise Problem(
                f"{key or 'the file'}: an alias inside of what it stands for", node.start_mark
            )
        if node in self._sizes:
            return self._sizes[node]
        self._open.add(node)
        if node.tag not in KNOWN | {MERGE}:
            self._refuse_tag(node, key)
        total = 1 + sum(self.size(child, name) for child, name in self._children(node, key))
        if total > MOST_VALUES:
            raise Problem(
                f"{key or 'the file'}: stands for more than {MOST_VALUES} values, aliases "
                "written out",
                node.start_mark,
            )
        self._open.remove(node)
        self._sizes[node] = total
        return total

    def _children(self, node, key):
        """Nodes inside a node, with their dotted keys."""
        inside = f"{key}." if key else ""
        if isinstance(node, yaml.MappingNode):
            self._refuse_twice(node, inside)
            for name, value in node.value:
                if not isinstance(name, yaml.ScalarNode):
                    raise Problem(
                        f"{key or 'the file'}: a key that is a list or mapping", name.start_mark
                    )
                there = shown(f"{inside}{name.value}", str)
                yield name, there
                yield value, there
        elif isinstance(node, yaml.SequenceNode):
            for place, value in enumerate(node.value):
                yield value, f"{inside}{place}"
        elif not node.style:
            _refuse_surprise(node, key)

    def _refuse_twice(self, node, inside):
        """Two keys that are one, as 2 and 2.0 are."""
        seen = {}
        for name, _ in node.value:
            if not isinstance(name, yaml.ScalarNode) or name.tag not in KNOWN | {MERGE}:
                continue
            if not name.style:
                _refuse_surprise(name, shown(f"{inside}{name.value}", str))
            same = name.value if name.tag == MERGE else self._loader.construct_object(name)
            if same in seen:
                raise Problem(
                    f"{shown(f'{inside}{name.value}', str)}: this key stands here twice, first on "
                    f"line {seen[same]}; keep one",
                    name.start_mark,
                )
            seen[same] = name.start_mark.line + 1

    def _refuse_tag(self, node, key):
        kind = shown(node.tag.rpartition(":")[2], str)
        what = f"a {kind}" if node.tag.startswith("tag:yaml.org") else f"of the kind {kind}"
        hint = (
            f"; for text write '{shown(node.value, str)}' in quotes"
            if isinstance(node, yaml.ScalarNode)
            else ""
        )
        raise Problem(
            f"{key or 'the file'}: YAML reads this as {what}, which nothing here is{hint}",
            node.start_mark,
        )


def _refuse_surprise(node, key):
    """Numbers and words that YAML 1.1 does not read as they look."""
    text, kind = node.value, node.tag.rpartition(":")[2]
    brief, meaning = shown(text, str), None
    if len(text) > LONGEST_NUMBER and kind in ("int", "float"):
        raise Problem(f"{key}: a number of {len(text)} digits", node.start_mark)
    if kind == "bool" and text.lower() in ("yes", "no", "on", "off"):
        meaning = f"{_truth(text)}; write that, or '{text}' in quotes for text"
    elif kind in ("int", "float") and ":" in text:
        meaning = f"a number to the base 60; write '{brief}' in quotes for text, or a plain number"
    elif kind == "int" and re.fullmatch(r"[-+]?0[0-9_]+", text):
        meaning = (
            f"{int(text.replace('_', ''), 8)}, a number to the base 8; leave out the leading 0"
        )
    if meaning:
        raise Problem(f"{key}: YAML reads {brief} as {meaning}", node.start_mark)


def _truth(word):
    return "true" if word.lower() in ("yes", "on") else "false"
