"""List the licences of all that foldrs needs to run; fail if one is not known to allow its use here.

python docs/list_licences.py             prints docs/licences.md
python docs/list_licences.py --check     only checks
"""

from __future__ import annotations

import json
import subprocess
import sys
from importlib import metadata

from packaging.requirements import Requirement

PERMISSIVE = {
    "0BSD",
    "Apache-2.0",
    "BSD-2-Clause",
    "BSD-3-Clause",
    "CC0-1.0",
    "HPND",
    "ISC",
    "MIT",
    "MIT-CMU",
    "PSF-2.0",
    "Unicode-3.0",
    "Unlicense",
    "Zlib",
}
"""Licences (SPDX) under which a dependency may be used by a program under MIT or Apache-2.0."""

TOOLS = {"dev", "docs"}
"""Extras that hold tools of development: nothing of them comes with foldrs."""

SPELLINGS = {
    "Apache 2.0": "Apache-2.0",
    "Apache Software License": "Apache-2.0",
    "BSD": "BSD-3-Clause",
    "BSD 3-Clause": "BSD-3-Clause",
    "BSD License": "BSD-3-Clause",
    "Dual License": "Apache-2.0 OR BSD-3-Clause",
    "MIT License": "MIT",
    "Python Software Foundation License": "PSF-2.0",
    "matplotlib": "PSF-2.0",  # its own licence, made after that of Python
}
"""What packages without an SPDX expression write, and what is meant."""

INTRODUCTION = """# Licences

foldrs is under MIT or Apache-2.0, at the user's choice. What it needs to run is below; all of it may be used
so. The compiled module holds the crates; the Python packages are installed beside it, from their own wheels.
Some of those wheels bundle libraries under the LGPL (GEOS in shapely, FFmpeg in OpenCV), which are linked
dynamically and not changed.

Packages of optional extras are named where they are installed when this page is made.

`make licences` makes this page, `make lint` checks it.
"""

Row = tuple[str, str, str]


def crates() -> list[Row]:
    """Crates in the compiled module, with version and licence."""
    command = ["cargo", "metadata", "--format-version", "1", "--locked", "--all-features"]
    found = json.loads(subprocess.run(command, check=True, capture_output=True).stdout)
    packages = {package["id"]: package for package in found["packages"]}
    nodes = {node["id"]: node for node in found["resolve"]["nodes"]}
    ours = set(found["workspace_members"])
    seen, waiting = set(ours), list(ours)
    while waiting:
        for dependency in nodes[waiting.pop()]["deps"]:
            used = any(kind["kind"] is None for kind in dependency["dep_kinds"])
            if used and dependency["pkg"] not in seen:
                seen.add(dependency["pkg"])
                waiting.append(dependency["pkg"])
    chosen = (packages[one] for one in seen - ours)
    return sorted(
        (one["name"], one["version"], (one["license"] or "").replace("/", " OR ")) for one in chosen
    )


def packages() -> list[Row]:
    """Python packages needed at run time, by the optional extras too, with version and licence."""
    found: dict[str, Row] = {}
    optional = set(metadata.metadata("foldrs").get_all("Provides-Extra") or []) - TOOLS
    waiting = [("foldrs", optional)]
    seen = set()
    while waiting:
        package, extras = waiting.pop()
        for text in metadata.requires(package) or []:
            requirement = Requirement(text)
            name = requirement.name.lower().replace("_", "-")
            needed = requirement.marker is None or any(
                requirement.marker.evaluate({"extra": extra}) for extra in ["", *extras]
            )
            step = (name, frozenset(requirement.extras))
            if not needed or step in seen:
                continue
            seen.add(step)
            try:
                found[name] = (name, metadata.version(name), licence_of(name))
            except metadata.PackageNotFoundError:
                print(f"{name} is not installed here: its licence is not checked", file=sys.stderr)
                continue
            waiting.append((name, requirement.extras))
    return sorted(found.values())


def licence_of(name: str) -> str:
    """Licence of an installed package: its SPDX expression, or what its older metadata say."""
    about = metadata.metadata(name)
    told = [about.get("License-Expression") or ""]
    told += [
        line.split(" :: ")[-1] for line in about.get_all("Classifier") or [] if line.startswith("License")
    ]
    told += [(about.get("License") or "").split("\n")[0].strip()]
    for licence in told:
        licence = SPELLINGS.get(licence, licence)
        if licence and allowed(licence):
            return licence
    return next((licence for licence in told if licence), "unknown")


def allowed(expression: str) -> bool:
    """Whether an SPDX expression leaves a permissive choice; every part of an AND must be permissive."""
    plain = expression.replace("WITH LLVM-exception", "").replace("(", " ( ").replace(")", " ) ").split()
    # `A OR B AND C` and `(A OR B) AND C` alike: in every AND part, one of the choices.
    parts = " ".join(word for word in plain if word not in "()").split(" AND ")
    return all(any(choice.strip() in PERMISSIVE for choice in part.split(" OR ")) for part in parts)


def section(title: str, rows: list[Row]) -> str:
    """Rows as a table in Markdown."""
    lines = [f"| {name} | {version} | {licence} |" for name, version, licence in rows]
    return "\n".join([f"\n## {title}\n", "| name | version | licence |", "|---|---|---|", *lines])


def main() -> None:
    """Print the page, or only check."""
    rust, python = crates(), packages()
    unclear = [row for row in rust + python if not allowed(row[2])]
    if unclear:
        sys.exit("licences not known to allow use here: " + "; ".join(" ".join(row) for row in unclear))
    if "--check" not in sys.argv:
        print(INTRODUCTION + section("Crates", rust) + "\n" + section("Python packages", python))


if __name__ == "__main__":
    main()
