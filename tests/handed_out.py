"""Runs what `cargo xtask dist` and `cargo xtask wheel` have built as those get it to whom it is handed out: on this machine, in an old
Debian, under Wine and under QEMU. The same inputs must give the same numbers everywhere.

    python tests/handed_out.py run target/dist --work target/dist-check --platform linux64 --program linux64/torture=PATH …
    python tests/handed_out.py again target/dist --platform linux64       # builds it once more elsewhere: the same bytes?
    python tests/handed_out.py wheel WHEEL --work target/wheel-trial      # in an empty environment, with nothing in the search path
    python tests/handed_out.py prepare --work target/dist-check           # what the runs need

`cargo xtask dist --check`, `--again` and `cargo xtask wheel --trial` call it. It needs no packages.
"""

import argparse
import math
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LINUX, WINDOWS, ARM = "linux64", "win64", "aarch64-linux"
# The system of the table of experiments.
MANIPULATOR = "Manipulator.ssp"
# Random calls under Wine.
CALLS = "100000"
# Debian's package `libc6-arm64-cross`: the C library of that platform.
ARM_SYSTEM = Path("/usr/aarch64-linux-gnu")
# Numbers of ARM may differ from those of x86-64 by this part of the largest value of their signal: vector instructions of other widths add
# the products of the surrogate network in another order.
ARM_TOLERANCE = 1e-9
# Debian 11 of 2021, the oldest whose packages are still handed out.
RELEASE = "bullseye"
# Whom a program trusts that reaches the network.
CERTIFICATES = "etc/ssl/certs/ca-certificates.crt"
# The one library of Windows 10 that Wine 8 lacks and Rust programs need.
BCRYPT_PRIMITIVES = ROOT / "tests/bcryptprimitives.c"
# Pictures that the demo of the Python package draws; one with axes and a curve is no smaller, bytes.
FIGURES, PICTURE = ("tip.png", "energy.png"), 20_000


class Failed(Exception):
    """A run that failed, or numbers that differ."""


def execute(*command, **options):
    words = list(map(str, command))
    done = subprocess.run(words, **options)
    if done.returncode != 0:
        raise Failed(f"`{' '.join(words)}` ended with {done.returncode}")
    return done.stdout


def output(*command, **options):
    return execute(*command, stdout=subprocess.PIPE, text=True, **options)


