"""The software bill of materials of the command `retune`: what is built into it, as CycloneDX 1.5.

    python3 .ci/sbom.py TARGET > retune.cdx.json

TARGET is a platform of Rust, `x86_64-unknown-linux-gnu`. Crates that only build scripts, macros and tests need are left out: they are in no
binary. Versions, licences and sources come from `cargo metadata --locked`, hashes from Cargo.lock. The same commit gives the same bytes.
"""

import json
import re
import subprocess
import sys
import tomllib
import uuid
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent


def licences(text):
    """An SPDX expression; older crates write `/` where SPDX has `OR`."""
    return [{"expression": re.sub(r"\s*/\s*", " OR ", text)}] if text else []


def main(target):
    command = ["cargo", "metadata", "--locked", "--format-version", "1", "--filter-platform", target]
    metadata = json.loads(subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout)
    packages = {p["id"]: p for p in metadata["packages"]}
    nodes = {n["id"]: n for n in metadata["resolve"]["nodes"]}
    lock = tomllib.loads((ROOT / "Cargo.lock").read_text())
    hashes = {(p["name"], p["version"]): p.get("checksum") for p in lock["package"]}
    is_macro = {id for id, p in packages.items() if any("proc-macro" in t["kind"] for t in p["targets"])}

    def linked(id):
        """What is linked into a package: no build scripts, no tests, no macros."""
        of_build = lambda dep: all(kind["kind"] is not None for kind in dep["dep_kinds"])
        return [dep["pkg"] for dep in nodes[id]["deps"] if not of_build(dep) and dep["pkg"] not in is_macro]

    root = next(id for id, p in packages.items() if p["name"] == "retune-cli")
    found, waiting = set(), [root]
    while waiting:
        id = waiting.pop()
        if id not in found:
            found.add(id)
            waiting.extend(linked(id))

    def reference(id):
        return f"pkg:cargo/{packages[id]['name']}@{packages[id]['version']}"

    def component(id):
        p = packages[id]
        out = {
            "type": "library",
            "bom-ref": reference(id),
            "name": p["name"],
            "version": p["version"],
            "licenses": licences(p["license"]),
            "purl": reference(id),
        }
        if checksum := hashes.get((p["name"], p["version"])):
            out["hashes"] = [{"alg": "SHA-256", "content": checksum}]
        if p["repository"]:
            out["externalReferences"] = [{"type": "vcs", "url": p["repository"]}]
        return out

    order = sorted(found, key=reference)
    head = component(root) | {"type": "application", "name": "retune"}
    bom = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.5",
        "version": 1,
        "metadata": {"component": head, "properties": [{"name": "target", "value": target}]},
        "components": [component(id) for id in order if id != root],
        "dependencies": [
            {"ref": reference(id), "dependsOn": sorted(reference(d) for d in linked(id))} for id in order
        ],
    }
    # A serial number that follows from the content, so that the same content has the same.
    serial = uuid.uuid5(uuid.NAMESPACE_URL, json.dumps(bom, sort_keys=True))
    print(json.dumps({"serialNumber": f"urn:uuid:{serial}"} | bom, indent=2))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
