"""Pages of the reference that are made of JSON Schemas: every key with its type, range, unit, default, an example and its meaning."""

from __future__ import annotations

import json
import re

from key_examples import Examples

UNITS = {
    "m": "m", "mm": "mm", "um": "µm", "nm": "nm", "px": "px", "deg": "°", "s": "s", "ms": "ms", "us": "µs", "ns": "ns",
    "hz": "Hz", "mhz": "MHz", "e": "e⁻", "dn": "DN", "v": "V", "db": "dB", "ev": "EV", "cd": "cd", "lux": "lx", "nit": "cd/m²", "lm": "lm",
    "k": "K", "c": "°C", "percent": "%", "dpt": "dpt", "w": "W", "mb": "MB", "gib": "GiB", "um2": "µm²", "electrons": "e⁻", "paths": "paths",
    "unit": "unit", "kib": "KiB", "uv": "µV", "ev2": "EV²", "e2": "e⁻²", "second": "s", "metre": "m", "m2": "m²", "sr": "sr",
}


def unit(key: str) -> str:
    """The unit that a key's name ends with: `dark_current_e_per_s` is in e⁻/s."""
    above, *below = key.split("_per_")
    words = [UNITS.get(part.split("_")[-1], "") for part in [above, *below]]
    if "_" not in key or not all(words):
        return ""
    return words[0] + "".join(f"/{word}" for word in words[1:])


# What a description says of a key that is left out, to the end of the sentence: a point within a number does not end it.
LEFT_OUT = re.compile(r" ?Left out((?:, [^:]*)?): (.+?)\.(?= [A-Z(]|$)")
# Longer texts stay where they are.
LONGEST_DEFAULT = 70