def replaced(folder):
    """An empty folder in place of what was there."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder


def same(one, other):
    """Numbers of two CSV texts that must be equal in every digit; how many there are. The first that differs is named."""
    rows, others = one.splitlines(), other.splitlines()
    if len(rows) < 2:
        raise Failed("there are no numbers")
    if len(rows) != len(others):
        raise Failed(f"{len(rows)} lines and {len(others)} lines")
    names = rows[0].split(",")
    for k, (row, there) in enumerate(zip(rows, others)):
        if row != there:
            cells = zip(names, row.split(","), there.split(","))
            first, *more = [f"`{n}` is {a} and {b}" for n, a, b in cells if a != b] or ["the lines have different lengths"]
            raise Failed(f"row {k}: {first}" + (f", and {len(more)} more" if more else ""))
    return sum(row.count(",") + 1 for row in rows[1:])


def close(one, other, tolerance):
    """Numbers of two CSV texts, which may differ by a part of the largest value of their signal; how many there are, and the largest such
    part."""
    rows, others = ([line.split(",") for line in text.splitlines()] for text in (one, other))
    if rows[0] != others[0]:
        raise Failed("the signals differ")
    if len(rows) < 2 or len(rows) != len(others):
        raise Failed(f"{len(rows)} lines and {len(others)}")
    worst = 0.0
    for k, name in enumerate(rows[0]):
        pairs = [(float(a[k]), float(b[k])) for a, b in zip(rows[1:], others[1:])]
        for a, b in pairs:
            if not (math.isfinite(a) and math.isfinite(b)):
                raise Failed(f"`{name}` is {a} and {b}")
        difference = max(abs(a - b) for a, b in pairs)
        part = difference / max(abs(a) for a, _ in pairs) if difference else 0.0
        if part > tolerance:
            raise Failed(f"`{name}` differs by {difference:.1e}, which is {part:.1e} of its largest value")
        worst = max(worst, part)
    return (len(rows) - 1) * len(rows[0]), worst


class Debian:
    """An old Debian, unpacked into a folder unless it is there; with packages besides those that every Debian has."""

    def __init__(self, work, name=RELEASE, packages=()):
        self.root = work / name
        if not self.root.is_dir():
            self.unpack(work, name, packages)
        glibc = output(*self.command("ldd", "--version")).splitlines()[0].split()[-1]
        self.name = f"Debian {RELEASE}, glibc {glibc}"

    def unpack(self, work, name, packages):
        if not shutil.which("debootstrap"):
            raise Failed("debootstrap: `apt-get install debootstrap`")
        if os.geteuid() != 0:
            raise Failed("debootstrap and chroot need the user root")
        print(f"unpacking Debian {RELEASE} into {self.root}", flush=True)
        new = work / f"{name}.new"
        shutil.rmtree(new, ignore_errors=True)
        # Unpacked is enough: no package has to be set up.
        include = [f"--include={','.join(packages)}"] if packages else []
        with open(work / "debootstrap.log", "w") as log:
            try:
                execute("debootstrap", "--foreign", "--variant=minbase", *include, RELEASE, new, stdout=log)
            except Failed as error:
                raise Failed(f"Debian {RELEASE} could not be unpacked; {log.name} says why: {error}") from error
        if packages:
            # debootstrap has fetched them, but unpacks what every Debian has.
            for package in sorted((new / "var/cache/apt/archives").rglob("*.deb")):
                execute("dpkg-deb", "-x", package, new)
        # In a container debootstrap leaves a link here, which would lead to itself.
        if (new / "proc").is_symlink():
            (new / "proc").unlink()
            (new / "proc").mkdir()
        new.rename(self.root)

    def command(self, *words):
        """A program that runs in it. What shows processes is mounted for this command alone, so that nothing stays mounted after it."""
        inside = 'mount -t proc proc "$0/proc" && exec chroot "$0" "$@"'
        return ["unshare", "--mount", "sh", "-c", inside, self.root, *words]


class Wine:
    """Windows programs on Linux: Wine, with a Windows of its own."""

    def __init__(self, work):
        installed = shutil.which("wine64") or shutil.which("wine")
        debian = Path("/usr/lib/wine/wine64")
        self.program = installed or (debian if debian.is_file() else None)
        self.prefix = work / "wine"
        # No messages of its own, and no questions about add-ons.
        own = {"WINEPREFIX": str(self.prefix), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml="}
        self.environment = os.environ | own

    def prepare(self):
        system = self.prefix / "drive_c/windows/system32"
        if not system.is_dir():
            print(f"making a Windows in {self.prefix}", flush=True)
            execute(self.program, "wineboot", "--init", env=self.environment)
        library = system / "bcryptprimitives.dll"
        if not library.is_file():
            compiler = ["x86_64-w64-mingw32-gcc", "-shared", "-O1", "-s"]
            execute(*compiler, BCRYPT_PRIMITIVES, "-ladvapi32", "-o", library)


class Runs:
    """Runs of what lies in a folder `dist`, with a line about each in the file `listing`: platform, kind, text."""

    def __init__(self, arguments):
        self.dist, self.work = arguments.dist, arguments.work
        self.programs = dict(text.split("=", 1) for text in arguments.program)
        self.cargo_fmu, self.listing = arguments.cargo_fmu, open(arguments.listing, "w")
        self.systems = sorted(path.name for path in self.dist.glob("*.ssp"))
        self.fmus = sorted(self.dist.glob("*.fmu"))

    def say(self, platform, kind, text):
        print(platform, kind, text, sep="\t", file=self.listing, flush=True)

    def all(self, platforms):
        run = {LINUX: self.linux, WINDOWS: self.windows, ARM: self.arm}
        for platform in platforms:
            if platform in run:
                run[platform]()
            else:
                self.say(platform, "not run", "there is no machine of this kind here")

    def program(self, platform, name):
        try:
            return self.programs[f"{platform}/{name}"]
        except KeyError:
            raise Failed(f"`{name}` was not built for {platform}") from None

    def csv(self, system, place):
        return self.work / f"{system}.{place}.csv"

    def cosim(self, cosim, system, place, **options):
        """A system over its default experiment, with all outputs; the lines of the table that it writes."""
        csv = self.csv(system, place)
        execute(*cosim, *self.arguments(system, self.dist, csv), **options)
        return csv.read_text().count("\n")

    def arguments(self, system, folder, csv):
        words = ["run", "--quiet", "--signals", "*", "--system", folder / system, "--csv", csv]
        # Without its gains that machine swings, which is the hardest of these comparisons.
        return words + ["--variant", "bare.ssd"] * (system == "Real.ssp")

    def equal(self, system, place):
        """How many numbers that table has, which must be those of the run on this machine."""
        try:
            return same(self.csv(system, LINUX).read_text(), self.csv(system, place).read_text())
        except Failed as error:
            raise Failed(f"{system}: {LINUX} and {place}: {error}") from error

    def linux(self):
        for system in self.systems:
            lines = self.cosim([self.program(LINUX, "cosim")], system, LINUX)
            self.say(LINUX, "run", f"{system} in `cosim` on this machine: {lines} lines")
        try:
            debian = Debian(self.work)
        except Failed as why:
            self.say(LINUX, "lacks", f"in an old Debian: {why}")
        else:
            shutil.rmtree(debian.root / "dist", ignore_errors=True)
            shutil.copytree(self.dist, debian.root / "dist")
            for system in self.systems:
                execute(*debian.command("/dist/linux64/cosim", *self.arguments(system, Path("/dist"), "/tmp/run.csv")))
                shutil.copy(debian.root / "tmp/run.csv", self.csv(system, "debian"))
                numbers = self.equal(system, "debian")
                self.say(LINUX, "run", f"{system} in {debian.name}: {numbers} numbers equal in every digit")
        # What importers rely on, with the library for Linux.
        execute(self.cargo_fmu, "fmu", "check", "--strict", *self.fmus)
        self.say(LINUX, "run", f"`cargo fmu check --strict` of {len(self.fmus)} FMUs: nothing breaks the standard, nothing is not robust")

    def windows(self):
        wine = Wine(self.work)
        if wine.program is None:
            self.say(WINDOWS, "lacks", "there is no Wine: `apt-get install wine64`")
            return
        wine.prepare()

        def program(name):
            return [wine.program, self.program(WINDOWS, name)]

        for system in self.systems:
            lines = self.cosim(program("cosim"), system, WINDOWS, env=wine.environment)
            self.say(WINDOWS, "run", f"{system} in `cosim.exe` under Wine: {lines} lines")
        execute(*program("torture"), "calls", "--calls", CALLS, *self.fmus, env=wine.environment)
        self.say(WINDOWS, "run", f"{CALLS} random calls under Wine: all as the standard says")
        if f"{LINUX}/cosim" in self.programs:
            self.compare(program, wine.environment)
        else:
            self.say(WINDOWS, "not run", "comparison with Linux, which was not built")

    def compare(self, program, environment):
        """Linux and Windows: numbers of the runs, the table of experiments, and states that one saves and the other continues."""
        for system in self.systems:
            numbers = self.equal(system, WINDOWS)
            self.say(WINDOWS, "run", f"{system}: {numbers} numbers equal those on Linux in every digit")
        if f"{LINUX}/hdrm-fmu" in self.programs:
            table = ["table", "--system", self.dist / MANIPULATOR]
            rows = output(self.program(LINUX, "hdrm-fmu"), *table)
            count = rows.count("\n")
            if rows != output(*program("hdrm-fmu"), *table, env=environment) or count <= 10:
                raise Failed(f"`hdrm-fmu.exe table` differs from that on Linux:\n{rows}")
            self.say(WINDOWS, "run", f"`hdrm-fmu.exe table` prints the {count} lines of Linux")
        else:
            self.say(WINDOWS, "not run", "`hdrm-fmu.exe table`: it was left out")
        torture = {LINUX: [self.program(LINUX, "torture")], WINDOWS: program("torture")}
        for saves, continues in ((LINUX, WINDOWS), (WINDOWS, LINUX)):
            place = self.work / f"states-{saves}"
            place.mkdir(exist_ok=True)
            execute(*torture[saves], "save", "--to", place, *self.fmus, env=environment)
            execute(*torture[continues], "continue", "--from", place, *self.fmus, env=environment)
            self.say(continues, "run", f"states of {len(self.fmus)} FMUs saved by {saves} continue bit for bit")

    def arm(self):
        """FMUs of FMI 3.0 on ARM, whose instructions QEMU carries out."""
        qemu = shutil.which("qemu-aarch64")
        if not (qemu and ARM_SYSTEM.is_dir()):
            self.say(ARM, "lacks", "there is no QEMU with a system: `apt-get install qemu-user libc6-arm64-cross`")
            return
        csv = self.csv(MANIPULATOR, ARM)
        cosim = [qemu, "-L", ARM_SYSTEM, self.program(ARM, "cosim"), *self.arguments(MANIPULATOR, self.dist, csv)]
        execute(*cosim, "--fmi", "3", "--fmu-dir", self.dist)
        there = csv.read_text()
        lines = there.count("\n")
        self.say(ARM, "run", f"{MANIPULATOR} by FMI 3.0 in `cosim` under QEMU: {lines} lines")
        if f"{LINUX}/cosim" in self.programs:
            try:
                numbers, worst = close(self.csv(MANIPULATOR, LINUX).read_text(), there, ARM_TOLERANCE)
            except Failed as error:
                raise Failed(f"{LINUX} by FMI 2.0 and {ARM} by FMI 3.0: {error}") from error
            end = f"by at most {worst:.0e} of the signal's largest value"
            self.say(ARM, "run", f"{numbers} numbers of that run differ from those on {LINUX} by FMI 2.0 {end}")


def again(arguments):
    """Build the committed source in another folder with a target directory of its own, and compare the checksums."""
    place = Path(tempfile.mkdtemp(prefix="hdrm-dist-"))
    execute("git", "clone", "--quiet", ROOT, place / "source")
    platforms = [word for name in arguments.platform for word in ("--platform", name)]
    options = platforms + ["--without-experiments"] * arguments.without_experiments
    environment = {name: value for name, value in os.environ.items() if name != "CARGO_TARGET_DIR"}
    execute("cargo", "xtask", "dist", *options, cwd=place / "source", env=environment)
    other = place / "source/target/dist"
    mine, theirs = ((folder / "SHA256SUMS").read_text().splitlines() for folder in (arguments.dist, other))
    differing = [line for line in mine if line not in theirs]
    if differing:
        raise Failed(f"built again from the same commit in {other}, these files differ:\n" + "\n".join(differing))
    print(f"built again in {place}: the same {len(mine)} files")
    shutil.rmtree(place)


INSTALL = ["-m", "pip", "install", "--quiet"]
DEMO = ["-m", "hdrm_fmu", "demo", "--out"]


def wheel(arguments):
    """Install a wheel in an empty environment and run its demo, here and, if it is for any Linux, in an old Debian."""
    here = replaced(arguments.work / "here")
    empty, python = replaced(here / "empty"), here / "venv/bin/python"
    execute("python3", "-m", "venv", here / "venv")
    execute(python, *INSTALL, arguments.wheel)
    execute(python, *DEMO, here, env={"PATH": str(empty), "HOME": str(here)})
    check_figures(here)
    print("the wheel runs in an empty environment, with nothing in the search path")
    if "manylinux" not in arguments.wheel.name:
        return
    debian = Debian(arguments.work, f"{RELEASE}-python", ["python3-venv"])
    # What pip needs to reach the network as this system does.
    for file in ("etc/resolv.conf", "etc/hosts", CERTIFICATES):
        (debian.root / file).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(f"/{file}", debian.root / file)
    home, python = replaced(debian.root / "trial"), "/trial/venv/bin/python"
    shutil.copy(arguments.wheel, home)
    execute(*debian.command("/usr/bin/python3.9", "-m", "venv", "/trial/venv"))
    trusting = os.environ | {"PIP_CERT": f"/{CERTIFICATES}"}
    execute(*debian.command(python, *INSTALL, f"/trial/{arguments.wheel.name}"), env=trusting)
    execute(*debian.command(python, *DEMO, "/trial"), env=os.environ | {"HOME": "/trial"})
    check_figures(home)
    print(f"the wheel runs in {debian.name}")


def check_figures(folder):
    for name in FIGURES:
        size = (folder / name).stat().st_size
        if size <= PICTURE:
            raise Failed(f"{folder / name} has {size} bytes only")


def prepare(arguments):
    """Install what the runs need. What cannot be had here is listed when it is missing."""
    try:
        Debian(arguments.work)
    except Failed as why:
        print(f"no old Debian: {why}")
    wine = Wine(arguments.work)
    if wine.program is not None:
        wine.prepare()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    for name, run in (("run", lambda a: Runs(a).all(a.platform)), ("again", again), ("wheel", wheel), ("prepare", prepare)):
        command = commands.add_parser(name)
        command.set_defaults(run=run)
        if name in ("run", "again"):
            command.add_argument("dist", type=Path, help="folder of `cargo xtask dist`")
            command.add_argument("--platform", action="append", default=[])
        if name == "wheel":
            command.add_argument("wheel", type=Path)
        if name == "again":
            command.add_argument("--without-experiments", action="store_true")
        else:
            command.add_argument("--work", type=Path, required=True, help="folder for what the runs need and write")
        if name == "run":
            command.add_argument("--program", action="append", default=[], metavar="PLATFORM/NAME=PATH")
            command.add_argument("--cargo-fmu", help="program of `cargo fmu check`")
            command.add_argument("--listing", default=os.devnull, help="file for a line about each run")
    arguments = parser.parse_args()
    for name in ("dist", "work", "wheel"):
        if name in arguments:
            setattr(arguments, name, getattr(arguments, name).resolve())
    if "work" in arguments:
        arguments.work.mkdir(parents=True, exist_ok=True)
    try:
        arguments.run(arguments)
    except Failed as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
