"""Generates straight-line C from formulas that are evaluated symbolically. Constants are folded, and no expression is
computed twice.

A `Term` is a constant, or a constant factor times a variable of the C code. Factors are kept separate from variables
until they must be multiplied out. Signs therefore cost nothing, and a rotation by 90 degrees, whose quaternion is
1/sqrt(2) (1, 1, 0, 0), costs additions only. The simplifications are exact in real numbers. The emitted code fixes the
order of the operations and thereby of the roundings, so that all compilers produce the same result.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass


@dataclass(frozen=True)
class Term:
    """The product factor * variable. If variable is None, the term is the constant `factor`."""

    factor: float
    variable: str | None = None

    def __neg__(self) -> Term:
        return Term(-self.factor, self.variable)

    @property
    def is_zero(self) -> bool:
        return self.factor == 0.0


ZERO, ONE = Term(0.0), Term(1.0)
Vector = list[Term]


def literal(value: float) -> str:
    text = f"{value:.9g}"
    return f"{text}f" if any(mark in text for mark in ".e") else f"{text}.0f"


class Block:
    """A list of statements in the order of their creation. text() returns the statements on which given results
    depend."""

    def __init__(self, prefix: str) -> None:
        self._prefix = prefix
        self._statements: dict[str, tuple[str, tuple[str, ...]]] = {}  # variable: (expression, its variables)
        self._known: dict[str, str] = {}  # expression: variable

    def _emit(self, expression: str, *variables: str) -> str:
        if expression not in self._known:
            name = f"{self._prefix}{len(self._statements)}"
            self._known[expression] = name
            self._statements[name] = (expression, variables)
        return self._known[expression]

    def add(self, a: Term, b: Term) -> Term:
        if a.is_zero or b.is_zero:
            return b if a.is_zero else a
        if a.variable == b.variable:
            total = a.factor + b.factor
            cancels = abs(total) < 1e-12 * abs(a.factor)
            return ZERO if cancels else Term(total, a.variable)
        if a.variable is None:
            a, b = b, a
        if b.variable is None:
            a = self.whole(a)
            sign = a.factor * b.factor
            return Term(
                a.factor, self._emit(f"{a.variable} {'-' if sign < 0 else '+'} {literal(abs(b.factor))}", a.variable)
            )
        if abs(abs(a.factor) - abs(b.factor)) > 1e-12 * abs(a.factor):
            if abs(b.factor) == 1.0:
                a, b = b, a
            ratio = b.factor / a.factor
            b = Term(a.factor if ratio > 0 else -a.factor, self.whole(Term(abs(ratio), b.variable)).variable)
        if a.factor * b.factor < 0:
            return Term(a.factor, self._emit(f"{a.variable} - {b.variable}", a.variable, b.variable))
        return Term(a.factor, self._emit(f"{a.variable} + {b.variable}", a.variable, b.variable))

    def multiply(self, a: Term, b: Term) -> Term:
        factor = a.factor * b.factor
        if factor == 0.0 or a.variable is None or b.variable is None:
            return Term(factor, None if factor == 0.0 else a.variable or b.variable)
        return Term(factor, self._emit(f"{a.variable} * {b.variable}", a.variable, b.variable))

    def whole(self, a: Term) -> Term:
        """Returns an equal term whose factor is 1 or -1, unless it is a constant."""
        if a.variable is None or abs(a.factor) == 1.0:
            return a
        return Term(1.0 if a.factor > 0 else -1.0, self._emit(f"{literal(abs(a.factor))} * {a.variable}", a.variable))

    def apply(self, template: str, *arguments: Term) -> Term:
        """Returns a term for a C expression, which is the template with the arguments in place of {}."""
        text = template.format(*(value(self.whole(argument)) for argument in arguments))
        return Term(
            1.0, self._emit(text, *(argument.variable for argument in map(self.whole, arguments) if argument.variable))
        )

    def sum(self, terms: Iterable[Term]) -> Term:
        total = ZERO
        for term in terms:
            total = self.add(total, term)
        return total

    def dot(self, a: Iterable[Term], b: Iterable[Term]) -> Term:
        return self.sum([self.multiply(x, y) for x, y in zip(a, b, strict=True)])

    def text(self, results: Iterable[Term], indent: str = "    ") -> list[str]:
        needed: set[str] = set()
        waiting = [term.variable for term in results if term.variable]
        while waiting:
            variable = waiting.pop()
            if variable in self._statements and variable not in needed:
                needed.add(variable)
                waiting.extend(self._statements[variable][1])
        return [f"{indent}const float {v} = {e};" for v, (e, _) in self._statements.items() if v in needed]


def value(term: Term) -> str:
    """Returns the term as a C expression."""
    if term.variable is None:
        return literal(term.factor)
    if abs(term.factor) == 1.0:
        return term.variable if term.factor > 0 else f"-{term.variable}"
    return f"{literal(term.factor)} * {term.variable}"


def operations(lines: Sequence[str]) -> int:
    return sum(line.count(sign) for line in lines for sign in (" + ", " - ", " * ", " / "))
