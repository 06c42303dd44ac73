"""The command line: ``foldrs template show``, and the commands of the modules ``*_cli``."""

from __future__ import annotations

from pathlib import Path

import click

from foldrs import __version__
from foldrs.errors import FoldrsError
from foldrs.evaluate_cli import evaluate_command
from foldrs.fit_cli import fit_command
from foldrs.synth_cli import demo_command, synth_command


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="foldrs")
def main() -> None:
    """Tell which garment lies folded on a table, where it is folded, and where to grasp it."""


main.add_command(demo_command)
main.add_command(evaluate_command)
main.add_command(fit_command)
main.add_command(synth_command)


@main.group("template")
def template_group() -> None:
    """Look at template files."""


@template_group.command("show")
@click.argument("template", metavar="FILE")
@click.option(
    "--out",
    type=click.Path(path_type=Path, dir_okay=False),
    help="Picture to write; default: FILE's stem .png",
)
def show_command(template: str, out: Path | None) -> None:
    """Draw a template FILE (or a built-in KIND) with its landmarks and grasp pairs."""
    from foldrs.template import builtin_templates, load_template
    from foldrs.template_plot import save_template_picture

    try:
        chosen = load_template(template) if Path(template).suffix else builtin_templates(template)[0]
        path = out or Path(f"{chosen.name}.png")
        save_template_picture(chosen, path)
    except FoldrsError as error:
        raise click.ClickException(str(error)) from error
    click.echo(f"wrote {path}")
