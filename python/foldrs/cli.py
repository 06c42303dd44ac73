"""The command line: the commands of the modules ``*_cli``."""

from __future__ import annotations

import os

import click
from click import shell_completion

from foldrs import __version__
from foldrs.evaluate_cli import evaluate_command
from foldrs.fit_cli import fit_command
from foldrs.synth_cli import demo_command, synth_command
from foldrs.template_cli import template_group

_HELP = """\
Tell which garment lies folded on a table, where it is folded, and where to grasp it.

\b
Examples:
  foldrs demo                                    draw a folded garment and explain it
  foldrs fit photo.jpg                           explain a photograph
  foldrs fit photos/*.jpg --out results --plot   many, with result files and pictures
  foldrs fit photos/*.jpg --out results --resume take an interrupted batch up again
  foldrs template show pants                     look at a template
  foldrs completion bash                         completion for a shell

Every command explains itself: foldrs COMMAND --help.
"""


@click.group(context_settings={"help_option_names": ["-h", "--help"]}, help=_HELP)
@click.version_option(__version__, prog_name="foldrs")
@click.pass_context
def main(context: click.Context) -> None:
    """Set what all commands have in common."""
    if os.environ.get("NO_COLOR"):
        context.color = False


@main.command("completion")
@click.argument("shell", type=click.Choice(["bash", "fish", "zsh"]))
@click.pass_context
def completion_command(context: click.Context, shell: str) -> None:
    """Print what makes a SHELL complete commands, options and file names.

    For bash: foldrs completion bash >> ~/.bashrc
    """
    kind = shell_completion.get_completion_class(shell)
    assert kind is not None
    click.echo(kind(main, {}, "foldrs", "_FOLDRS_COMPLETE").source())


main.add_command(demo_command)
main.add_command(evaluate_command)
main.add_command(fit_command)
main.add_command(synth_command)
main.add_command(template_group)
