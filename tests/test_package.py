"""What is installed: names, types, versions, examples, and what the README says."""

from __future__ import annotations

import importlib
import json
import re
import subprocess
import sys
from dataclasses import asdict
from importlib import metadata, resources
from pathlib import Path

import pytest
from packaging.markers import default_environment
from packaging.requirements import Requirement

import foldrs
from foldrs import _core
from foldrs.parameters import Parameters
from foldrs.synth import make_scene
from foldrs.template import builtin_templates

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = Path(foldrs.__file__).parent


def test_one_version_everywhere() -> None:
    cargo = re.search(r'^version = "(.+)"', (ROOT / "Cargo.toml").read_text(), re.MULTILINE)
    assert cargo is not None
    assert foldrs.__version__ == metadata.version("foldrs") == cargo.group(1)
    told = subprocess.run(["bash", ".ci/version"], cwd=ROOT, capture_output=True, text=True)
    assert (told.returncode, told.stdout, told.stderr) == (0, f"version {foldrs.__version__}\n", "")


def test_the_declared_rust_is_the_one_the_dependencies_demand() -> None:
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    told = json.loads(subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout)

    def number(package: dict[str, str]) -> tuple[int, ...]:
        return tuple(int(part) for part in (package["rust_version"] or "0").split("."))[:2]

    ours = {package["id"] for package in told["packages"] if package["id"] in told["workspace_members"]}
    needed = {node["id"]: node for node in told["resolve"]["nodes"]}
    used, waiting = set(ours), list(ours)
    while waiting:
        for dependency in needed[waiting.pop()]["deps"]:
            runs = any(kind["kind"] != "dev" for kind in dependency["dep_kinds"])
            if runs and dependency["pkg"] not in used:
                used.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    demanded = max(number(package) for package in told["packages"] if package["id"] in used - ours)
    assert {number(package) for package in told["packages"] if package["id"] in ours} == {demanded}
    oldest = ".".join(str(part) for part in demanded)
    assert f"Rust {oldest} or later" in (ROOT / "README.md").read_text()
    assert f"The oldest Rust is {oldest};" in (ROOT / "crates/foldrs/README.md").read_text()


def test_every_public_name_is_there_and_documented() -> None:
    for name in foldrs.__all__:
        assert getattr(foldrs, name) is not None
        assert name.startswith("__") or getattr(foldrs, name).__doc__
    assert set(foldrs.__all__) <= set(dir(foldrs))
    with pytest.raises(AttributeError, match="no_such_name"):
        foldrs.no_such_name  # noqa: B018


@pytest.mark.parametrize("modules", ["foldrs", "foldrs.cli"])
def test_import_is_light(modules: str) -> None:
    told = subprocess.run(
        [sys.executable, "-X", "importtime", "-c", f"import {modules}"],
        capture_output=True,
        check=True,
        text=True,
    )
    imported = {line.split("|")[-1].strip() for line in told.stderr.splitlines()}
    assert "foldrs._core" in imported
    assert not imported & {"cv2", "jinja2", "matplotlib", "rich.console", "shapely", "skimage"}
    assert modules == "foldrs.cli" or "click" not in imported


def test_fitting_does_not_wait_for_what_draws_and_evaluates() -> None:
    code = (
        "import sys, foldrs; foldrs.fit([[0, 0], [90, 0], [90, 60], [0, 60]], garment_type='towel'); "
        "print({'matplotlib', 'skimage', 'rich', 'click'} & set(sys.modules))"
    )
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    assert told.stdout.strip() == "set()"


def test_types_stub_and_templates_are_installed() -> None:
    files = resources.files("foldrs")
    assert files.joinpath("py.typed").is_file()
    assert files.joinpath("_core.pyi").is_file()
    assert any(entry.name.endswith(".json") for entry in files.joinpath("templates").iterdir())
    assets = {entry.name for entry in files.joinpath("report", "assets").iterdir()}
    assert assets == {"card.html", "page.css", "page.html", "page.js"}


def test_python_and_rust_have_the_same_defaults() -> None:
    told = json.loads(json.dumps(asdict(Parameters().matching)))  # tuples as lists
    assert told == json.loads(json.dumps(_core.default_parameters()))


@pytest.mark.parametrize("path", sorted(PACKAGE.rglob("*.py")), ids=lambda path: path.name)
def test_every_module_can_be_imported_alone(path: Path) -> None:
    parts = path.relative_to(PACKAGE.parent).with_suffix("").parts
    name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
    assert importlib.import_module(name).__doc__


def python_blocks(page: Path) -> str:
    return "\n".join(re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE))


@pytest.mark.parametrize("page", ["README.md", "docs/limits.md"])
def test_the_python_of_the_pages_runs(page: str, tmp_path: Path) -> None:
    make_scene(builtin_templates("t-shirt")[0], seed=3).write(tmp_path, "photo")
    (tmp_path / "page.py").write_text(python_blocks(ROOT / page))
    done = subprocess.run([sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout


def test_the_tutorial_runs_as_it_stands_and_draws_its_pictures(tmp_path: Path) -> None:
    command = [sys.executable, "docs/run_page.py", "docs/tutorial.md", tmp_path / "tutorial"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert " m, put it down at [" in done.stdout
    pictures = re.findall(r"!\[[^]]*\]\((\S+)\)", (ROOT / "docs/tutorial.md").read_text())
    assert pictures
    assert all((tmp_path / picture).is_file() for picture in pictures)


def test_every_page_about_a_stage_has_its_picture_drawn(tmp_path: Path) -> None:
    command = [sys.executable, "docs/draw_stages.py", tmp_path / "drawn"]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    pages = sorted((ROOT / "docs/stages").glob("*.md"))
    assert {path.stem for path in (tmp_path / "drawn").glob("*.png")} == {page.stem for page in pages}
    for page in pages:
        assert f"(drawn/{page.stem}.png)" in page.read_text()


@pytest.mark.parametrize("example", sorted((ROOT / "examples").glob("*.py")), ids=lambda path: path.stem)
def test_examples_run(example: Path, tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout
    assert not list(tmp_path.iterdir())


def test_links_of_the_pages_lead_somewhere() -> None:
    pages = [*ROOT.glob("*.md"), *(ROOT / "examples").rglob("*.md"), ROOT / "crates/foldrs/README.md"]
    for page in [*pages, *(ROOT / "docs").rglob("*.md")]:
        for target in re.findall(r"\]\(([^)#:\s]+)(?:#[^)]*)?\)", page.read_text()):
            drawn = target.startswith(("drawn/", "tutorial/"))  # when the documentation is built
            assert drawn or (page.parent / target).exists(), f"{page.name}: {target}"


def test_the_lock_pins_all_that_is_required() -> None:
    pins: dict[str, list[Requirement]] = {}
    locks = [(ROOT / f"requirements-{name}.lock").read_text() for name in ("dev", "rerun")]
    for line in "\n".join(locks).splitlines():
        if line and not line.lstrip().startswith("#"):
            pin = Requirement(line)
            pins.setdefault(pin.name, []).append(pin)
    for text in metadata.requires("foldrs") or []:
        wanted = Requirement(text)
        for version in ("3.10", "3.11", "3.12", "3.13"):
            environment = {
                **default_environment(),
                "python_version": version,
                "python_full_version": f"{version}.9",
            }
            pinned = {
                next(iter(pin.specifier)).version
                for pin in pins.get(wanted.name, [])
                if pin.marker is None or pin.marker.evaluate(environment)
            }
            assert len(pinned) == 1, (wanted.name, version, pinned)
            assert wanted.specifier.contains(*pinned), (str(wanted), pinned)
