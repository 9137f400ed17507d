"""Promises of the project about itself: the layering, the README's example, one version."""

from __future__ import annotations

import ast
import graphlib
import re
import sys
from pathlib import Path

import pytest

import pytracker as pt
from pytracker.study.fingerprint import NO_NUMBERS
from pytracker.tracking import found as found_by_python

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pytracker"


def imports(path: Path, root: Path = ROOT) -> set[str]:
    """Modules that a file names: of `from package import name` it is the module `name`, or the package."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            for name in node.names:
                inner = root.joinpath(*node.module.split("."), name.name)
                is_module = inner.with_suffix(".py").is_file() or (inner / "__init__.py").is_file()
                found.add(f"{node.module}.{name.name}" if is_module else node.module)
    return found


def files_of_package(root: Path = ROOT) -> dict[str, Path]:
    """By the name of the module; a folder's own is its `__init__`."""
    names = {path: path.relative_to(root).with_suffix("").parts for path in (root / "pytracker").rglob("*.py")}
    return {".".join(parts[:-1] if parts[-1] == "__init__" else parts): path for path, parts in names.items()}


def order_of_files(root: Path = ROOT) -> list[str]:
    """Each after all that it imports. Raises `graphlib.CycleError` where that cannot be."""
    files = files_of_package(root)
    needed = {name: {other for other in imports(path, root) if other in files} for name, path in files.items()}
    return list(graphlib.TopologicalSorter(needed).static_order())


def files_that_import(name: str) -> set[str]:
    return {
        path.relative_to(PACKAGE).as_posix()
        for path in PACKAGE.rglob("*.py")
        if any(module == name or module.startswith(name + ".") for module in imports(path))
    }


def test_libraries_stay_in_their_rooms() -> None:
    allowed = (
        "formats/video",
        "evidence/",
        "simulate/",
        "setup/calibrate",
        "report/overlay",
        "report/arm/overlay",
        "report/body/overlay",
    )
    assert all(path.startswith(allowed) for path in files_that_import("cv2"))
    assert all(path.startswith("report/") for path in files_that_import("matplotlib"))
    assert all(path.startswith("cli/") for path in files_that_import("typer") | files_that_import("rich"))
    assert files_that_import("pydantic") == {"recording/schema.py", "study/file.py", "formats/toml_file.py"}
    assert files_that_import("distributed") == {"study/schedule.py"}
    assert files_that_import("pyarrow") == {"study/store.py"}
    rust = [path for path in (ROOT / "rust").rglob("*.rs") if "pyo3" in path.read_text("utf-8")]
    assert all("python" in path.parts or path.name == "python.rs" for path in rust)


def room_of(module: str) -> str:
    """`report` for `pytracker.report.page`; empty for what is not ours, or is the face, or the compiled half."""
    parts = module.split(".")
    return parts[1] if parts[0] == "pytracker" and len(parts) > 1 and not parts[1].startswith("_") else ""


def files_of(room: str) -> list[Path]:
    return sorted((PACKAGE / room).rglob("*.py")) or [PACKAGE / f"{room}.py"]


def needs() -> dict[str, set[str]]:
    """Which rooms, folders and files of the package, each imports: anywhere in it, for types alone too."""
    there = [*PACKAGE.glob("*.py"), *(path.parent for path in PACKAGE.glob("*/__init__.py"))]
    rooms = {path.name.removesuffix(".py") for path in there} - {"__init__", "__main__"}
    found = {room: {room_of(module) for path in files_of(room) for module in imports(path)} for room in rooms}
    return {room: others - {room, ""} for room, others in found.items()}


def test_no_room_is_in_a_circle_of_imports() -> None:
    """Read from the sources: whatever is added is looked at."""
    order = list(graphlib.TopologicalSorter(needs()).static_order())
    assert len(order) == len(set(order)) >= 15


def test_no_file_is_in_a_circle_of_imports() -> None:
    assert len(order_of_files()) >= 150


