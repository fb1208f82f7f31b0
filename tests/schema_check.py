"""Checks with an independent reader that every scenario fits scenarios/schema.json, and that wrong scenarios do not."""

import copy
import json
import pathlib
import sys
import tomllib

from jsonschema import Draft7Validator

folder = pathlib.Path(__file__).parent.parent / "scenarios"
schema = json.loads((folder / "schema.json").read_text())
Draft7Validator.check_schema(schema)
validator = Draft7Validator(schema)
wrong = []

for file in sorted(folder.glob("*.toml")):
    scenario = tomllib.loads(file.read_text())
    # The defaults show optional keys in a separate table.
    scenario.pop("example", None)
    for error in validator.iter_errors(scenario):
        wrong.append(f"{file.name}: {'.'.join(map(str, error.path))}: {error.message}")

whole = tomllib.loads((folder / "one_of_everything.toml").read_text())
slips = {
    "an unknown key": lambda s: s["task"].update(spede_m_s=1.0),
    "grams": lambda s: s["payload"].update(mass_kg=300.0),
    "a word that is none": lambda s: s["task"].update(kind="hoover"),
    "text for a number": lambda s: s["wind"].update(gust_m_s="3"),
    "an unknown key of a list": lambda s: s["faults"][0].update(at=1.0),
    "a push of ten million newtons": lambda s: s["disturbances"][1].update(force_n=[1e7, 0.0, 0.0]),
    "a payload of 300 kg in flight": lambda s: s["disturbances"][2].update(kg=300.0),
    "an unknown event": lambda s: s["expect"].update(events=[{"kind": "grap"}]),
}
for name, slip in slips.items():
    scenario = copy.deepcopy(whole)
    slip(scenario)
    if validator.is_valid(scenario):
        wrong.append(f"{name} passes")

print("\n".join(wrong) or f"{len(list(folder.glob('*.toml')))} scenarios fit, {len(slips)} slips do not")
sys.exit(1 if wrong else 0)
