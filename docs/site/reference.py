"""Writes the pages of the reference from their one source each: reference.py GELFMU FOLDER

The keys of a scene and the figures of a run come from `gelfmu schema`, the variables from
modelDescription/variables.toml, the commands from their own help, the projectiles from `gelfmu projectiles`, and the
scenes from `gelfmu scenes`.
"""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[2]
KINDS = {"integer": "whole number", "boolean": "`true` or `false`", "string": "text"}
PLURAL = {"number": "numbers", "table": "tables", "whole number": "whole numbers"}


def main(gelfmu, folder):
    """Write all pages."""

    def printed(*words):
        command = [gelfmu, "--color", "never", *words]
        # Help is as wide as the terminal: into a pipe it has 80 columns.
        options = {"stdin": subprocess.DEVNULL, "env": {**os.environ, "GELFMU_UNITS": "si"}, "text": True, "encoding": "utf-8"}
        return subprocess.run(command, check=True, capture_output=True, **options).stdout

    folder.mkdir(parents=True, exist_ok=True)
    variables = tomllib.loads((ROOT / "modelDescription" / "variables.toml").read_text(encoding="utf-8"))
    pages = {
        "scene": scene_keys(json.loads(printed("schema"))),
        "figures": figures_of_run(json.loads(printed("schema", "summary"))),
        "variables": fmu_variables(variables),
        "commands": command_help(printed),
        "projectiles": projectile_library(printed),
        "scenes": built_in_scenes(printed),
    }
    for name, lines in pages.items():
        (folder / f"{name}.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def table(head, rows):
    """Lines of a Markdown table; empty if it has no rows."""
    if not rows:
        return []
    lines = [head, ["---"] * len(head), *rows]
    return ["| " + " | ".join(cell(text) for text in line) + " |" for line in lines] + [""]


def cell(text):
    """Text of one cell: one line, without what Markdown would read as something else."""
    text = " ".join(str(text).split())
    return re.sub(r"(?<!\\)\|", r"\\|", text)


# Keys of a scene


def scene_keys(schema):
    """One table of keys for each table of the scene."""
    lines = []
    for name, entry in schema["properties"].items():
        shape, described = resolve(schema, entry)
        repeated = shape.get("type") == "array"
        head = f"[[{name}]]" if repeated else f"[{name}]"
        lines += [f"## `{head}`", "", entry.get("description", described), ""]
        body = resolve(schema, shape["items"])[0] if repeated else shape
        rows = [] if name == "fragment" else list(keys(schema, body, ""))
        lines += table(["key", "value", "default", "meaning"], rows)
    return lines


# Figures of a run

SAMPLED = {
    **{name: name for name in ("", "start", "end")},
    **{name: f"each {name}" for name in ("tick", "frame")},
    "update": "each update of an element",
    "step": "each communication step",
}


def figures_of_run(schema):
    """One table of the figures; `[]` stands for one entry of a list."""
    return table(["key", "unit", "sampled", "meaning"], list(figures(schema, schema, "")))


def figures(schema, shape, prefix):
    """Rows for the figures of an object, and for those of the objects in it."""
    for name, entry in shape.get("properties", {}).items():
        inner, described = resolve(schema, entry)
        listed = inner.get("type") if isinstance(inner.get("type"), list) else [inner.get("type")]
        items = resolve(schema, inner["items"])[0] if "array" in listed and "items" in inner else {}
        unit, sampled = entry.get("x-unit", ""), entry.get("x-sampled", "")
        yield [f"`{prefix}{name}`", {"1": "–"}.get(unit, unit), SAMPLED[sampled], described]
        yield from figures(schema, inner, f"{prefix}{name}.")
        yield from figures(schema, items, f"{prefix}{name}[].")


def resolve(schema, entry):
    """The definition that an entry of the schema stands for, without `null`, and its description."""
    described = entry.get("description", "")
    while True:
        if "$ref" in entry:
            entry = schema["$defs"][entry["$ref"].rsplit("/", 1)[1]]
        elif "anyOf" in entry and len(kept := [one for one in entry["anyOf"] if one.get("type") != "null"]) == 1:
            entry = kept[0]
        else:
            return entry, described or entry.get("description", "")


def keys(schema, shape, prefix):
    """Rows for the keys of a table, and for those of the tables in it."""
    required = shape.get("required", [])
    for name, entry in shape.get("properties", {}).items():
        inner, described = resolve(schema, entry)
        value, nested, notes = values(schema, inner, prefix + name)
        if name in required:
            default = "required"
        elif entry.get("default") is None:
            default = "none"
        else:
            default = f"`{toml(entry['default'])}`"
        if "properties" in inner and default != "required":
            default = ""
        yield [f"`{prefix}{name}`", value, default, " ".join([described, *notes])]
        yield from nested


def values(schema, shape, path):
    """What a key may be, in words, the rows of the keys below it, and what its words mean."""
    shape, _ = resolve(schema, shape)
    if "properties" in shape:
        return "table", list(keys(schema, shape, path + ".")), []
    if shape.get("type") == "array":
        word, rows, notes = values(schema, shape["items"], path + "[]")
        return f"list of {PLURAL.get(word, word)}", rows, notes
    variants = shape.get("oneOf") or shape.get("anyOf")
    if variants:
        return alternatives(schema, variants, path)
    if "enum" in shape or "const" in shape:
        return " or ".join(f'`"{value}"`' for value in shape.get("enum", [shape.get("const")])), [], []
    kinds = shape.get("type", [])
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if "number" in kinds:
        return "number", [], []
    return " or ".join(KINDS.get(kind, kind) for kind in kinds if kind != "null") or "any", [], []


def alternatives(schema, variants, path):
    """The same of a key with several forms: words, or tables of one key each."""
    words, rows, notes = [], [], []
    for variant in variants:
        inner, described = resolve(schema, variant)
        word, below, _ = values(schema, inner, path)
        if "properties" in inner:
            word = "`{ " + ", ".join(inner["properties"]) + " }`"
            if below:
                key, value, _, own = below[0]
                below[0] = [key, value, "", described if value == "table" else f"{described} {own}"]
        elif "const" in inner and described:
            notes.append(f"{word}: {described}")
        words.append(word)
        rows += below
    return " or ".join(dict.fromkeys(words)), rows, notes


def toml(value):
    """A default as TOML."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list):
        return "[" + ", ".join(toml(one) for one in value) + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {toml(one)}" for key, one in value.items()) + " }"
    return str(value)


# Variables of the FMU


def fmu_variables(source):
    """Tables of the variables by causality, and of the enumerations."""
    lines = []
    titles = [("parameter", "Parameters"), ("input", "Inputs"), ("output", "Outputs and locals")]
    rest = [one for one in source["variable"] if one["causality"] not in ("parameter", "input")]
    for causality, title in titles:
        chosen = rest if causality == "output" else [v for v in source["variable"] if v["causality"] == causality]
        lines += [f"## {title}", ""]
        if causality == "output":
            head = ["variable", "type", "unit", "output in", "meaning"]
            rows = [[*name_and_type(one), ", ".join(one.get("outputs", [])), meaning(one)] for one in chosen]
        else:
            head = ["variable", "type", "unit", "start", "meaning"]
            rows = [[*name_and_type(one), start(one), meaning(one)] for one in chosen]
        lines += table(head, rows)
    lines += ["## Enumerations", ""]
    for one in source["enumeration"]:
        lines += [f"### {one['name']}", ""]
        rows = [[item["value"], f"`{item['name']}`", item["description"]] for item in one["items"]]
        lines += table(["value", "name", "meaning"], rows)
    return lines


def name_and_type(variable):
    """The name with the size of an array, the type and the unit."""
    size = variable.get("size") or variable.get("components") or variable.get("length")
    count = f"[{size}]" if isinstance(size, int) and size > 1 else ""
    kind = variable.get("declared_type", variable["type"])
    return f"`{variable['name']}{count}`", kind, variable.get("unit", "")


def start(variable):
    """Where the start of a variable comes from."""
    given = f"`{toml(variable['start'])}`" if "start" in variable and variable["start"] != "" else ""
    scene = ", ".join(f"`{key}`" for key in variable.get("keys", []))
    return f"{scene} of the scene" if scene else given


def meaning(variable):
    """Description and details."""
    text = variable.get("description", "")
    details = variable.get("details", "")
    return f"{text}. {details}" if details else text


# Commands


def command_help(printed):
    """The help of the program and of each of its commands."""
    listed = printed("--help")
    names = re.findall(r"^  ([a-z-]+) {2,}", listed.split("Commands:")[1].split("Global options:")[0], re.MULTILINE)
    lines = ["## gelfmu", "", "```text", listed.rstrip(), "```", ""]
    for name in names:
        if name != "help":
            lines += [f"## {name}", "", "```text", printed(name, "--help").rstrip(), "```", ""]
    return lines


# Projectiles and scenes


def projectile_library(printed):
    """One table for each kind of projectile."""
    lines = []
    library = json.loads(printed("projectiles", "--json"))
    for kind in dict.fromkeys(one["kind"] for one in library):
        lines += [f"## {kind.capitalize()}", ""]
        rows = [[f"`{one['name']}`", one["title"], f"{1e3 * one['mass']:.4g}", f"{one['speed']:.4g}"]
                for one in library if one["kind"] == kind]
        lines += table(["name", "projectile", "mass, g", "usual speed, m/s"], rows)
    return lines


def built_in_scenes(printed):
    """The text of each built-in scene."""
    lines = []
    for one in json.loads(printed("scenes", "--json")):
        name = one["name"] if isinstance(one, dict) else one
        lines += [f"## {name}", "", "```toml", printed("scenes", name).rstrip(), "```", ""]
    return lines


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
