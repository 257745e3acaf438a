"""Whether a command printed what a page shows."""

import math
import re

NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
# What differs from machine to machine, or from one equally good axis to another: of these lines the first word counts.
OF_THE_MACHINE = ("times", "time", "speed", "search", "searched", "device", "driver", "memory", "compute", "0:0")
AXIS = re.compile(r"^(deviation|\s) .* (along|degrees about) \(")
ELISION = "..."
TOLERANCE = 0.05  # of a number, and of the largest number of its line: fewer digits than a page shows


def label(line):
    return (line.split() or [""])[0]


def alike(shown, printed):
    if label(shown) in OF_THE_MACHINE:
        return label(printed) == label(shown)
    if AXIS.match(shown):
        return bool(AXIS.match(printed))
    if NUMBER.sub("#", shown).split() != NUMBER.sub("#", printed).split():
        return False
    if shown.endswith(" ms"):
        return True
    numbers = [list(map(float, NUMBER.findall(line))) for line in (shown, printed)]
    largest = max(map(abs, numbers[0]), default=0)
    return all(math.isclose(a, b, rel_tol=TOLERANCE, abs_tol=TOLERANCE * min(largest, 1)) for a, b in zip(*numbers))


def differences(shown, printed):
    """Lines that are shown and not printed and, where nothing is elided, the other way round."""
    rest, missing = list(printed), []
    for line in shown:
        if line.strip() == ELISION or not line.strip():
            continue
        match = next((other for other in rest if alike(line, other)), None)
        if match is None:
            missing.append(f"shown and not printed: {line}")
        else:
            rest.remove(match)
    if shown and not any(line.strip() == ELISION for line in shown):
        missing += [f"printed and not shown: {line}" for line in rest if line.strip()]
    return missing
