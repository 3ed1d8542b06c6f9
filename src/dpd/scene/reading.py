"""From plain data to settings: sections, and the pages that a scene names by their keys."""

from __future__ import annotations

import os
from typing import Any

from dpd.errors import UserError, shown, suggestion
from dpd.own import load
from dpd.page import Observable, Start, Term, find, names
from dpd.scene.sections import Basics
from dpd.sentences import attempt

NEEDED = ("integrator", "repulsion", "thermostat")  # in every scene


class Settings:
    """What the file of a scene says, each section by itself.

    Attributes
    ----------
    where : str
        File to name in messages.
    data : dict
        As plain data, with all defaults but those of observables.
    terms : dict of str to Term
        By key.
    observe : dict of str to Observable
        By key.
    start : Start
    start_changes : dict of str to Term
        Terms with the settings that they have while the start is made, if others.
    own_pages : dict of str to type
        Pages of one's own, by key.
    page_files : dict of str to str
        Digests of their files, by whole paths.
    """

    def __init__(self, where: str) -> None:
        self.where = where
        self.data: dict[str, Any] = {}
        self.terms: dict[str, Any] = {}
        self.observe: dict[str, Any] = {}
        self.start: Any = None
        self.start_changes: dict[str, Any] = {}
        self.own_pages: dict[str, Any] = {}
        self.page_files: dict[str, str] = {}
        self._wrong: list[str] = []

    def _load_pages(self, given, folder):
        """Pages of one's own; files are named by their whole paths from then on."""
        for place, one in enumerate(given if isinstance(given, list) else []):
            named = one if isinstance(one, dict) else {"path": one, "sha256": ""}
            path, digest = named.get("path"), named.get("sha256")
            if not isinstance(path, str) or not isinstance(digest, str):
                continue  # which is told with all else that is wrong
            path = os.path.abspath(os.path.join(folder, path))
            loaded, now = load(path, f"{self.where}: pages.{place}", digest)
            twice = sorted(self.own_pages.keys() & loaded.keys())
            if path not in self.page_files and twice:
                raise UserError(
                    f"{self.where}: pages.{place}: {path}: {twice[0]!r} is a page of another file "
                    "as well; take another key"
                )
            self.own_pages |= loaded
            self.page_files[path] = now

    def _keys(self, kind):
        """Of all pages of a kind, those of one's own last."""
        own = [key for key, page in self.own_pages.items() if issubclass(page, kind)]
        return [*names(kind), *own]

    def _page(self, kind, key):
        """The page of a key that there is."""
        own = self.own_pages.get(key)
        return own if own and issubclass(own, kind) else find(kind, key)

    def _read(self, data):
        """Settings of all sections and pages; refused with a line for each mistake."""
        terms = self._keys(Term)
        sections = [*terms, "start"]
        basic = {key: value for key, value in data.items() if key not in sections}
        basics, self._wrong = attempt(Basics, basic, more=sections)
        for key in terms:
            if key in data or key in NEEDED:
                page = self._page(Term, key)
                if key not in data and page.has_required():
                    self._wrong.append(f"the file: the key {key!r} is missing ({page.summary()})")
                else:
                    self.terms[key] = self._section(page, data.get(key, {}), key)
        self._read_start(data.get("start", {}))
        for item in basics.observe if basics else ():
            self._read_observable(item)
        if not self._wrong:
            self._read_start_forces()
        if self._wrong:
            wrong = dict.fromkeys(self._wrong)
            raise UserError("\n".join(f"{self.where}: {text}" for text in wrong))
        self.data = basics.model_dump(exclude_none=True, by_alias=True, exclude={"pages"})
        self.data |= {key: term.plain() for key, term in self.terms.items()}
        self.data["pages"] = [{"path": p, "sha256": d} for p, d in self.page_files.items()]

    def _section(self, page, given, key):
        found, problems = attempt(page, given, key)
        self._wrong += problems
        return found

    def _read_start(self, given):
        """The first configuration, by its method."""
        known, method = self._keys(Start), Start.model_fields["method"].default
        if isinstance(given, dict) and isinstance(given.get("method"), str):
            method = given["method"]
        if method not in known:
            text = f"{shown(method)} is not known; {suggestion(method, known)}"
            self._wrong.append(f"start.method: {text}")
            return
        page = self._page(Start, method)
        others = given.keys() - page.model_fields.keys() if isinstance(given, dict) else ()
        for key in others:
            of = [each for each in known if key in self._page(Start, each).model_fields]
            if of:
                text = f"has no effect with method {method!r}; take 'method: {of[0]}'"
                self._wrong.append(f"start.{key}: {text}, or remove the key")
                given = {each: value for each, value in given.items() if each != key}
        self.start = self._section(page, given, "start")

    def _read_start_forces(self):
        """Terms that act otherwise while the start is made."""
        forces = self.start.forces
        for key, given in dict(forces.model_extra or {}).items():
            terms = self._keys(Term)
            if key not in terms or not self._may_act_in_start(key):
                known = sorted([*type(forces).model_fields, *filter(self._may_act_in_start, terms)])
                text = f"unknown key {shown(key)}; {suggestion(key, known)}"
                self._wrong.append(f"start.forces: {text}")
                continue
            page, whole = self._page(Term, key), given
            if key in self.terms and isinstance(given, dict):
                whole = self.terms[key].changed(given)
            found = self.start_changes[key] = self._section(page, whole, f"start.forces.{key}")
            if found is not None and not page.bare:  # numbers as its settings have them
                forces.model_extra[key] = {each: found.plain()[each] for each in given}

    def _may_act_in_start(self, key):
        page = self._page(Term, key)
        return page.own_in_start and (key in self.terms or not page.joins)

    def _read_observable(self, item):
        """An observable by name, or by name with settings."""
        name, settings = item, {}
        if isinstance(item, dict):
            name, settings = next(iter(item.items()), ("", {}))
        known = self._keys(Observable)
        if isinstance(item, dict) and len(item) != 1:
            text = f"{shown(item)} should be one name with its settings, as a list item: "
            self._wrong.append(f"observe: {text}- rdf: {{range: 3}}")
        elif name not in known:
            text = f"{shown(name)} is not known; {suggestion(name, known)}"
            self._wrong.append(f"observe: {text}")
        elif name in self.observe:
            self._wrong.append(f"observe: {name!r} is there more than once; keep one")
        else:
            page = self._page(Observable, name)
            self.observe[name] = self._section(page, settings, f"observe.{name}")
