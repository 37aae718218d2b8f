"""Formulas of numbers: names, + - * / ^ and functions of one argument."""
import ast
import operator

OPERATIONS = {ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul, ast.Div: operator.truediv,
              ast.Pow: operator.pow, ast.UAdd: operator.pos, ast.USub: operator.neg}


def value_of(node, names):
    if isinstance(node, ast.Constant) and type(node.value) in (int, float):
        return float(node.value)
    if isinstance(node, ast.Name) and node.id in names:
        return names[node.id]
    if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATIONS:
        return OPERATIONS[type(node.op)](value_of(node.operand, names))
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATIONS:
        return OPERATIONS[type(node.op)](value_of(node.left, names), value_of(node.right, names))
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1 and not node.keywords:
        function = names.get(node.func.id)
        if callable(function):
            return function(value_of(node.args[0], names))
    raise ValueError(ast.unparse(node))


def evaluated(formula, names):
    """The formula's value with these numbers, arrays and functions; ValueError where it has anything else."""
    try:
        value = value_of(ast.parse(formula.strip().replace("^", "**"), mode="eval").body, names)
        if callable(value) or isinstance(value, complex):
            raise ValueError(f"{value} is no real number")
        return value
    except (ArithmeticError, MemoryError, RecursionError, SyntaxError, TypeError, ValueError) as error:
        raise ValueError(f"the formula {formula!r} is not known here: {error}") from None
