"""The rooms of the package: nobody reaches into another's private parts, and imports make no circle."""

import ast
from collections import Counter
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import NamedTuple

import it2hys

PACKAGE = Path(it2hys.__file__).parent


class Import(NamedTuple):
    """A name of the package that a file imports."""

    file: str
    room: str
    module: str
    name: str

    @property
    def source(self) -> str:
        """The room that it comes from: a folder, or a file beside them."""
        return self.module.split(".")[1] if "." in self.module else self.name


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def is_module(i: Import) -> bool:
    place = PACKAGE.joinpath(*i.module.split(".")[1:], i.name)
    return place.is_dir() or place.with_suffix(".py").is_file()


@cache
def imports() -> tuple[Import, ...]:
    return tuple(i for path in sorted(PACKAGE.rglob("*.py")) for i in imports_of(path))


def imports_of(path: Path) -> Iterator[Import]:
    file = path.relative_to(PACKAGE).as_posix()
    room = file.partition("/")[0].removesuffix(".py")
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{file}: a relative import"
            if (node.module or "").partition(".")[0] == "it2hys":
                yield from (Import(file, room, node.module, alias.name) for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (
                Import(file, room, alias.name, "")
                for alias in node.names
                if alias.name.startswith("it2hys.")
            )


def test_no_room_imports_what_is_private_to_another():
    found = {
        (i.file, f"{i.module}.{i.name}")
        for i in imports()
        if i.source != i.room and any(map(is_private, [*i.module.split("."), i.name]))
    }
    assert not found


def test_no_room_uses_what_is_private_of_a_module_of_another():
    """As in ``compiled._library()``."""
    found = set()
    for path in sorted(PACKAGE.rglob("*.py")):
        others = {i.name for i in imports_of(path) if i.source != i.room and is_module(i)}
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Attribute)
                and isinstance(node.value, ast.Name)
                and node.value.id in others
                and is_private(node.attr)
            ):
                found.add((path.name, f"{node.value.id}.{node.attr}"))
    assert not found


def test_rooms_import_each_other_in_no_circle():
    graph = {}
    for i in imports():
        if i.room not in ("__init__", "__main__") and i.source != i.room:
            graph.setdefault(i.room, set()).add(i.source)
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        rooms = error.args[1]
        because = [
            f"{i.file}: {i.module}.{i.name}"
            for user, used in zip(rooms[1:], rooms, strict=False)
            for i in imports()
            if (i.room, i.source) == (user, used)
        ]
        raise AssertionError("\n".join([" <- ".join(rooms), *because])) from None


def test_no_two_rooms_have_a_file_of_one_name():
    """But for effects, whose names are the files of their physics and of their evidence."""
    names = Counter(
        path.name
        for path in PACKAGE.rglob("*.py")
        if path.name != "__init__.py" and path.parent.name not in ("effects", "evidence")
    )
    assert [name for name, count in names.items() if count > 1] == []


def test_no_test_skips_where_a_module_of_ours_is_missing():
    for path in sorted(Path(__file__).parents[1].rglob("test_*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "importorskip":
                assert not ast.unparse(node.args[0]).strip("'\"").startswith("it2hys"), path