def one_line(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def value(default: object) -> str:
    """A value as TOML has it."""
    if default is None or isinstance(default, dict):
        return ""
    return f"`{json.dumps(default, ensure_ascii=False)}`"


def span(at: dict) -> str:
    """The range of a number in words. That whole numbers are not negative goes without saying."""
    low, above, high, below = (at.get(key) for key in ("minimum", "exclusiveMinimum", "maximum", "exclusiveMaximum"))
    if low == 0 and high is below is None and at.get("type") != "number":
        low = None
    begin = f"from {figure(low)}" if low is not None else f"above {figure(above)}" if above is not None else ""
    end = f"to {figure(high)}" if high is not None else f"below {figure(below)}" if below is not None else ""
    words = " ".join(word for word in (begin, end) if word)
    return f" {words}" if words else ""


def figure(number: float) -> str:
    """A bound as people write it: 1e18, 40000, 0.01, −273.15."""
    text = f"{abs(number):.12g}".replace("e+", "e").replace("e-0", "e-")
    return f"−{text}" if number < 0 else text


class Page:
    """One schema as Markdown: a section for each table, in the order in which keys lead to them."""

    def __init__(self, schema: dict, kind: str, examples: "Examples | None"):
        self.kind, self.examples = kind, examples
        self.definitions = schema.get("$defs", {})
        self.described: "set[str]" = set()
        self.waiting: "list[tuple[str, str]]" = []
        self.lines: "list[str]" = []

    def of(self, schema: dict) -> str:
        tables = {key: at for key, at in schema["properties"].items() if "$ref" in json.dumps(at)}
        plain = {key: at for key, at in schema["properties"].items() if key not in tables}
        if plain:
            self.lines += ["## Keys outside tables", ""]
            self.keys(plain, schema.get("required", []), "")
        for key, at in tables.items():
            is_list = at.get("type") == "array"
            brackets = f"[[{key}]]" if is_list else f"[{key}]"
            self.lines += [f"## `{brackets}` {{ #{key} }}", "", at.get("description", ""), ""]
            self.shape(at, key, at.get("description", ""))
            self.sections()
        return "\n".join(self.lines)

    def sections(self) -> None:
        """Sections of all tables that keys have led to."""
        while self.waiting:
            name, path = self.waiting.pop(0)
            definition = self.definitions[name]
            self.lines += [f"### `{path}` {{ #{name.lower()} }}", "", definition.get("description", ""), ""]
            self.shape(definition, path, definition.get("description", ""))

    def shape(self, at: dict, path: str, said: str) -> None:
        """What a value may be, under a heading that is there already. `said` is what stands under it."""
        if "$ref" in at:
            name = at["$ref"].rsplit("/", 1)[1]
            if name in self.described:
                self.lines += [f"As [above](#{name.lower()}).", ""]
                return
            self.described.add(name)
            self.lines += [f'<span id="{name.lower()}"></span>', ""]
            definition = self.definitions[name]
            if definition.get("description", said) != said:
                self.lines += [definition["description"], ""]
            self.shape(definition, path, said)
        elif at.get("type") == "array":
            self.shape(at["items"], path, said)
        elif "properties" in at:
            self.keys(at["properties"], at.get("required", []), path)
        elif isinstance(at.get("additionalProperties"), dict):
            self.shape(at["additionalProperties"], f"{path}.NAME", said)
        else:
            self.alternatives(at.get("oneOf") or at.get("anyOf") or [], path, said)

    def alternatives(self, alternatives: "list[dict]", path: str, said: str) -> None:
        names = [alternative for alternative in alternatives if "const" in alternative]
        if names:
            self.lines += ["| value | meaning |", "|---|---|"]
            self.lines += [f'| `"{name["const"]}"` | {one_line(name.get("description", ""))} |' for name in names] + [""]
        for alternative in alternatives:
            if alternative in names:
                continue
            kind = alternative.get("properties", {}).get("type", {}).get("const")
            if kind:
                self.lines += [f'#### `{path}` of type `"{kind}"`', "", alternative.get("description", ""), ""]
                others = {key: at for key, at in alternative["properties"].items() if key != "type"}
                self.keys(others, alternative.get("required", []), path)
            elif "properties" in alternative or "$ref" in alternative:
                self.lines += [f"*As a table.* {alternative.get('description', '')}", ""]
                self.shape(alternative, path, said)
            else:
                self.lines += [f"*As {self.type_of(alternative, path)}.* {alternative.get('description', '')}", ""]

    def keys(self, properties: dict, required: "list[str]", path: str) -> None:
        example = "" if self.examples is None else " example |"
        self.lines += [f"| key | type | unit | default |{example} meaning |", "|---|---|---|---|---|" + "---|" * bool(example)]
        for key, at in properties.items():
            text = one_line(at.get("description", ""))
            default = value(at.get("default"))
            whole = f"{path}.{key}" if path else key
            left_out = LEFT_OUT.search(text)
            if left_out and len(left_out[2]) > LONGEST_DEFAULT:
                default = "*as described*"
            elif left_out:
                # What a schema has as a value stands in its description as words, too.
                default = default or left_out[2]
                text = text.replace(left_out[0], "", 1).strip() if not left_out[1] else text
            elif key in required:
                default = "*needed*"
            elif self.kind == "capture" and whole.startswith("sensor."):
                default = "*that of the preset*"
            else:
                default = default or "none"
            what = self.type_of(at, whole)
            if self.examples is not None:
                found = one_line(self.examples.find(self.kind, whole, what) or self.header(at, whole))
                text = (f"`{found}` | " if found else " | ") + text
            self.lines.append(f"| `{key}` | {what} | {unit(key)} | {default} | {text} |")
        self.lines.append("")

    def header(self, at: "dict | bool", path: str) -> str:
        """How a table begins in a file, which is the shortest example of it; nothing for other values."""
        what = self.type_of(at, path)
        if "table" not in what:
            return ""
        return f"[[{path}]]" if what.startswith("list") else f"[{path}]"

    def type_of(self, at: "dict | bool", path: str) -> str:
        if isinstance(at, bool):
            return "any value"
        if "$ref" in at:
            name = at["$ref"].rsplit("/", 1)[1]
            return self.reference(name, path)
        if "const" in at:
            return f"`{json.dumps(at['const'])}`"
        if "enum" in at:
            return " or ".join(f"`{json.dumps(name)}`" for name in at["enum"])
        alternatives = at.get("oneOf") or at.get("anyOf")
        if alternatives:
            return " or ".join(dict.fromkeys(self.type_of(alternative, path) for alternative in alternatives))
        kinds = at.get("type", "any value")
        if isinstance(kinds, list):
            return " or ".join(self.plain(kind, at, path) for kind in kinds if kind != "null")
        return self.plain(kinds, at, path)

    def plain(self, kind: str, at: dict, path: str) -> str:
        if kind == "array":
            count = at.get("minItems") if at.get("minItems") == at.get("maxItems") else None
            items = self.type_of(at.get("items", {}), path)
            return f"list of {count} × {items}" if count else f"list of {items}"
        if kind == "object" and isinstance(at.get("additionalProperties"), dict):
            return f"table of {self.type_of(at['additionalProperties'], f'{path}.NAME')}"
        name = {"string": "text", "number": "number", "integer": "whole number", "boolean": "true or false", "object": "table"}.get(kind, kind)
        return name + span(at)

    def reference(self, name: str, path: str) -> str:
        """The type of a definition; one that has keys gets a section of its own."""
        definition = self.definitions[name]
        alternatives = definition.get("oneOf") or definition.get("anyOf") or []
        has_keys = "properties" in definition or any("properties" in a or "$ref" in a for a in alternatives)
        if alternatives and not has_keys and len(alternatives) <= 4:
            return " or ".join(self.type_of(alternative, path) for alternative in alternatives)
        if "properties" not in definition and not alternatives:
            return self.type_of(definition, path)
        if name not in self.described:
            self.described.add(name)
            self.waiting.append((name, path))
        return f"[{'table' if has_keys else 'name'}](#{name.lower()})" + self.short_form(alternatives)

    def short_form(self, alternatives: "list[dict]") -> str:
        kinds = [alternative["type"] for alternative in alternatives if "type" in alternative and "properties" not in alternative]
        words = {"string": "text", "number": "number", "boolean": "true or false", "array": "list"}
        names = dict.fromkeys(words[kind] for kind in kinds if kind in words)
        return "".join(f" or {name}" for name in names) if any("properties" in a or "$ref" in a for a in alternatives) else ""


def legend(kind: str) -> str:
    """How the column of defaults is read."""
    text = "The default is what holds where a key is left out: *needed* means that it must not be, and none that nothing holds, or what another key says in its place."
    return text + (" A key of the sensor that is left out is *that of the preset*." if kind == "capture" else "")


def page(title: str, beginning: str, kind: str, schema_text: str, examples: "Examples | None") -> str:
    """The page of a schema; without `examples` for files that only photosite writes."""
    schema = json.loads(schema_text)
    if examples is not None:
        beginning += f"\n\n{legend(kind)}"
    text = f"# {title}\n\n{beginning}\n\n{Page(schema, kind, examples).of(schema)}\n"
    # Of links into the documentation of the crates, the words stay.
    text = re.sub(r"\[([^\[\]]+)\]\(\w+::[\w:#]+\)", r"\1", text)
    return re.sub(r"\[(`[\w:]+`)\](?![(\[])", r"\1", text)
