"""The command line: the commands of the modules ``*_cli``."""

from __future__ import annotations

import click

from foldrs import __version__
from foldrs.evaluate_cli import evaluate_command
from foldrs.fit_cli import fit_command
from foldrs.synth_cli import demo_command, synth_command
from foldrs.template_cli import template_group


@click.group(context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(__version__, prog_name="foldrs")
def main() -> None:
    """Tell which garment lies folded on a table, where it is folded, and where to grasp it."""


main.add_command(demo_command)
main.add_command(evaluate_command)
main.add_command(fit_command)
main.add_command(synth_command)
main.add_command(template_group)
