#!/usr/bin/env python3
"""How much a diagnosis depends on the numbers that were chosen: `retune benchmark diagnosis` with all of them halved and doubled.

    python3 benches/diagnosis_constants.py [--seed 23] [--structures cantilever frame wing-on-springs]

Effort (how many hypotheses are refitted, from how many starts) and thresholds (what is visible, faint, alike, close) are changed in a
copy of the repository under target/constants, which is built and run once for each variant; a variant takes some five minutes.
"""

import argparse
import json
import pathlib
import re
import subprocess

ROOT = pathlib.Path(__file__).resolve().parents[1]
COPY = ROOT / "target" / "constants"

# (file, name): values halved and doubled.
EFFORT = {
    ("src/diagnosis/search/singles.rs", "BEST"): ("6", "24"),
    ("src/diagnosis/search/starts.rs", "STARTS"): ("2", "8"),
    ("src/diagnosis/search/singles.rs", "SHORT_FITS"): ("100", "400"),
    ("src/diagnosis/search/singles.rs", "FAULTS_OF_A_KIND"): ("2", "8"),
    ("src/diagnosis/search/singles.rs", "FEW_OF_A_KIND"): ("8", "32"),
    ("src/diagnosis/search/short_fit.rs", "FIRST_STEPS"): ("1", "4"),
    ("src/diagnosis/search/short_fit.rs", "FEW_STARTS"): ("1", "4"),
    ("src/diagnosis/search/short_fit.rs", "FURTHER_STEPS"): ("2", "8"),
    ("src/diagnosis/search/singles.rs", "BEST_FAULTS"): ("2", "8"),
    ("src/diagnosis/search/singles.rs", "ROUNDS"): ("2", "6"),
    ("src/diagnosis/search/run.rs", "NEAR"): ("30", "120"),
    ("src/diagnosis/search/singles.rs", "POLISHED"): ("2", "6"),
    ("src/diagnosis/search/singles.rs", "POLISHED_KINDS"): ("3", "12"),
    ("src/diagnosis/screen/stage.rs", "BOX_STARTS"): ("3", "10"),
    ("src/diagnosis/screen/robust.rs", "ROUNDS"): ("2", "8"),
    ("src/diagnosis/screen/robust.rs", "SUSPECTS"): ("2", "8"),
    ("src/diagnosis/screen/robust.rs", "FEW_STEPS"): ("4", "16"),
    ("src/diagnosis/search/spread.rs", "STARTS"): ("2", "6"),
    ("src/diagnosis/verdict/decide.rs", "CHECKED"): ("2", "6"),
    ("src/diagnosis/search/run.rs", "OF_EVERY_KIND"): ("1", "4"),
    ("src/diagnosis/problem/fit.rs", "FIRST_STEPS"): ("2", "8"),
    ("src/diagnosis/search/basin.rs", "WAYS"): ("12", "48"),
    ("src/diagnosis/search/wider.rs", "WITH_ALL_AXES"): ("6", "24"),
}
# Of a factor and of a cosine, the distance from one.
THRESHOLDS = {
    ("src/diagnosis/screen/effects.rs", "VISIBLE"): ("0.05", "0.2"),
    ("src/diagnosis/screen/effects.rs", "ALIKE"): ("0.99", "0.96"),
    ("src/diagnosis/screen/robust.rs", "OUT"): ("1.25", "2.0"),
    ("src/fault/sensor_gain.rs", "GAIN_SD"): ("0.15", "0.6"),
    ("src/diagnosis/search/singles.rs", "FAINT"): ("2.0", "8.0"),
    ("src/diagnosis/search/basin.rs", "SHARE"): ("0.25", "0.75"),
    ("src/objective/close_modes.rs", "CLOSE"): ("0.0025", "0.01"),
}
VARIANTS = {
    "as they are": ({}, 0),
    "effort halved": (EFFORT, 0),
    "effort doubled": (EFFORT, 1),
    "thresholds halved": (THRESHOLDS, 0),
    "thresholds doubled": (THRESHOLDS, 1),
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


def change(constants, which):
    for (name, constant), values in constants.items():
        file = COPY / name
        text, count = re.subn(
            rf"(?m)^((?:pub(?:\([a-z]+\))? )?const {constant}: [a-z0-9]+ = )[^;]+;",
            rf"\g<1>{values[which]};",
            file.read_text(),
        )
        if count != 1:
            raise SystemExit(f"{name}: {count} constants named {constant}")
        file.write_text(text)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", default="23")
    parser.add_argument("--structures", nargs="+", default=["cantilever", "frame", "wing-on-springs"])
    options = parser.parse_args()
    scores = {}
    files = sources()
    for variant, (constants, which) in VARIANTS.items():
        write_copy(files)
        change(constants, which)
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
