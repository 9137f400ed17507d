"""The core's files, as their `use` lines have them: none is in a circle, and the engine knows neither arm nor body."""

from __future__ import annotations

import graphlib
import re
from pathlib import Path

import pytest

RUST = Path(__file__).parents[1] / "rust"
USE = re.compile(r"^\s*(pub(?:\([a-z ]+\))?\s+)?use\s+([^;]+);", re.MULTILINE)
PATH = re.compile(r"(?<![\w:])(?:super|crate)(?:::\w+)+")


def spread(tree: str) -> list[str]:
    """Every path of a `use`, whose braces may be nested."""
    start = tree.find("{")
    if start < 0:
        return [tree.split(" as ", maxsplit=1)[0].strip()]
    parts, depth, last = [], 0, start + 1
    for k in range(start + 1, tree.rindex("}") + 1):
        depth += {"{": 1, "}": -1}.get(tree[k], 0)
        if (tree[k] == "," and depth == 0) or depth < 0:
            parts.append(tree[last:k])
            last = k + 1
    return [path for part in parts if part.strip() for path in spread(tree[:start].strip() + part.strip())]


class Modules:
    """Every file below a folder, and what each needs of the others; tests in them left out."""

    def __init__(self, folder: Path) -> None:
        self.text: dict[tuple[str, ...], str] = {}
        for path in folder.rglob("*.rs"):
            parts = path.relative_to(folder).with_suffix("").parts
            text = path.read_text("utf-8").split("#[cfg(test)]\nmod tests")[0]
            self.text[() if parts == ("lib",) else parts] = re.sub(r"//.*", "", text)
        self.exported = {name: self._exported(name) for name in self.text}

    def _exported(self, module: tuple[str, ...]) -> dict[str, tuple[str, ...]]:
        """Names that it hands on, with where they are from."""
        paths = [path for public, tree in USE.findall(self.text[module]) if public for path in spread(tree)]
        return {path.split("::")[-1]: self.absolute(module, path) for path in paths}

    def absolute(self, module: tuple[str, ...], path: str) -> tuple[str, ...]:
        parts = tuple(path.split("::"))
        if parts[0] == "crate":
            return parts[1:]
        while parts and parts[0] in ("super", "self"):
            module, parts = (module[:-1] if parts[0] == "super" else module), parts[1:]
        return module + parts

    def home(self, path: tuple[str, ...]) -> tuple[str, ...] | None:
        """The file that a path leads into; None where it is another crate's."""
        for length in range(len(path), -1, -1):
            module = path[:length]
            if module in self.text:
                onward = self.exported[module].get(path[length]) if length < len(path) else None
                return self.home(onward + path[length + 1 :]) if onward is not None else module
        return None

    def needs(self, module: tuple[str, ...]) -> set[tuple[str, ...]]:
        # What a file hands on it need not know: who asks it is led further.
        own = [path for public, tree in USE.findall(self.text[module]) if not public for path in spread(tree)]
        inline = PATH.findall(USE.sub("", self.text[module]))
        mine = [path for path in (*own, *inline) if path.split("::")[0] in ("crate", "super", "self")]
        found = {self.home(self.absolute(module, path)) for path in mine}
        return {other for other in found if other is not None} - {module}

    def order(self) -> list[tuple[str, ...]]:
        """Each after all that it needs. Raises `graphlib.CycleError` where that cannot be."""
        return list(graphlib.TopologicalSorter({module: self.needs(module) for module in self.text}).static_order())


def test_no_file_is_in_a_circle() -> None:
    assert len(Modules(RUST).order()) >= 75


@pytest.mark.parametrize("use", ["use super::far::{self, Far};", "use crate::Far;", "fn f() { super::far::far() }"])
def test_a_circle_is_seen_however_it_is_written(use: str, tmp_path: Path) -> None:
    (tmp_path / "lib.rs").write_text("mod near;\npub mod far;\npub use far::Far;\n")
    (tmp_path / "far.rs").write_text("use super::near::{Near, other::Other};\npub struct Far;\n")
    (tmp_path / "near.rs").write_text("pub struct Near;\n")
    assert Modules(tmp_path).order()[0] == ("near",)
    (tmp_path / "near.rs").write_text(f"{use}\npub struct Near;\n")
    with pytest.raises(graphlib.CycleError):
        Modules(tmp_path).order()


def test_the_engine_knows_no_subject() -> None:
    modules = Modules(RUST)
    engine = [module for module in modules.text if module[0:1] in (("filter",), ("particles",), ("resample",))]
    assert len(engine) >= 12
    assert not {other[0] for module in engine for other in modules.needs(module) if other} & {"arm", "body", "tracker"}
    of_arm, of_body = (
        {other[0:1] for m in modules.text if m[0:1] == (s,) for other in modules.needs(m)} for s in ("arm", "body")
    )
    assert ("body",) not in of_arm
    assert ("arm",) not in of_body