@pytest.mark.parametrize(
    "line",
    [
        "from pytracker.room.other import it",
        "from pytracker.room import other",
        "from pytracker.room import Name",
        "from pytracker import room",
        "from pytracker import Face",
        "import pytracker",
    ],
)
def test_a_circle_of_imports_is_seen_however_it_is_written(line: str, tmp_path: Path) -> None:
    """`other` and the faces need `file`, which needs them in turn."""
    room = tmp_path / "pytracker" / "room"
    room.mkdir(parents=True)
    (tmp_path / "pytracker" / "__init__.py").write_text("from pytracker.room import Name as Face\n")
    (room / "__init__.py").write_text("from pytracker.room.file import Name\n")
    (room / "other.py").write_text("from pytracker.room.file import Name\n")
    (room / "file.py").write_text("Name = 1\n")
    assert order_of_files(tmp_path)[0] == "pytracker.room.file"
    (room / "file.py").write_text(f"{line}\nName = 1\n")
    with pytest.raises(graphlib.CycleError):
        order_of_files(tmp_path)


def test_data_flows_the_way_that_the_package_says() -> None:
    """No stage of the stream in the package's first lines needs a later one, by whatever way."""
    line = re.search(r"Data flows one way: (.*?)\.\s", (pt.__doc__ or "").replace("\n", " "))
    assert line is not None
    stream = re.findall(r"`(\w+)`", line[1])
    assert len(stream) >= 7
    direct = needs()
    after: dict[str, set[str]] = {}
    for room in graphlib.TopologicalSorter(direct).static_order():
        after[room] = direct[room].union(*(after[other] for other in direct[room]))
    for k, room in enumerate(stream):
        assert not after[room] & set(stream[k + 1 :]), room


def branches_on_the_kind(source: str) -> list[str]:
    """Where a file asks whether it has an arm or a body; an assertion that narrows a type asks nothing."""
    classes = re.compile(r"\b(Arm|Body)(Recording|Track|Scene|Method|File)\b")
    found: list[str] = []
    nodes: list[ast.AST] = [ast.parse(source)]
    while nodes:
        node = nodes.pop()
        if isinstance(node, ast.Assert):
            continue
        nodes += ast.iter_child_nodes(node)
        if isinstance(node, ast.Call) and ast.unparse(node.func) in ("isinstance", "issubclass"):
            found += [ast.unparse(node)] if classes.search(ast.unparse(node.args[1])) else []
        elif isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            found += [ast.unparse(node)] * any(
                isinstance(s, ast.Constant) and s.value in ("arm", "body") for s in sides
            )
    return found


@pytest.mark.parametrize(
    ("source", "count"),
    [
        ('x = 1 if recording.kind == "arm" else 2', 1),
        ("[t for t in tracks if isinstance(t, pt.BodyTrack | None)]", 1),
        ("assert isinstance(recording, ArmRecording)", 0),
        ('TABLES = {"arm": 1, "body": 2}', 0),
    ],
)
def test_a_branch_on_the_kind_is_seen(source: str, count: int) -> None:
    assert len(branches_on_the_kind(source)) == count


def test_nothing_branches_on_the_kind() -> None:
    """What differs is in the classes, dispatched on their types, or in tables by kind: a third would be added there."""
    found = {path.relative_to(PACKAGE): branches_on_the_kind(path.read_text("utf-8")) for path in PACKAGE.rglob("*.py")}
    assert not {path: asked for path, asked in found.items() if asked}


@pytest.mark.parametrize("room", [path.parent for path in sorted(PACKAGE.glob("*/__init__.py"))], ids=lambda p: p.name)
def test_the_map_of_a_room_names_what_is_in_it(room: Path) -> None:
    """Where its first lines have a table of files: all of them, and no others."""
    text = ast.get_docstring(ast.parse((room / "__init__.py").read_text("utf-8"))) or ""
    if "| file | what |" in text:
        named = set(re.findall(r"`(\w+)`", text))
        assert {path.stem for path in room.glob("*.py")} - {"__init__"} <= named
        rows = [row.split(" | ")[0] for row in text.splitlines() if row.startswith("| `")]
        first = {name for row in rows for name in re.findall(r"`(\w+)`", row)}
        assert first <= {path.stem for path in room.iterdir()}


def declared(path: Path) -> set[str] | None:
    """The names in a file's `__all__`; None where it has none."""
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "__all__":
            return set(ast.literal_eval(node.value))
    return None


def test_what_other_files_use_is_declared() -> None:
    """Names that are imported elsewhere stand in `__all__` of the file that has them."""
    files = {".".join(path.relative_to(ROOT).with_suffix("").parts): path for path in PACKAGE.rglob("*.py")}
    names = {module: declared(path) for module, path in files.items()}
    undeclared = []
    for path in files.values():
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            known = names.get(node.module or "") if isinstance(node, ast.ImportFrom) else None
            if isinstance(node, ast.ImportFrom) and known is not None:
                undeclared += [f"{path.name}: {node.module}.{a.name}" for a in node.names if a.name not in known]
    assert not undeclared


