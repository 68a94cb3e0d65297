"""How a fault comes into a kernel and goes again: its source is edited, or what it gives is."""

from __future__ import annotations

import re
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any, Literal

import numpy as np
from numba.core.dispatcher import Dispatcher

Kind = Literal["sign", "dropped", "swapped", "float16", "guard", "other"]
"""A wrong sign; a term or step left out; axes or arrays that change places; a rounding to float16; a guard
against what has no value; a wrong order, number or place."""
Change = Callable[[], AbstractContextManager[None]]
QUICKER = (
    ("cache=True", "cache=False"),
    ("parallel=True", "parallel=False"),
    ('inline="always", error_model="numpy"', 'error_model="numpy"'),
    ('inline="always"', 'error_model="numpy"'),
)
"""What a kernel is compiled by here, for one look at what it gives."""
NUMBERS = (int, float, np.number)
OWN = ("renderer", "enhance", "tests.benchmarks.stability_faults")


@dataclass(frozen=True)
class Fault:
    """One, and the parts of the table that it concerns."""

    kernel: str
    kind: Kind
    what: str
    parts: tuple[str, ...]
    change: Change
    quick: bool = False
    """Among the few of a short run."""

    @property
    def name(self) -> str:
        return f"{self.kernel}, {self.kind}: {self.what}"


def edited(module: str, old: str, new: str, *also: str) -> Change:
    """The source of `module` with every `old` as `new`, compiled anew; and that of the modules `also`, into
    which its kernels are compiled."""

    @contextmanager
    def change() -> Iterator[None]:
        source = _source(module)
        if old not in source:
            raise ValueError(f"expected {old!r} in {module}")
        live = {name: import_module(name) for name in (module, *also)}
        fresh = {module: _executed(live[module], source.replace(old, new))}
        with _stands_for(module, fresh[module]):
            fresh |= {name: _executed(live[name], _source(name)) for name in also}
        with ExitStack() as stack:
            changed = {name: _changed(vars(live[name]), namespace) for name, namespace in fresh.items()}
            for name, namespace in fresh.items():
                _exchange(live[name], namespace, changed[name], stack)
            yield

    return change


def replaced(place: str, make: Callable[[Any], Any]) -> Change:
    """What stands at "module:name" or "module:class.name" is what `make` makes of it, wherever it was
    imported."""

    @contextmanager
    def change() -> Iterator[None]:
        module, _, path = place.partition(":")
        *owners, name = path.split(".")
        owner: Any = import_module(module)
        for each in owners:
            owner = getattr(owner, each)
        whole = vars(owner)[name]
        with ExitStack() as stack:
            if owners:
                _set(owner, name, make(whole), stack)
            else:
                _set_everywhere(whole, make(whole), stack)
            yield

    return change


def rounded(place: str, *filled: int) -> Change:
    """To float16: the arrays that a kernel is given to fill, by their place, or else what it returns."""

    def make(whole: Any) -> Any:
        def rounding(*args: Any, **named: Any) -> Any:
            result = whole(*args, **named)
            for place in filled:
                args[place][...] = _half(args[place])
            return result if filled else _half(result)

        return rounding

    return replaced(place, make)


def _half(values: Any) -> Any:
    if not isinstance(values, np.ndarray):
        return values
    with np.errstate(over="ignore"):
        return values.astype(np.float16).astype(values.dtype)


def _source(module: str) -> str:
    """As kernels compile fastest, and never into the files that keep the true ones."""
    path = import_module(module).__file__
    assert path is not None
    source = Path(path).read_text(encoding="utf-8")
    for fast, quick in QUICKER:
        source = source.replace(fast, quick)
    return source


def _executed(live: ModuleType, source: str) -> dict[str, Any]:
    """What the source makes, with the classes of `live`."""
    name = live.__name__
    namespace: dict[str, Any] = {"__name__": name}
    exec(compile(source, f"<{name} with a fault>", "exec"), namespace)
    _adopt(namespace, vars(live))
    return namespace


@contextmanager
def _stands_for(name: str, namespace: dict[str, Any]) -> Iterator[None]:
    """For what imports it meanwhile."""
    live = sys.modules[name]
    sys.modules[name] = ModuleType(name)
    vars(sys.modules[name]).update(namespace)
    try:
        yield
    finally:
        sys.modules[name] = live


