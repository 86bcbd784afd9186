"""What can go wrong."""

from hdrm_fmu._native import RunFailed


class BadInput(ValueError):
    """What was asked for makes no sense; nothing was run and no file was changed."""


class SweepStopped(RuntimeError):
    """A sweep cannot go on. What it has is kept in its folder, and the same call goes on from there."""


__all__ = ["BadInput", "RunFailed", "SweepStopped"]
