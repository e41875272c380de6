#!/usr/bin/env python3
"""How much a diagnosis depends on the numbers that were chosen: `retune benchmark diagnosis` with all of them halved and doubled.

    python3 benches/diagnosis_constants.py [--seed 23] [--structures cantilever frame wing-on-springs]

Effort (diagnosis/src/effort.rs: how many hypotheses are fitted, from how many starts) and the thresholds of diagnosis/src/thresholds.rs
that say that they were perturbed are changed in a copy of the repository under target/constants, which is built and run once for each variant; a variant takes some five minutes.
"""

import argparse
import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]
COPY = ROOT / "target" / "constants"

EFFORT = "diagnosis/src/effort.rs"
THRESHOLDS = "diagnosis/src/thresholds.rs"
# Thresholds of other rooms on which a diagnosis rests: (file, name).
ELSEWHERE = [("src/fault/sensor_gain.rs", "GAIN_SD"), ("src/objective/close_modes.rs", "CLOSE")]


def efforts(factor):
    """All numbers of the effort, at least one each."""

    def scaled(found):
        return f"{found[1]}{max(1, round(int(found[2]) * factor))},"

    file = COPY / EFFORT
    file.write_text(re.sub(r"(?m)^(    \w+: )(\d+),$", scaled, file.read_text()))


def thresholds(factor):
    """Every threshold that says that it was perturbed; of a cosine and of a factor near one, the distance from one."""

    def scaled(value):
        return 1 - (1 - value) * factor if 0.7 < value < 1 else 1 + (value - 1) * factor if 1 < value < 2 else value * factor

    texts = {name: (COPY / name).read_text() for name in {THRESHOLDS, *(name for name, _ in ELSEWHERE)}}
    constants = [(THRESHOLDS, n) for n in re.findall(r"Perturbed\.\npub\(crate\) const (\w+)", texts[THRESHOLDS])]
    for name, constant in constants + ELSEWHERE:
        pattern = rf"(?m)^((?:pub(?:\([a-z]+\))? )?const {constant}: [a-z0-9]+ = )([^;]+);"
        texts[name], count = re.subn(pattern, lambda m: f"{m[1]}{scaled(float(m[2]))!r};", texts[name])
        if count != 1:
            raise SystemExit(f"{name}: {count} constants named {constant}")
    for name, text in texts.items():
        (COPY / name).write_text(text)


VARIANTS = {
    "as they are": lambda: None,
    "effort halved": lambda: efforts(0.5),
    "effort doubled": lambda: efforts(2),
    "thresholds halved": lambda: thresholds(0.5),
    "thresholds doubled": lambda: thresholds(2),
}
QUESTIONS = [
    ("false alarms", "false_alarms"),
    ("kind and place first", "right_first"),
    ("that, or the same trace", "alike_first"),
    ("in the tie set", "in_tie_set"),
    ("wrong and alone", "wrong_and_alone"),
    ("error gone", "error_removed"),
    ("faults", "faults_right"),
    ("outside: adequate", "outside_adequate"),
    ("outside: unexplained", "outside_unexplained"),
]


def sources():
    """The files that git knows or would take, as they stand now."""
    command = ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"]
    names = subprocess.run(command, cwd=ROOT, capture_output=True, check=True).stdout
    return {name: (ROOT / name).read_bytes() for name in filter(None, names.decode().split("\0"))}


def write_copy(files):
    """Writes what differs; the build of an earlier run is kept."""
    for name, content in files.items():
        target = COPY / name
        if target.exists() and target.read_bytes() == content:
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        target.write_bytes(content)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", default="23")
    parser.add_argument("--structures", nargs="+", default=["cantilever", "frame", "wing-on-springs"])
    options = parser.parse_args()
    scores = {}
    files = sources()
    for variant, change in VARIANTS.items():
        write_copy(files)
        change()
        subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "retune-cli"], cwd=COPY, check=True)
        total = {key: [0, 0] for _, key in QUESTIONS}
        for structure in options.structures:
            command = ["target/release/retune", "benchmark", "diagnosis", "--structure", structure, "--seed", options.seed]
            command += ["--null", "17", "--effects", "1", "--faults", "1", "--outside", "1", "--json"]
            found = subprocess.run(command, cwd=COPY, capture_output=True, check=True).stdout
            score = json.loads(found)["score"]
            for key, sums in total.items():
                sums[0] += score[key]["count"]
                sums[1] += score[key]["of"]
        scores[variant] = total
        print(variant, {key: f"{a} of {b}" for key, (a, b) in total.items()}, flush=True)
    print("\n| question | " + " | ".join(VARIANTS) + " |\n|" + " --- |" * (len(VARIANTS) + 1))
    for words, key in QUESTIONS:
        cells = [f"{scores[v][key][0]} of {scores[v][key][1]}" for v in VARIANTS]
        print(f"| {words} | " + " | ".join(cells) + " |")


main()