def _is_own(value: Any, module: str) -> bool:
    return getattr(value, "__module__", None) == module


def _adopt(namespace: dict[str, Any], live: dict[str, Any]) -> None:
    """Classes and all that is no kernel, function or number stay those that everyone else holds."""
    for name, value in list(namespace.items()):
        kept = (FunctionType, Dispatcher, ModuleType, bool, int, float, complex)
        is_number = type(value).__module__ == "numpy"
        if name in live and not name.startswith("__") and not isinstance(value, kept) and not is_number:
            if isinstance(value, type) and _is_own(value, namespace["__name__"]):
                namespace[f"{name} with a fault"] = value
            namespace[name] = live[name]


def _exchange(live: ModuleType, namespace: dict[str, Any], changed: set[str], stack: ExitStack) -> None:
    """Kernels, functions and methods with another code, or that use such: no others are compiled anew."""
    for name, value in namespace.items():
        if name.endswith(" with a fault"):
            _exchange_methods(getattr(live, name.removesuffix(" with a fault")), value, stack)
        elif name in changed and isinstance(value, NUMBERS):
            _set(live, name, value, stack)
        elif name in changed and _is_own(value, live.__name__) and _code(value):
            _set_everywhere(vars(live)[name], value, stack)


def _changed(live: dict[str, Any], namespace: dict[str, Any]) -> set[str]:
    """Names that mean something else than they did, of themselves or by what they use."""
    changed = {
        name
        for name, value in namespace.items()
        if name in live and (_is_other(live[name], value) or _is_import(live[name], value, namespace))
    }
    users = {name: _facts(code)[1] for name, value in namespace.items() if (code := _code(value))}
    while more := {name for name, used in users.items() if name not in changed and changed & set(used)}:
        changed |= more
    return changed & set(live)


def _is_other(old: Any, new: Any) -> bool:
    one, other = _code(old), _code(new)
    if one and other:
        return _facts(one) != _facts(other)
    return isinstance(new, NUMBERS) and old != new


def _is_import(old: Any, new: Any, namespace: dict[str, Any]) -> bool:
    """Of a kernel from another module that is compiled anew."""
    return old is not new and isinstance(new, Dispatcher) and not _is_own(new, namespace["__name__"])


def _code(value: Any) -> CodeType | None:
    """Of a function or kernel."""
    plain = value.py_func if isinstance(value, Dispatcher) else value
    return plain.__code__ if isinstance(plain, FunctionType) else None


def _exchange_methods(owner: type, faulty: type, stack: ExitStack) -> None:
    for name, value in vars(faulty).items():
        if name in vars(owner) and _is_other(_plain(vars(owner)[name]), _plain(value)):
            _set(owner, name, value, stack)


def _plain(method: Any) -> Any:
    """The function in a property or a class method."""
    return getattr(method, "fget", None) or getattr(method, "__func__", method)


def _facts(code: CodeType) -> tuple[bytes, tuple[str, ...], tuple[Any, ...]]:
    """What it does, the names it uses and its constants; not where it stands."""
    inner = [_facts(each) for each in code.co_consts if isinstance(each, CodeType)]
    constants = tuple(repr(each) for each in code.co_consts if not isinstance(each, CodeType))
    names = code.co_names + tuple(name for each in inner for name in each[1])
    return code.co_code, names, (*constants, *inner)


def _set_everywhere(old: Any, new: Any, stack: ExitStack) -> None:
    """In each module that holds it, by a name or in a table."""
    for name, module in list(sys.modules.items()):
        if not re.match(rf"({'|'.join(OWN)})(\.|$)", name):
            continue
        for key, value in list(vars(module).items()):
            if value is old:
                _set(module, key, new, stack)
            elif isinstance(value, dict) and not key.startswith("__"):
                for place in [place for place, each in value.items() if each is old]:
                    stack.callback(value.__setitem__, place, old)
                    value[place] = new


def _set(owner: Any, name: str, value: Any, stack: ExitStack) -> None:
    stack.callback(setattr, owner, name, vars(owner)[name])
    setattr(owner, name, value)
