"""Writes the type hints of the verbs' functions: hints.py FOLDER, where FOLDER has the package as it is built.

The functions take the options of a verb from the table by which the command parses (`**options` in _verbs.py); a type checker sees them in _verbs.pyi.
"""

import ast
import sys
from pathlib import Path

folder = Path(sys.argv[1])
sys.path.insert(0, str(folder))
from imulab import _imulab  # noqa: E402

KEYWORDS = _imulab.keywords()


def verb_of(function: ast.FunctionDef) -> str:
    """The verb whose options the function takes; empty: none."""
    for decorator in function.decorator_list:
        if isinstance(decorator, ast.Call) and isinstance(decorator.func, ast.Name) and decorator.func.id == "_options":
            return str(ast.literal_eval(decorator.args[0]))
    return ""


def hint(function: ast.FunctionDef) -> ast.FunctionDef:
    """The function with every option, without its body."""
    own = function.args
    named = {a.arg for a in [*own.args, *own.kwonlyargs]}
    for name, kind, default, _ in KEYWORDS.get(verb_of(function), []):
        if name not in named:
            own.kwonlyargs.append(ast.arg(name, ast.parse(kind, mode="eval").body))
            own.kw_defaults.append(ast.Constant(default) if not isinstance(default, list) else ast.List([], ast.Load()))
    if verb_of(function):
        own.kwarg = None
    function.decorator_list = []
    function.body = [ast.Expr(ast.Constant(...))]
    return function


def is_shown(node: ast.stmt) -> bool:
    """Neither private nor the module's docstring."""
    name = node.name if isinstance(node, (ast.FunctionDef, ast.ClassDef)) else ""
    if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
        name = node.targets[0].id
    return not name.startswith("_") and not isinstance(node, ast.Expr)


tree = ast.parse((folder / "imulab" / "_verbs.py").read_text())
tree.body = [hint(node) if isinstance(node, ast.FunctionDef) else node for node in tree.body if is_shown(node)]
(folder / "imulab" / "_verbs.pyi").write_text(ast.unparse(ast.fix_missing_locations(tree)) + "\n")
