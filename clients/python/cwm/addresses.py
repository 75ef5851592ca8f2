"""Where a server is when nobody says otherwise, and whether another user could answer there: by the
rules of proto/transfer/default_address.h.
"""

from __future__ import annotations

import os
import stat

import grpc

from cwm import errors

_WAYS_OUT = (
    "; another user could answer there: choose an address with CWM_ADDR or cwm.connect(ADDRESS), "
    "or set XDG_RUNTIME_DIR to a directory of your own"
)


def default_address() -> str:
    """$CWM_ADDR, else "unix:$XDG_RUNTIME_DIR/cwm-$UID.sock", else "unix:/tmp/cwm-$UID/cwm.sock".
    Empty variables count as unset.
    """
    chosen = os.environ.get("CWM_ADDR")
    if chosen:
        return chosen
    folder = os.environ.get("XDG_RUNTIME_DIR")
    if folder:
        return f"unix:{folder}/cwm-{os.getuid()}.sock"
    return f"unix:{_folder_in_tmp()}/cwm.sock"


def prepare_default_address() -> None:
    """Before `default_address` is dialed: PermissionDenied where another user than this one and
    root can have put a socket there, Unavailable where XDG_RUNTIME_DIR does not exist.

    Makes /tmp/cwm-$UID when it is missing: another user could make it between the check and the
    connection. $CWM_ADDR is the user's own choice, and is not checked.
    """
    if os.environ.get("CWM_ADDR"):
        return
    folder = os.environ.get("XDG_RUNTIME_DIR")
    if not folder:
        make_private_folder(_folder_in_tmp())
    elif os.path.lexists(folder):
        check_folder(folder, private=False, name="XDG_RUNTIME_DIR: ")
    else:
        raise errors.Unavailable(
            f"no cwm-server answers at {default_address()}: XDG_RUNTIME_DIR does not exist",
            code=grpc.StatusCode.UNAVAILABLE,
        )


def make_private_folder(path: str) -> None:
    """Makes the directory with mode 0700 when nothing is there, then checks it."""
    try:
        os.mkdir(path, 0o700)
    except FileExistsError:
        pass
    except OSError as error:
        raise _denied(f"{path}: cannot be made: {error.strerror}") from None
    check_folder(path, private=True)


def check_folder(path: str, *, private: bool, name: str = "") -> None:
    """PermissionDenied for what is not a directory of this user's: private, without any permission
    for group and others; else (or root's) one that they cannot write to.
    """
    try:
        fault = _fault_of(os.lstat(path.rstrip("/") or "/"), private)
    except OSError as error:
        fault = error.strerror
    if fault:
        raise _denied(f"{name}{path}: {fault}")


def _fault_of(info: os.stat_result, private: bool) -> str:
    user, mode = os.getuid(), stat.S_IMODE(info.st_mode)
    if stat.S_ISLNK(info.st_mode):
        return "is a symbolic link, must be a directory"
    if not stat.S_ISDIR(info.st_mode):
        return "is no directory, must be one"
    if info.st_uid != user and (private or info.st_uid != 0):
        rule = "" if private else " or root"
        return f"belongs to user {info.st_uid}, must belong to user {user}{rule}"
    if private and mode & 0o077:
        return f"has mode {mode:04o}, must have 0700"
    if not private and mode & 0o022:
        return f"has mode {mode:04o}, must not be writable by its group or others"
    return ""


def _folder_in_tmp() -> str:
    return f"/tmp/cwm-{os.getuid()}"


def _denied(message: str) -> errors.PermissionDenied:
    return errors.PermissionDenied(message + _WAYS_OUT, code=grpc.StatusCode.PERMISSION_DENIED)
