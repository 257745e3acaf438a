"""What was built beside the command: the manual page and the completions, and what --help says that they must have."""

import os
import pathlib
import re

from command import COMMAND, CommandTest

FOLDER = pathlib.Path(COMMAND).parent / "manual"
COMMANDS = ("align", "batch", "compare", "devices")


class ManualTest(CommandTest):
    def options(self, command):
        """Every name of an option in a command's help."""
        text = self.succeed(command, "--help")
        names = set()
        for line in re.findall(r"^  (-.*)$", text, re.MULTILINE):
            names |= set(re.findall(r"^-\w|(?<=,)--[\w-]+|^--[\w-]+", line))
        self.assertIn("--help", names)
        return names
