"""The page of what the Python package offers, made of its docstrings."""

from __future__ import annotations

import ast
import re
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2] / "python" / "photosite"
WIDTH = 100
SECTIONS = ("Args:", "Attributes:", "Returns:", "Raises:", "Yields:")
BEGINNING = """\
# Python

What the package's docstrings say. [Python in a notebook](../tutorials/python-in-a-notebook.md) says how to install it and what a
program looks like.
"""


def parse(module: str) -> ast.Module:
    return ast.parse((PACKAGE / f"{module.replace('.', '/')}.py").read_text())


def exported() -> "list[tuple[str, str]]":
    """The public names of Python code with their modules, in alphabetical order."""
    names = []
    for node in parse("__init__").body:
        if isinstance(node, ast.ImportFrom) and node.module != "_photosite":
            names += [(alias.name, node.module) for alias in node.names]
    return sorted(names, key=lambda pair: pair[0].lower())


def prose(docstring: str) -> str:
    """A docstring in Google's style as Markdown."""
    lines, section = [], None
    for line in docstring.splitlines():
        entry = re.match(r"    ([\w.*, ]+?)(?: \((.*)\))?: (.*)", line)
        if line in SECTIONS:
            section = line
            lines += [f"**{line}**", ""]
        elif section and line and not line.startswith(" "):
            section = None
            lines.append(line)
        elif section and entry and section not in ("Returns:", "Yields:"):
            lines.append(f"- `{entry[1]}`: {entry[3]}")
        elif section:
            lines.append(line[4:] if section in ("Returns:", "Yields:") else re.sub("^ {8}", "  ", line))
        else:
            lines.append(line)
    text = "\n".join(lines)
    text = re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text)
    return re.sub(r"``([^`]+)``", r"`\1`", text)


def annotation(node: "ast.expr | None") -> str:
    if node is None:
        return ""
    text = node.value if isinstance(node, ast.Constant) and isinstance(node.value, str) else ast.unparse(node)
    return text.replace("npt.", "").replace("_photosite.", "")


def signature(function: ast.FunctionDef, name: str, is_method: bool) -> str:
    """A function's head as it is called."""
    given = function.args
    plain = [*given.posonlyargs, *given.args]
    defaults = [None] * (len(plain) - len(given.defaults)) + list(given.defaults)
    parts = []
    for i, (argument, default) in enumerate(zip(plain, defaults)):
        if not (is_method and i == 0):
            parts.append(parameter(argument, default))
        if given.posonlyargs and i == len(given.posonlyargs) - 1 and parts:
            parts.append("/")
    if given.vararg:
        parts.append(f"*{parameter(given.vararg, None)}")
    elif given.kwonlyargs:
        parts.append("*")
    parts += [parameter(argument, default) for argument, default in zip(given.kwonlyargs, given.kw_defaults)]
    if given.kwarg:
        parts.append(f"**{parameter(given.kwarg, None)}")
    result = f" -> {annotation(function.returns)}" if function.name != "__init__" else ""
    one_line = f"{name}({', '.join(parts)}){result}"
    return one_line if len(one_line) <= WIDTH else f"{name}(\n    " + ",\n    ".join(parts) + f",\n){result}"


def parameter(argument: ast.arg, default: "ast.expr | None") -> str:
    kind = annotation(argument.annotation)
    text = f"{argument.arg}: {kind}" if kind else argument.arg
    if default is None:
        return text
    equals = " = " if kind else "="
    return f"{text}{equals}{ast.unparse(default)}"


def decorators(function: ast.FunctionDef) -> "set[str]":
    return {ast.unparse(decorator).split(".")[-1] for decorator in function.decorator_list}


def code(text: str) -> "list[str]":
    return ["```python", text, "```", ""]


def of_function(function: ast.FunctionDef, owner: str = "") -> "list[str]":
    name = f"{owner}.{function.name}" if owner else function.name
    lines = [f"### `{name}`" if owner else f"## `{name}`", ""]
    if decorators(function) & {"property", "cached_property"}:
        lines += code(f"{name}: {annotation(function.returns)}")
    else:
        lines += code(signature(function, name, bool(owner) and "staticmethod" not in decorators(function)))
    return [*lines, prose(ast.get_docstring(function) or ""), ""]


def of_class(node: ast.ClassDef) -> "list[str]":
    functions = [item for item in node.body if isinstance(item, ast.FunctionDef)]
    functions = [function for function in functions if "overload" not in decorators(function)]
    lines = [f"## `{node.name}`", ""]
    bases = [ast.unparse(base) for base in node.bases]
    made = [function for function in functions if function.name == "__init__" and ast.get_docstring(function)]
    for function in made:
        lines += code(signature(function, node.name, True))
    if bases and all(base.isidentifier() for base in bases) and bases != ["NamedTuple"]:
        lines += [f"Derived from {' and '.join(f'`{base}`' for base in bases)}.", ""]
    lines += [prose(ast.get_docstring(node) or ""), ""]
    lines += [prose(ast.get_docstring(function) or "") + "\n" for function in made]
    for function in functions:
        if not function.name.startswith("_"):
            lines += of_function(function, node.name)
    return lines


def page() -> str:
    lines = [BEGINNING]
    for name, module in exported():
        found = [node for node in parse(module).body if getattr(node, "name", None) == name]
        node = found[-1]  # behind its overloads
        lines += of_class(node) if isinstance(node, ast.ClassDef) else of_function(node)
    return re.sub(r"\n{3,}", "\n\n", "\n".join(lines)).rstrip() + "\n"

