"""numba's compiler with a pass that decides `argument.field is None` by the type of the field.

numba leaves out branches on an argument that is None, but not on a field of one: what they call was compiled, and then
removed. Passes are how numba is meant to be extended (its manual, "Customizing the Compiler").
"""

from __future__ import annotations

import operator
from typing import Any

from numba.core import ir, types
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import FunctionPass, register_pass
from numba.core.ir_utils import get_definition, guard
from numba.core.untyped_passes import IRProcessing


@register_pass(mutates_CFG=False, analysis_only=False)
class _DecideAbsence(FunctionPass):
    _name = "decide_absence"

    def __init__(self) -> None:
        FunctionPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        function, n_decided = state.func_ir, 0
        for block in function.blocks.values():
            for statement in block.find_insts(ir.Assign):
                value = statement.value
                is_absent = _absence(function, state.args, value)
                if is_absent is not None:
                    definitions = function._definitions[statement.target.name]
                    statement.value = ir.Const(is_absent, statement.loc)
                    definitions[definitions.index(value)] = statement.value
                    n_decided += 1
        return n_decided > 0


def _absence(function: Any, arguments: Any, value: Any) -> bool | None:
    """Return the result of a comparison with None that the type of a field decides; None of any other expression."""
    if not (isinstance(value, ir.Expr) and value.op == "binop"):
        return None
    other = guard(get_definition, function, value.rhs)
    is_none = isinstance(other, (ir.Const, ir.Global)) and other.value is None
    if value.fn not in (operator.is_, operator.is_not) or not is_none:
        return None
    kind = _type_of(function, arguments, value.lhs)
    if kind is None or isinstance(kind, (types.Optional, types.Omitted)):
        return None
    return isinstance(kind, types.NoneType) == (value.fn is operator.is_)


def _type_of(function: Any, arguments: Any, variable: Any) -> Any:
    """Return the type of an argument, or of a field, to any depth; None of anything else."""
    definition = guard(get_definition, function, variable)
    if isinstance(definition, ir.Arg):
        return arguments[definition.index]
    if not (isinstance(definition, ir.Expr) and definition.op == "getattr"):
        return None
    owner = _type_of(function, arguments, definition.value)
    fields = getattr(owner, "fields", ())
    return owner[fields.index(definition.attr)] if definition.attr in fields else None


class DecidingCompiler(Compiler):
    """numba's compiler with this pass after it has read the function."""

    def define_pipelines(self) -> Any:
        """Return the passes in order."""
        (passes,) = super().define_pipelines()
        passes.add_pass_after(_DecideAbsence, IRProcessing)
        passes.finalize()
        return [passes]
