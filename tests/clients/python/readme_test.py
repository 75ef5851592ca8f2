"""README.md shows what the demo prints: each line of it is one of the demo's, perhaps with columns
left out.
"""

import pathlib
import re
import subprocess
import unittest

from server_case import BINARIES

ROOT = pathlib.Path(__file__).parents[3]
# Processors round differently in the last digits: counts of inliers by some points in 10 000.
MAX_SHARE = 0.002

NUMBER = re.compile(r"(?<![\w.])-?\d+(?:\.\d+)?(?![\w.])")


def demo_lines(text: str) -> list[str]:
    """The lines of README's block that follows "The demo prints"."""
    block = text[text.index("The demo prints") :].split("```")[1]
    return [line for line in block.strip().splitlines() if line.strip()]


def fields(line: str) -> list[str]:
    """What two or more spaces divide, as in tables."""
    return re.split(r"\s{2,}", line.strip())


def is_alike(shown: str, printed: str) -> bool:
    """The same words, and numbers that differ by no more than rounding does."""
    if NUMBER.sub("#", shown) != NUMBER.sub("#", printed):
        return False
    for a, b in zip(NUMBER.findall(shown), NUMBER.findall(printed)):
        digit = 10.0 ** -len(a.partition(".")[2])
        if abs(float(a) - float(b)) > max(1.01 * digit, MAX_SHARE * abs(float(b))):
            return False
    return True


def is_shortened(shown: str, printed: str) -> bool:
    """Whether the fields are among those printed, in their order."""
    rest = iter(fields(printed))
    return all(any(is_alike(field, other) for other in rest) for field in fields(shown))


class Readme(unittest.TestCase):
    def test_lines_of_the_demo_are_what_it_prints(self):
        run = subprocess.run(
            ["bash", ROOT / "clients/demo/demo.sh", "1"],
            env={"PATH": "/usr/bin:/bin", "CWM_BIN": str(BINARIES)},
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )
        self.assertEqual(run.returncode, 0, run.stderr)
        printed = run.stdout.splitlines()
        shown = demo_lines((ROOT / "README.md").read_text())
        self.assertGreaterEqual(len(shown), 9)
        wrong = [line for line in shown if not any(is_shortened(line, each) for each in printed)]
        self.assertEqual(wrong, [], f"README.md is not what the demo prints:\n{run.stdout}")

    def test_a_line_that_the_demo_does_not_print_is_found(self):
        printed = "object_5    object    sphere r 49.5 mm   1.6 mm     3596    48.4 %   3598"
        for shown in ("object_5  object  sphere r 49.4 mm  1.6 mm  3596", "object_5  48.4 %"):
            self.assertTrue(is_shortened(shown, printed), shown)
        for shown in (
            "object_5  object  sphere r 49.1 mm",
            "object_5  object  cone r 49.5 mm",
            "object_4  object",
            "object_5  48.4 %  1.6 mm",
            "object_5  object  sphere r 49.5 mm  1.6 mm  3500",
        ):
            self.assertFalse(is_shortened(shown, printed), shown)


if __name__ == "__main__":
    unittest.main()
