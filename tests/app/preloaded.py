"""All that commands and tests of them import; decoders are silenced first, which they heed when they load."""

from importlib import import_module

from app.__main__ import keep_quiet
from app.cli import COMMANDS

WINDOWS = ("gui", "demo")

keep_quiet()
for name in ("pytest", *(f"app.commands.{command}" for command in COMMANDS if command not in WINDOWS)):
    import_module(name)
