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

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "pytracker"


def imports(path: Path) -> set[str]:
    found = set()
    for node in ast.walk(ast.parse(path.read_text("utf-8"))):
        if isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found.add(node.module)
    return found


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
        "report/arm_overlay",
        "report/body_overlay",
    )
    assert all(path.startswith(allowed) for path in files_that_import("cv2"))
    assert all(path.startswith("report/") for path in files_that_import("matplotlib"))
    assert all(path.startswith("cli/") for path in files_that_import("typer") | files_that_import("rich"))
    assert files_that_import("pydantic") == {"schema.py", "study/file.py", "toml_file.py"}
    assert files_that_import("distributed") == {"study/schedule.py"}
    assert files_that_import("pyarrow") == {"study/store.py"}
    rust = [path for path in (ROOT / "rust").rglob("*.rs") if "pyo3" in path.read_text("utf-8")]
    assert all("python" in path.parts or path.name == "python.rs" for path in rust)


def module_of(path: Path) -> str:
    """`pytracker.report.page`, `pytracker.report` for its `__init__`."""
    parts = list(path.relative_to(ROOT).with_suffix("").parts)
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def is_file(module: str) -> bool:
    """Whether there is such a file of ours."""
    path = ROOT.joinpath(*module.split("."))
    return path.with_suffix(".py").is_file() or (path / "__init__.py").is_file()


def needed_at_once(path: Path) -> set[str]:
    """Modules of ours that a file imports as it is loaded: not for types alone, and not within a function."""
    found = set()
    for node in ast.parse(path.read_text("utf-8")).body:
        if isinstance(node, ast.ImportFrom) and node.module:
            inner = {f"{node.module}.{name.name}" for name in node.names}
            # Of a package the module that is named.
            modules = {name for name in inner if is_file(name)}
            found |= modules if len(modules) == len(inner) else {node.module, *modules}
        elif isinstance(node, ast.Import):
            found |= {name.name for name in node.names}
    return found


def test_no_file_is_in_a_circle_of_imports() -> None:
    """Read from the sources: whatever is added is looked at."""
    files = {module_of(path): path for path in PACKAGE.rglob("*.py") if "cli" not in path.parts}
    # What is typed on the command line is the package as users have it, and starts from its face.
    needs = {name: needed_at_once(path) & set(files) - {name} for name, path in files.items() if name != "pytracker"}
    order = list(graphlib.TopologicalSorter(needs).static_order())
    assert order.index("pytracker.rotation") < order.index("pytracker.load") < order.index("pytracker.report.write")


def test_data_flows_one_way() -> None:
    """No stage imports a later one."""
    stages = [
        ["rotation"], ["skeleton", "average_skeleton"], ["formats"], ["recording"], ["projection", "schema"],
        ["load", "load_arm", "load_body", "load_imu", "load_keypoints", "load_truth", "load_worn"],
        ["evidence"], ["joint_track", "track", "track_arm", "track_body"],
        ["found"], ["doubts"], ["setup"], ["cycle"], ["evaluate"], ["study"], ["report"], ["batch"],
        ["reproduce"], ["cli"],
    ]  # fmt: skip
    order = {name: number for number, names in enumerate(stages) for name in names}
    for path in PACKAGE.rglob("*.py"):
        stage = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if stage not in order:
            continue
        for module in imports(path):
            parts = module.split(".")
            if parts[0] == "pytracker" and len(parts) > 1 and parts[1] in order:
                # recording.py is what flows; evidence and track need it, formats do not.
                assert order[parts[1]] <= order[stage], f"{path.name} imports {module}"


def test_what_changes_no_number_is_there() -> None:
    assert all((PACKAGE / name).exists() for name in NO_NUMBERS)


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
