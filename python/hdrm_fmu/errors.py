"""The exceptions that the package raises."""

from hdrm_fmu._native import RunFailed, WrongThread


class BadInput(ValueError):
    """An argument is not valid; nothing was run and no file was changed."""


class SweepStopped(RuntimeError):
    """A sweep cannot continue. Its results so far are kept in its folder, and the same call continues from them."""


__all__ = ["BadInput", "RunFailed", "SweepStopped", "WrongThread"]
