"""Vectors for compiled loops: many doubles at once, multiplied, subtracted and compared in registers.

A compiler turns a plain loop into vectors only where it can prove that no store meets a later load; with ten
rows in one loop it gives up, and each row becomes a pass of its own. These operations say it outright. They are
plain LLVM vectors, which the compiler cuts into what the processor has, and each place is rounded as a lone
double is. Nothing here checks bounds.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir  # type: ignore[import-untyped]
from numba import types
from numba.extending import intrinsic, models, register_model

TILE = 64  # doubles at once: eight of the widest registers, so that no addition waits for the one before
FOLD = 8  # doubles in a cache line


class Lanes(types.Type):  # type: ignore[misc]
    """Type of a vector of `count` doubles."""

    def __init__(self, count: int) -> None:
        self.vector = ir.VectorType(ir.DoubleType(), count)
        super().__init__(name=f"Lanes({count})")


class _Model(models.PrimitiveModel):  # type: ignore[misc]
    def __init__(self, manager: Any, lanes: Lanes) -> None:
        super().__init__(manager, lanes, lanes.vector)


register_model(Lanes)(_Model)
tile, fold = Lanes(TILE), Lanes(FOLD)


@intrinsic
def load(typing: Any, array: Any, at: Any) -> Any:
    """A tile of the flat `array` from place `at` on."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = _pointer(context, builder, signature.args[0], *args)
        return builder.load(builder.bitcast(pointer, tile.vector.as_pointer()), align=8)

    return tile(array, types.intp), generate


@intrinsic
def store(typing: Any, array: Any, at: Any, values: Any) -> Any:
    """Write `values` into the flat `array` from place `at` on."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        pointer = _pointer(context, builder, signature.args[0], *args[:2])
        builder.store(args[2], builder.bitcast(pointer, args[2].type.as_pointer()), align=8)
        return context.get_dummy_value()

    return types.void(array, types.intp, values), generate


@intrinsic
def prefetch(typing: Any, array: Any, at: Any) -> Any:
    """Let the memory begin to fetch the tile at place `at` of the flat `array`, which may lie beyond its end."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        byte, number = ir.IntType(8).as_pointer(), ir.IntType(32)
        function = _declared(builder, "llvm.prefetch.p0", ir.VoidType(), [byte, number, number, number])
        for line in range(0, TILE, FOLD):
            place = builder.add(args[1], ir.Constant(args[1].type, line))
            pointer = builder.bitcast(_pointer(context, builder, signature.args[0], args[0], place), byte)
            builder.call(function, [pointer, number(0), number(3), number(1)])
        return context.get_dummy_value()

    return types.void(array, types.intp), generate


@intrinsic
def spread(typing: Any, value: Any) -> Any:
    """`value` in each place of a tile."""
    return _spread(tile)


@intrinsic
def spread_fold(typing: Any, value: Any) -> Any:
    """`value` in each place of a cache line."""
    return _spread(fold)


@intrinsic
def product(typing: Any, a: Any, b: Any) -> Any:
    """a b, place by place."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fmul(*args)

    return a(a, b), generate


@intrinsic
def less_product(typing: Any, a: Any, b: Any, c: Any) -> Any:
    """a - b c, place by place, the product rounded before it is taken off."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.fsub(args[0], builder.fmul(args[1], args[2]))

    return a(a, b, c), generate


@intrinsic
def peaks(typing: Any, values: Any) -> Any:
    """Largest size in a tile at each place of its cache lines: place l has that of l, l + 8, ...; -1 if all are NaN."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        sizes = builder.call(_declared(builder, f"llvm.fabs.v{TILE}f64", tile.vector, [tile.vector]), args)
        largest = ir.Constant(fold.vector, [-1.0] * FOLD)
        for line in range(0, TILE, FOLD):
            places = ir.Constant(ir.VectorType(ir.IntType(32), FOLD), list(range(line, line + FOLD)))
            part = builder.shuffle_vector(sizes, ir.Constant(tile.vector, ir.Undefined), places)
            largest = builder.select(builder.fcmp_ordered(">", part, largest), part, largest)
        return largest

    return fold(values), generate


@intrinsic
def where_larger(typing: Any, a: Any, b: Any, x: Any, y: Any) -> Any:
    """x where a > b and y elsewhere, place by place."""

    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.fcmp_ordered(">", *args[:2]), *args[2:])

    return x(a, b, x, y), generate


def _pointer(context: Any, builder: Any, array_type: Any, array: Any, at: Any) -> Any:
    return builder.gep(context.make_array(array_type)(context, builder, array).data, [at])


def _declared(builder: Any, name: str, result: Any, arguments: list[Any]) -> Any:
    """LLVM's own function `name`."""
    known = builder.module.globals.get(name)
    return known or ir.Function(builder.module, ir.FunctionType(result, arguments), name)


def _spread(lanes: Lanes) -> Any:
    def generate(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        undefined = ir.Constant(lanes.vector, ir.Undefined)
        first = builder.insert_element(undefined, args[0], ir.Constant(ir.IntType(32), 0))
        places = ir.Constant(ir.VectorType(ir.IntType(32), lanes.vector.count), [0] * lanes.vector.count)
        return builder.shuffle_vector(first, undefined, places)

    return lanes(types.float64), generate