LATER_THAN_3_10 = {
    "typing": "Self Never LiteralString Required NotRequired Unpack TypeVarTuple override assert_never assert_type",
    "enum": "StrEnum ReprEnum", "datetime": "UTC", "itertools": "batched", "contextlib": "chdir", "tomllib": "loads",
}  # fmt: skip


def test_nothing_is_imported_that_the_oldest_python_lacks() -> None:
    """`from typing import Self` failed on 3.10, where nobody ran it."""
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.module in LATER_THAN_3_10:
                assert not {name.name for name in node.names} & set(LATER_THAN_3_10[node.module].split()), path


def test_the_face_is_small() -> None:
    assert len(pt.__all__) <= 45


def test_what_changes_no_number_is_there() -> None:
    assert all((PACKAGE / name).exists() for name in NO_NUMBERS)


def test_the_core_has_the_defaults_of_the_methods() -> None:
    """Who uses the crate without Python gets the same: read from the source."""
    text = (ROOT / "rust/arm/state.rs").read_text("utf-8")
    body = text[text.index("impl Default for Noise") :].split("bias: None")[0]
    ours = {name: float(value) for name, value in re.findall(r"(\w+): ([\d.]+),", body)}
    theirs = pt.Plain().parameters()
    assert len(ours) == 12
    assert ours == {name: theirs[name] for name in ours}


def test_numbers_that_both_languages_need_are_the_same() -> None:
    """How many frames are smoothed together, the columns of a worn arm's state, and where its constants are."""

    def number(file: str, name: str) -> int:
        found = re.search(rf"const {name}: usize = (\d+);", (ROOT / file).read_text("utf-8"))
        assert found is not None
        return int(found[1])

    assert number("rust/smoothing.rs", "WINDOW") == found_by_python.WINDOW
    assert f"const WINDOW_S: f64 = {found_by_python.WINDOW_S};" in (ROOT / "rust/smoothing.rs").read_text("utf-8")
    assert number("rust/arm/worn.rs", "CORE") == found_by_python.MOTION_COLUMNS
    setup = "rust/arm/setup.rs"
    assert (number(setup, "OF_ARM"), number(setup, "SHOULDER"), number(setup, "MOUNT")) == (7, 2, 5)
    assert number(setup, "PER_CAMERA") == 5


def test_every_public_name_is_documented() -> None:
    for name in pt.__all__:
        if name != "__version__":
            assert (getattr(pt, name).__doc__ or "").strip(), name


def test_one_version() -> None:
    cargo = re.search(r'^version = "(.*)"$', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)
    cff = re.search(r"^version: (.*)$", (ROOT / "CITATION.cff").read_text(), re.MULTILINE)
    assert cargo is not None
    assert cff is not None
    assert pt.__version__ == cargo[1] == cff[1]
    assert f"## {pt.__version__}" in (ROOT / "CHANGELOG.md").read_text("utf-8")


def test_readme_example_runs(
    simulated: Path, simulated_body: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    blocks = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text("utf-8"), re.DOTALL)
    assert len(blocks) == 3
    monkeypatch.chdir(tmp_path)
    (tmp_path / "trial03").symlink_to(simulated)
    (tmp_path / "teapot").symlink_to(simulated_body)
    scope: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "README.md", "exec"), scope)  # noqa: S102
    assert (tmp_path / "trial03-report" / "index.html").is_file()


def test_no_machine_paths_and_no_shared_data() -> None:
    pattern = re.compile(r"(^|[^a-z.])/(home|root|tmp|work)/")
    for path in [*PACKAGE.rglob("*.py"), *(ROOT / "rust").rglob("*.rs"), ROOT / "README.md", ROOT / "Makefile"]:
        assert not pattern.search(path.read_text("utf-8")), path


@pytest.mark.skipif(sys.platform == "win32", reason="reads a Makefile")
def test_make_help_lists_the_targets() -> None:
    text = (ROOT / "Makefile").read_text()
    for target in ("demo", "test", "lint", "bench", "bench-peers", "acceptance", "help"):
        assert re.search(rf"^{target}:.*## \w", text, re.MULTILINE), target
