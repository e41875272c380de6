"""What classes of the user's own have in common."""

from __future__ import annotations

from typing import Generic, TypeVar, cast

T = TypeVar("T")


class Own(Generic[T]):
    """A Python object with its counterpart in the extension module, which keeps it for as long as the process runs: of one object one."""

    def _counterpart(self) -> T:
        raise NotImplementedError

    def _core(self) -> T:
        known = self.__dict__.get("_own")
        if known is None:
            known = self.__dict__["_own"] = self._counterpart()
        return cast(T, known)

    def __getstate__(self) -> dict[str, object]:
        # To another process the object travels without it.
        return {name: value for name, value in self.__dict__.items() if name != "_own"}
